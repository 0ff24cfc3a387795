"""Which sources an FMU brings and how they are compiled; static item about them.

FMI 2 lists files per interface.  FMI 3 has ``sources/buildDescription.xml``:
configurations of sets, each with options, definitions and include folders of its
own.  Read are the sets for one model identifier and this machine.
"""

import posixpath
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy

from orchestrator.checks.archive import Archive
from orchestrator.checks.files import SCHEMAS, against
from orchestrator.checks.item import Finding, NotApplicable, Said, static

BUILD = "sources/buildDescription.xml"
GNU = ("", "gcc", "clang", "cc", "g++", "clang++", "c++")  # they share their options
SHOWN = 5


@dataclass(frozen=True)
class SourceSet:
    """Files that are compiled alike; paths are relative to ``sources/``."""

    files: tuple[str, ...]
    language: str = ""
    options: tuple[str, ...] = ()
    definitions: tuple[str, ...] = ()
    includes: tuple[str, ...] = ()

    @property
    def flags(self) -> list[str]:
        """What a compiler like gcc is given for these files."""
        flags = [*self.options, *(f"-D{d}" for d in self.definitions)]
        return [*flags, *(f"-I{folder}" for folder in self.includes)]

    def is_cpp(self, file: str) -> bool:
        """Tell whether a file is in C++."""
        named = Path(file).suffix.lower() in (".cpp", ".cc", ".cxx")
        return named or self.language.upper().replace(" ", "").startswith("C++")


def source_sets(fmu: Archive, identifier: str = "") -> list[SourceSet]:
    """Return what is to be compiled, for one model identifier or for any."""
    if fmu.major == 3:
        return [_set(e) for c in _configurations(fmu, identifier) for e in _sets(c)]
    groups = {
        interface.get("modelIdentifier"): tuple(f.get("name") for f in listed)
        for interface in fmu.interfaces()
        if (listed := interface.find("SourceFiles")) is not None
    }
    if identifier in groups:
        groups = {identifier: groups[identifier]}
    return [SourceSet(tuple(dict.fromkeys(f for g in groups.values() for f in g)))]


def libraries(fmu: Archive, identifier: str) -> list[str]:
    """Return the libraries of the machine that the sources are linked with."""
    if fmu.major != 3:
        return []
    found = [e for c in _configurations(fmu, identifier) for e in c.iter("Library")]
    names = [e.get("name") for e in found if e.get("external") in ("true", "1")]
    return [name for name in names if name]


def source_files(fmu: Archive) -> list[str]:
    """Return all files listed for compilation, relative to ``sources/``."""
    files = (file for group in source_sets(fmu) for file in group.files)
    return list(dict.fromkeys(files))


def _configurations(fmu: Archive, identifier: str) -> list[Any]:
    if BUILD not in fmu.names:
        return []
    found = list(fmu.parsed(BUILD).iter("BuildConfiguration"))
    if identifier:
        found = [c for c in found if c.get("modelIdentifier") == identifier]
        here = [c for c in found if c.get("platform") == fmpy.platform_tuple]
        found = (here or [c for c in found if not c.get("platform")])[:1]
    return found


def _sets(configuration: Any) -> Iterator[Any]:
    yield from configuration.iter("SourceFileSet")


def _set(element: Any) -> SourceSet:
    options = element.get("compilerOptions") or ""
    understood = (element.get("compiler") or "").lower() in GNU
    return SourceSet(
        tuple(e.get("name") for e in element.iter("SourceFile")),
        element.get("language") or "",
        tuple(shlex.split(options)) if understood else (),
        tuple(
            e.get("name") + (f"={e.get('value')}" if e.get("value") is not None else "")
            for e in element.iter("PreprocessorDefinition")
            if e.get("optional") not in ("true", "1")
        ),
        tuple(e.get("name") for e in element.iter("IncludeDirectory")),
    )


@static(
    34,
    "Sources are all there",
    "FMI 2.0.5 section 4.3.1 (SourceFiles); FMI 3.0.2 section 2.5.1",
    "list every C file, and only those, relative to sources/",
)
def sources_listed(fmu: Archive) -> Iterator[Said]:
    there = {n.removeprefix("sources/") for n in fmu.names if n.startswith("sources/")}
    listed = source_files(fmu)
    if not there and not listed:
        raise NotApplicable("it has no sources")
    if not there:
        more = f" and {len(listed) - SHOWN} more" if len(listed) > SHOWN else ""
        named = ", ".join(listed[:SHOWN])
        yield Finding(f"there is no sources/, but {named}{more} are listed")
        return
    if not listed:
        yield Finding("sources/ is there, but no source file is listed")
    for name in listed:
        if posixpath.normpath(name) not in there:
            yield Finding(f"sources/{name} is listed, but is not there")
    if fmu.major == 3 and BUILD in fmu.names:
        xsd = SCHEMAS / "fmi3" / "fmi3BuildDescription.xsd"
        yield from against(fmu.parsed(BUILD), xsd)
    yield f"{len(listed)} source files"
