"""Dynamic item: the sources of an FMU, compiled and compared with its binary."""

import shutil
import subprocess
import sys
from collections.abc import Iterator

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
