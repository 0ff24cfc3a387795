"""Dynamic items: loading, instances, and what one FMU does to another."""

import gc
import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException

from orchestrator.checks.interface import required_functions
from orchestrator.checks.item import (
    CannotRun,
    Finding,
    NotApplicable,
    Said,
    advice,
    dynamic,
)
from orchestrator.checks.laboratory import (
    DISCARD,
    OK,
    STATUS,
    STEPS,
    Laboratory,
    Row,
    same,
)


@dynamic(
    8,
    "Its own start values make a model that runs",
    "implementers' guide 5.2",
    "choose defaults with which the model can be initialised and stepped",
)
def runs(lab: Laboratory) -> Iterator[Said]:
    with lab.running() as one:
        rows = one.run(STEPS, excited=False)
    if not np.isfinite(rows).all():
        yield Finding(f"a value is not finite within {STEPS} steps of {lab.h:g} s")
    yield f"{STEPS} steps of {lab.h:g} s by {lab.kind}"


@dynamic(
    11,
    "The library loads and exports every function",
    "FMI 2.0.5 section 2.1; FMI 3.0.2 section 2.5; implementers' guide 3.7",
    "export every function of the interface; what is not supported returns Error "
    "and logs why",
)
def loads(lab: Laboratory) -> Iterator[Said]:
    import ctypes

    import fmpy

    description = lab.description
    host = fmpy.platform if description.fmi_major == 2 else fmpy.platform_tuple
    name = f"{description.model_identifier}{fmpy.sharedLibraryExtension}"
    file = lab.folder / "binaries" / host / name
    if not file.is_file():
        there = ", ".join(description.platforms) or "none"
        raise CannotRun(
            f"it has no binary for this machine (binaries/{host}/{name}), only: {there}"
        )
    lab.trying("loading the library")
    try:
        library = ctypes.CDLL(str(file))
    except OSError as error:
        text = str(error).replace(f"{lab.folder}/", "")
        yield Finding(
            f"the library does not load: {text}",
            mend="install that library, or ask the supplier to link it statically",
        )
        return
    wanted = required_functions(lab.kind, description.fmi_major)
    missing = [name for name in wanted if not hasattr(library, name)]
    for function in missing:
        yield Finding(f"{function} is not exported, so importers cannot load it")
    yield f"{len(wanted) - len(missing)} of {len(wanted)} functions exported"
    if not missing:
        yield from _unsupported(lab)


def _unsupported(lab: Laboratory) -> Iterator[Said]:
    """What is declared unsupported has to be refused, not half done."""
    if lab.interface.canGetAndSetFMUstate:
        return
    with lab.running() as one:
        lab.trying("calling GetFMUState, which is not supported")
        if one.status(one.fmu.getFMUState) == OK:
            yield advice("canGetAndSetFMUstate = false, but getting it returns OK")


@dynamic(
    12,
    "A wrong token gives no instance, and no crash",
    "FMI 2.0.5 section 2.1.5; FMI 3.0.2 section 2.3.1; implementers' guide 5.1",
    "compare the token with the one the binary was built with, log the difference "
    "and return NULL",
)
def token_checked(lab: Laboratory) -> Iterator[Said]:
    with lab.instance("wrong", token="{not-the-token-of-this-fmu}") as wrong:
        if wrong.exists:
            yield Finding("an instance is made with a wrong guid or token")
        elif not wrong.messages:
            yield advice("a wrong guid or token is refused without a message")
    with lab.instance("") as nameless:
        if nameless.exists:
            yield advice(
                "an instance without a name is made",
                "refuse an empty instanceName with a message",
            )
    with lab.instance("right") as right:
        if not right.exists:
            yield Finding("no instance is made with the token of the description")


@dynamic(
    14,
    "Instances do not know of each other",
    "FMI 2.0.5 section 4.3.1; FMI 3.0.2 section 2.4.1",
    "keep the state of an instance in the instance, not in global variables",
)
def independent(lab: Laboratory) -> Iterator[Said]:
    alone = lab.trajectory()
    if lab.interface.canBeInstantiatedOnlyOncePerProcess:
        with lab.running("first"):
            lab.trying("making a second instance, which is declared impossible")
            with lab.instance("second") as second:
                if second.exists:
                    yield Finding(
                        "canBeInstantiatedOnlyOncePerProcess, but a second instance "
                        "is made"
                    )
    else:
        with lab.running("first") as first, lab.running("second") as second:
            rows = []
            for k in range(STEPS):
                for instance, phase in ((first, k), (second, k + 7)):
                    instance.excite(phase)
                    instance.step(k * lab.h, lab.h)
                rows.append(first.row())
        if not same(np.array(rows), alone):
            yield Finding("an instance gives other values while a second one is run")
    lab.trying("loading the library again after it was freed")
    if not same(lab.trajectory(name="again"), alone):
        yield Finding("after freeing and loading again the values differ")


