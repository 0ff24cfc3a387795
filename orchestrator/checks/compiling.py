"""Dynamic item: the sources of an FMU, compiled and compared with its binary.

They are compiled as the FMU says (``sources``).  Their functions may have the
model identifier as a prefix, as both standards want it of sources that are linked
statically.
"""

import ctypes
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from time import monotonic

from orchestrator.checks.archive import Archive
from orchestrator.checks.instance import same
from orchestrator.checks.item import (
    CannotRun,
    Finding,
    NotApplicable,
    Said,
    advice,
    dynamic,
)
from orchestrator.checks.laboratory import Laboratory
from orchestrator.checks.sources import SourceSet, libraries, source_sets

PATIENCE = 240.0  # s on the clock that compiling may take


@dynamic(
    34,
    "Its sources compile and give the values of its binary",
    "FMI 2.0.5 section 4.3.1; FMI 3.0.2 section 2.5.1; implementers' guide",
    "correct what the compiler says; build the binary from these sources",
    seconds=300.0,
)
def sources(lab: Laboratory) -> Iterator[Said]:
    archive, identifier = Archive(lab.description.path), _identifier(lab)
    sets = source_sets(archive, identifier)
    files = [file for group in sets for file in group.files]
    if not files:
        raise NotApplicable("it has no sources for this machine")
    lost = [f for f in files if not (lab.folder / "sources" / f).is_file()]
    if lost:
        raise NotApplicable(f"sources/{lost[0]} is not there (see the static item)")
    wanted = lab.trajectory()
    folder = lab.folder / ".compiled"
    compiler = _Compiler(lab, folder)
    library = compiler.library(sets, libraries(archive, identifier))
    if library is None:
        complaints = [line for line in compiler.said if "error:" in line]
        told = complaints[0] if complaints else "\n".join(compiler.said)[-300:]
        yield Finding(f"the sources do not compile: {told}")
        return
    warnings = [line for line in compiler.said if "warning:" in line]
    if warnings:
        yield advice(f"{len(warnings)} compiler warnings, first: {warnings[0]}")
    if (lab.folder / "resources").is_dir():
        shutil.copytree(lab.folder / "resources", folder / "resources")
    lab.trying("loading what was compiled")
    try:
        prefix = _prefix(library, identifier, lab.description.fmi_major)
    except OSError as error:
        yield Finding(f"what is compiled does not load: {_short(error, lab)}")
        return
    if prefix is None:
        version = f"fmi{lab.description.fmi_major}GetVersion"
        yield Finding(f"the sources hold no {version}, nor {identifier}_{version}")
        return
    with lab.instance("compiled", folder=folder, prefix=prefix) as one:
        one.begin()
        rows = one.run(len(wanted))
    if not same(rows, wanted, 1e-9):
        yield Finding("the sources give other values than the binary")
    yield f"{len(files)} files compiled" + (", bit-equal" if same(rows, wanted) else "")


def _identifier(lab: Laboratory) -> str:
    return str(lab.interface.modelIdentifier)


def _short(error: OSError, lab: Laboratory) -> str:
    return str(error).replace(f"{lab.folder}/", "")


def _prefix(library: Path, identifier: str, major: int) -> str | None:
    """Return the prefix of the functions' names, None if they are not there."""
    loaded = ctypes.CDLL(str(library))
    for prefix in ("", f"{identifier}_"):
        if hasattr(loaded, f"{prefix}fmi{major}GetVersion"):
            return prefix
    return None


class _Compiler:
    """Ziglang's compiler for this machine; ``said`` is all it wrote."""

    def __init__(self, lab: Laboratory, folder: Path) -> None:
        from fmus.compile import PLATFORMS, CompileError, host_platform
        from fmus.native_source import adapter_sources

        try:
            self.target = PLATFORMS[host_platform()]
        except CompileError as error:
            raise CannotRun(str(error)) from None
        self.lab, self.folder = lab, folder
        self.end = monotonic() + PATIENCE
        self.said: list[str] = []
        self.headers = folder / "headers"  # the standard's need not be in the archive
        self.headers.mkdir(parents=True)
        for name, text in adapter_sources().items():
            if name.startswith(("fmi2", "fmi3")) and name.endswith(".h"):
                (self.headers / name).write_text(text, encoding="utf-8")

    def library(self, sets: list[SourceSet], linked: list[str]) -> Path | None:
        """Compile and link; return the library, or None if something failed."""
        objects: list[str] = []
        cpp = False
        for group in sets:
            for file in group.files:
                objects.append(str(self.folder / f"{len(objects)}.o"))
                language = "c++" if group.is_cpp(file) else "cc"
                cpp = cpp or language == "c++"
                self.lab.trying(f"compiling {file}")
                flags = ["-c", "-fPIC", "-O2", "-Wall", "-ffp-contract=off"]
                flags += ["-I.", *group.flags, "-idirafter", str(self.headers)]
                if self._run(language, *flags, file, "-o", objects[-1]):
                    return None
        two = self.lab.description.fmi_major == 2
        place = self.target.fmi2_folder if two else self.target.fmi3_folder
        binaries = self.folder / "binaries" / place
        binaries.mkdir(parents=True)
        library = binaries / f"{_identifier(self.lab)}{self.target.suffix}"
        self.lab.trying("linking the sources")
        links = ["-shared", *objects, "-o", str(library)]
        links += ["-lm", *(f"-l{name}" for name in linked if name not in ("m", "c"))]
        return None if self._run("c++" if cpp else "cc", *links) else library

    def _run(self, language: str, *flags: str) -> int:
        command = [sys.executable, "-m", "ziglang", language]
        command += ["-target", self.target.triple, "-mcpu=baseline", *flags]
        log = self.folder / "compiler.txt"
        with log.open("w+", encoding="utf-8", errors="replace") as told:
            done = subprocess.Popen(
                command, cwd=self.lab.folder / "sources", stdout=told, stderr=told
            )
            while True:
                try:
                    done.wait(1.0)
                    break
                except subprocess.TimeoutExpired:
                    self.lab.beat()
                if monotonic() > self.end:
                    done.kill()
                    done.wait()
                    raise CannotRun(f"compiling takes longer than {PATIENCE:g} s")
        self.said += log.read_text(encoding="utf-8", errors="replace").splitlines()
        return done.returncode
