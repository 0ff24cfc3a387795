"""Dynamic items: loading, making instances, and running from start values."""

import ctypes
from collections.abc import Iterator

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException

from orchestrator.checks.archive import Archive
from orchestrator.checks.instance import OK, Row, same
from orchestrator.checks.interface import required_functions
from orchestrator.checks.item import (
    CannotRun,
    Finding,
    Said,
    advice,
    dynamic,
)
from orchestrator.checks.laboratory import STEPS, Laboratory


@dynamic(
    8,
    "Its own start values make a model that runs",
    "implementers' guide 5.2",
    "choose defaults with which the model can be initialised and stepped",
)
def runs(lab: Laboratory) -> Iterator[Said]:
    with lab.running() as one:
        rows = one.run(STEPS, excited=False)
    if not len(rows):
        yield advice("it ends the run in its first step")
    if not np.isfinite(rows).all():
        yield Finding(f"a value is not finite within {STEPS} steps of {lab.h:g} s")
    yield f"{len(rows)} steps of {lab.h:g} s by {lab.kind}"


@dynamic(
    11,
    "The library loads and exports every function",
    "FMI 2.0.5 section 2.1; FMI 3.0.2 section 2.5; implementers' guide 3.7",
    "export every function of the interface; what is not supported returns Error "
    "and logs why",
)
def loads(lab: Laboratory) -> Iterator[Said]:
    description, kind = lab.description, lab.kind
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
    wanted = required_functions(kind, description.fmi_major)
    missing = [name for name in wanted if not hasattr(library, name)]
    for function in missing:
        yield Finding(f"{function} is not exported, so importers cannot load it")
    yield f"{len(wanted) - len(missing)} of {len(wanted)} functions exported"
    if not missing:
        yield from _unsupported(lab)


def _unsupported(lab: Laboratory) -> Iterator[Said]:
    """What is declared unsupported has to be refused, not half done."""
    derivatives = ("providesDirectionalDerivative", "providesDirectionalDerivatives")
    interfaces = Archive(lab.description.path).interfaces()
    real = [
        next((v for v in lab.variables(causality=c) if v.sort == "real"), None)
        for c in ("output", "input")
    ]
    lab.trying("making an instance")
    with lab.instance() as one:
        if not one.exists:  # that is for the item of tokens
            return
        one.begin()
        if not lab.interface.canGetAndSetFMUstate:
            lab.trying("calling GetFMUState, which is not supported")
            if one.status(one.fmu.getFMUState) == OK:
                yield advice("canGetAndSetFMUstate = false, but getting it returns OK")
    if any(e.get(name) for e in interfaces for name in derivatives):
        return
    if real[0] and real[1]:
        unknown, known = real[0].reference, real[1].reference
        seed, size = [1.0] * real[1].size, real[0].size
        with lab.running() as one:  # another one: an Error may have ended the first
            lab.trying("asking for derivatives, which are not supported")
            if one.status(one.face.directional, [unknown], known, seed, size) == OK:
                yield advice("directional derivatives are not declared, but given")


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
                    if not instance.ended:
                        instance.excite(phase)
                    instance.step(k * lab.h, lab.h)
                if first.ended:
                    break
                rows.append(first.row())
        if not same(np.array(rows).reshape(len(rows), alone.shape[1]), alone):
            yield Finding("an instance gives other values while a second one is run")
    lab.trying("loading the library again after it was freed")
    if not same(lab.trajectory(name="again"), alone):
        yield Finding("after freeing and loading again the values differ")


def _second_run(lab: Laboratory) -> Iterator[Said]:
    first: Row = lab.kept["rows"]
    second = lab.trajectory()
    if second.shape != first.shape:
        yield Finding(
            f"a second process ends after {len(second)} steps, the first after "
            f"{len(first)}"
        )
    elif not same(second, first):
        differ = int(np.sum(np.any(second != first, axis=1)))
        yield Finding(
            f"a second process gives other values in {differ} of {len(first)} rows"
        )


@dynamic(
    35,
    "Two runs give the same bits",
    "FMI 2.0.5 section 4.2.2; implementers' guide 3",
    "leave out clocks, random numbers without a seed and uninitialised memory",
    then=_second_run,
)
def deterministic(lab: Laboratory) -> Iterator[Said]:
    rows = lab.kept["rows"] = lab.trajectory()
    yield f"{len(rows)} rows of {rows.shape[1]} values"


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
                    one.begin(0.0, stop, tolerance)
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