@dynamic(
    15,
    "Threads, working directory and output of the host are left alone",
    "FMI 2.0.5 section 2.1.5; implementers' guide 3; fmi-standard issue 2151",
    "do not change or use what belongs to the whole process; log through the "
    "callback instead of printing",
)
def good_guest(lab: Laboratory) -> Iterator[Said]:
    import locale

    before = Path.cwd(), locale.setlocale(locale.LC_ALL)
    alone = lab.trajectory()
    if before[0] != Path.cwd():
        yield Finding("the working directory of the process is changed")
    if before[1] != locale.setlocale(locale.LC_ALL):
        yield Finding("the locale of the process is changed")
    if printed := lab.printed().strip():
        text = printed[:80].decode("utf-8", "replace")
        yield advice(f"it prints to stdout or stderr: {text!r}")
    if lab.interface.canBeInstantiatedOnlyOncePerProcess:
        return
    lab.trying("running two instances in two threads")
    with ThreadPoolExecutor(2) as pool:
        jobs = [pool.submit(lab.trajectory, name=f"thread {i}") for i in range(2)]
        for job in jobs:
            if not same(job.result(), alone):
                yield Finding("two instances in two threads give other values")


@dynamic(
    28,
    "Every refusal has a message, and off is silent",
    "FMI 2.0.5 section 2.1.5 (loggingOn); FMI 3.0.2 section 2.2.3",
    "log why a call did not return OK; without loggingOn log nothing",
)
def logging(lab: Laboratory) -> Iterator[Said]:
    with lab.running(logging=False) as silent:
        silent.run(5)
    if silent.messages:
        yield advice(f"loggingOn = false, but it logs {silent.messages[0][2]!r}")
    with lab.running() as one:
        one.run(5)
        one.messages.clear()
        lab.trying("reading a variable that does not exist")
        status = one.status(_read_unknown, one)
        if status >= DISCARD and not one.messages:
            yield advice(f"a refused call ({STATUS[status]}) leaves no message")
    declared = {c.name for c in lab.model.logCategories or ()}
    used = {category for _, category, _ in one.messages if category}
    if used - declared:
        yield advice(
            f"log categories not declared: {', '.join(sorted(used - declared))}"
        )
    if any("%s" in text or "%d" in text for *_, text in one.messages):
        yield advice("messages hold unformatted %s or %d")


def _read_unknown(instance: Any) -> None:
    taken = {v.reference for v in instance.lab.description.variables.values()}
    free = max(taken, default=0) + 100_000
    read = instance.fmu.getReal if hasattr(instance.fmu, "getReal") else None
    (read or instance.fmu.getFloat64)([free])


@dynamic(
    29,
    "Memory does not grow",
    "implementers' guide 3",
    "free in fmi2FreeInstance what fmi2Instantiate took, and in a step what the step "
    "took",
    seconds=60.0,
)
def memory(lab: Laboratory) -> Iterator[Said]:
    try:
        _resident()
    except OSError:
        raise NotApplicable("the memory of a process is only read on Linux") from None
    with lab.running("base", logging=False) as one:
        growth = []
        for first in (0, 2000):  # the first time buffers and caches may fill
            before = _resident()
            lab.trying("stepping 2000 times")
            for k in range(first, first + 2000):
                one.step(k * lab.h, lab.h)
            growth.append(_resident() - before)
        steps = growth[1]
    if steps > 1 << 20:
        yield Finding(f"2000 steps take {steps / 2**20:.1f} MiB that are not freed")
    if lab.interface.canBeInstantiatedOnlyOncePerProcess:
        return
    growth = []
    with lab.instance("holder"):  # keeps the library loaded
        for _ in range(2):
            before = _resident()
            lab.trying("making and freeing 100 instances")
            for i in range(100):
                with lab.running(f"number {i}", logging=False):
                    pass
            growth.append(_resident() - before)
    if growth[1] > 1 << 20:
        yield Finding(
            f"100 instances take {growth[1] / 2**20:.1f} MiB that are not freed"
        )
    yield f"{max(0, steps)} bytes in 2000 steps, {growth[1]} in 100 instances"


def _resident() -> int:
    gc.collect()  # the host's own rubbish is not the FMU's
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


def _second_run(lab: Laboratory) -> Iterator[Said]:
    first: Row = lab.kept["rows"]
    if not same(lab.trajectory(), first):
        differ = int(np.sum(np.any(lab.trajectory() != first, axis=1)))
        yield Finding(
            f"a second process gives other values in {differ} of {STEPS} rows"
        )


@dynamic(
    35,
    "Two runs give the same bits",
    "FMI 2.0.5 section 4.2.2; implementers' guide 3",
    "leave out clocks, random numbers without a seed and uninitialised memory",
    then=_second_run,
)
def deterministic(lab: Laboratory) -> Iterator[Said]:
    lab.kept["rows"] = lab.trajectory()
    yield f"{STEPS} rows of {lab.kept['rows'].shape[1]} values"


@dynamic(
    25,
    "Tolerance, stop time and an early end are optional",
    "FMI 2.0.5 section 2.1.6; FMI 3.0.2 section 2.3.2",
    "accept setupExperiment with and without tolerance and stop time, and "
    "terminate or freeInstance at any moment",
)
def experiment(lab: Laboratory) -> Iterator[Said]:
    for stop in (None, 1000 * lab.h):
        for tolerance in (None, 1e-6):
            lab.trying(f"initialising with stop = {stop}, tolerance = {tolerance}")
            with lab.instance("one") as one:
                try:
                    one.begin(stop=stop, tol=tolerance)
                    one.run(3)
                except FMICallException as error:
                    yield Finding(f"stop = {stop}, tolerance = {tolerance}: {error}")
    lab.trying("freeing an instance that was never initialised")
    with lab.instance("unused"):
        pass
    lab.trying("freeing an instance without terminating it")
    with lab.instance("unfinished") as one:
        one.begin()
        one.run(2)
        one.initialised = False
