"""Dynamic items: how an FMU treats its host, and where it may be unpacked."""

import gc
import locale
import os
import shutil
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from pathlib import Path

from orchestrator.checks.instance import DISCARD, same
from orchestrator.checks.item import (
    Finding,
    NotApplicable,
    Said,
    advice,
    dynamic,
)
from orchestrator.checks.laboratory import Laboratory
from orchestrator.instances.group import told

FOLDERS = {
    "with spaces": "a folder with spaces",
    "outside ASCII": "Vorschub-Prüfstand-é",
    "with a long name": "n" * 120,
}


def _elsewhere(lab: Laboratory) -> Iterator[Said]:
    wanted = lab.trajectory()
    os.chdir(Path(lab.folder).anchor)
    lab.trying("running with another working directory")
    if not same(lab.trajectory(), wanted):
        yield Finding("in another working directory the values differ")


@dynamic(
    13,
    "It runs from any folder",
    "FMI 2.0.5 section 2.1.5 (fmuResourceLocation); FMI 3.0.2 section 2.3.1",
    "decode the resource URI (percent signs, UTF-8), keep no fixed buffer for paths, "
    "write nothing into resources/",
    then=_elsewhere,
)
def folders(lab: Laboratory) -> Iterator[Said]:
    wanted = lab.trajectory()
    for what, name in FOLDERS.items():
        folder = lab.folder / ".moved" / name
        shutil.copytree(
            lab.folder, folder, ignore=shutil.ignore_patterns(".moved", "sources")
        )
        lab.trying(f"running from a folder {what}")
        try:
            with lab.instance("moved", folder=folder) as one:
                if not one.exists:
                    said = "; ".join(text for *_, text in one.messages[-2:])
                    yield Finding(f"no instance in a folder {what}: {said}")
                    continue
                one.begin()
                if not same(one.run(len(wanted)), wanted):
                    yield Finding(f"in a folder {what} the values differ")
        finally:
            shutil.rmtree(folder, ignore_errors=True)
    lab.trying("running with resources that cannot be written")
    resources = lab.folder / "resources"
    if resources.is_dir():
        resources.chmod(0o555)
        try:
            if not same(lab.trajectory(), wanted):
                yield Finding("with read-only resources the values differ")
        finally:
            resources.chmod(0o755)


@dynamic(
    15,
    "Threads, working directory and output of the host are left alone",
    "FMI 2.0.5 section 2.1.5; implementers' guide 3; fmi-standard issue 2151",
    "do not change or use what belongs to the whole process; log through the "
    "callback instead of printing",
)
def good_guest(lab: Laboratory) -> Iterator[Said]:
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
        status = one.status(one.read_unknown)
        if status >= DISCARD and not one.messages:
            yield advice(f"a refused call ({told(status)}) leaves no message")
    declared = {c.name for c in lab.model.logCategories or ()}
    used = {category for _, category, _ in one.messages if category}
    if used - declared:
        yield advice(
            f"log categories not declared: {', '.join(sorted(used - declared))}"
        )
    if any("%s" in text or "%d" in text for *_, text in one.messages):
        yield advice("messages hold unformatted %s or %d")


@dynamic(
    29,
    "Memory does not grow",
    "implementers' guide 3",
    "free in fmi2FreeInstance what fmi2Instantiate took, and in a step what the step "
    "took",
    seconds=120.0,
)
def memory(lab: Laboratory) -> Iterator[Said]:
    try:
        _resident()
    except OSError:
        raise NotApplicable("the memory of a process is only read on Linux") from None
    with lab.running("base", logging=False) as one:
        growth = []
        taken = count()
        for _ in range(2):  # the first time buffers and caches may fill
            before = _resident()
            lab.trying("stepping 2000 times")
            many = lab.as_many(
                2000, lambda k: one.step(next(taken) * lab.h, lab.h), 20.0
            )
            growth.append(_resident() - before)
            if many < 2000:
                break
        steps = growth[-1]
    if steps > 1 << 20 and many == 2000:
        yield Finding(f"2000 steps take {steps / 2**20:.1f} MiB that are not freed")
    if lab.interface.canBeInstantiatedOnlyOncePerProcess:
        return
    growth = []
    with lab.instance("holder"):  # keeps the library loaded
        for _ in range(2):
            before = _resident()
            lab.trying("making and freeing 100 instances")
            made = lab.as_many(100, lambda i: _begin_and_free(lab, i), 20.0)
            growth.append(_resident() - before)
            if made < 100:
                break
    if growth[-1] > 1 << 20 and made == 100:
        yield Finding(
            f"100 instances take {growth[1] / 2**20:.1f} MiB that are not freed"
        )
    yield f"{max(0, steps)} bytes in {many} steps, {growth[-1]} in {made} instances"


def _begin_and_free(lab: Laboratory, i: int) -> None:
    with lab.running(f"number {i}", logging=False):
        pass


def _resident() -> int:
    gc.collect()  # the host's own rubbish is not the FMU's
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")
