"""Dynamic items: folders the FMU is unpacked in, and its sources compiled."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from orchestrator.checks.archive import Archive
from orchestrator.checks.files import source_files
from orchestrator.checks.item import (
    CannotRun,
    Finding,
    NotApplicable,
    Said,
    advice,
    dynamic,
)
from orchestrator.checks.laboratory import Laboratory, same

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
    34,
    "Its sources compile and give the values of its binary",
    "FMI 2.0.5 section 4.3.1; FMI 3.0.2 section 2.5.1; implementers' guide",
    "correct what the compiler says; build the binary from these sources",
    seconds=180.0,
)
def sources(lab: Laboratory) -> Iterator[Said]:
    archive = Archive(lab.description.path)
    files = source_files(archive)
    if not files:
        raise NotApplicable("it has no sources")
    from fmus.compile import PLATFORMS, CompileError, host_platform
    from fmus.native_source import adapter_sources

    try:
        target = PLATFORMS[host_platform()]
    except CompileError as error:
        raise CannotRun(str(error)) from None
    wanted = lab.trajectory()
    fmi2 = lab.description.fmi_major == 2
    folder = lab.folder / ".compiled"
    binaries = folder / "binaries"
    binaries /= target.fmi2_folder if fmi2 else target.fmi3_folder
    binaries.mkdir(parents=True)
    if (lab.folder / "resources").is_dir():
        shutil.copytree(lab.folder / "resources", folder / "resources")
    library = binaries / f"{lab.description.model_identifier}{target.suffix}"
    headers = folder / "headers"  # those of the standard need not be in the archive
    headers.mkdir()
    for name, text in adapter_sources().items():
        if name.startswith(("fmi2", "fmi3")) and name.endswith(".h"):
            (headers / name).write_text(text, encoding="utf-8")
    lab.trying("compiling the sources")
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target.triple]
    command += ["-shared", "-fPIC", "-O2", "-Wall", "-ffp-contract=off"]
    command += [
        "-mcpu=baseline",
        "-I.",
        "-idirafter",
        str(headers),
        "-o",
        str(library),
        *files,
        "-lm",
    ]
    done = subprocess.run(
        command,
        cwd=lab.folder / "sources",
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    complaints = [
        line
        for line in done.stderr.splitlines()
        if "warning:" in line or "error:" in line
    ]
    if done.returncode:
        errors = [line for line in complaints if "error:" in line]
        told = errors[0] if errors else done.stderr[-200:]
        yield Finding(f"the sources do not compile: {told}")
        return
    if complaints:
        yield advice(f"{len(complaints)} compiler warnings, first: {complaints[0]}")
    with lab.instance("compiled", folder=folder) as one:
        one.begin()
        rows = one.run(len(wanted))
    if not same(rows, wanted, 1e-9):
        yield Finding("the sources give other values than the binary")
    yield f"{len(files)} files compiled" + (", bit-equal" if same(rows, wanted) else "")
