"""Static items about the archive and its files."""

import posixpath
import re
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path, PurePosixPath
from typing import Any

import fmpy
from lxml import etree

from orchestrator.checks.archive import Archive
from orchestrator.checks.elf import needed_libraries
from orchestrator.checks.item import (
    CannotRun,
    Finding,
    NotApplicable,
    Said,
    advice,
    static,
)

SCHEMAS = Path(fmpy.__file__).parent / "schema"
STORED, DEFLATED = 0, 8
ZIP_VERSION = 20  # 2.0: deflate, no zip64, no encryption
SUFFIXES = {"linux": ".so", "win": ".dll", "darwin": ".dylib"}
SYSTEM = re.compile(r"(lib(c|m|pthread|dl|rt)\.so|ld-linux|linux-vdso)")
LICENCES = re.compile(r"documentation/(licenses/)?license\.(txt|html|spdx)$")


@static(
    1,
    "The archive is a plain zip file",
    "FMI 2.0.5 section 2.3; FMI 3.0.2 section 2.5",
    "export it again with a tool that writes zip 2.0 (deflate or stored), '/' "
    "between folders and modelDescription.xml at the root",
)
def plain_zip(fmu: Archive) -> Iterator[Said]:
    yield f"{len(fmu.members)} members"
    seen: set[str] = set()
    for member in fmu.members:
        name = member.orig_filename
        if member.compress_type not in (STORED, DEFLATED):
            yield Finding(f"{name}: compression method {member.compress_type}")
        if member.extract_version > ZIP_VERSION:
            version = member.extract_version / 10
            yield Finding(f"{name}: needs zip {version}, at most 2.0 may be used")
        if member.flag_bits & 1:
            yield Finding(f"{name}: is encrypted")
        if "\\" in name:
            yield Finding(f"{name}: has a backslash in its name")
        if name.startswith("./"):
            yield Finding(f"{name}: begins with ./")
        if name in seen:
            yield Finding(f"{name}: is there twice")
        seen.add(name)
    if "modelDescription.xml" not in seen:
        nested = [n for n in seen if n.endswith("/modelDescription.xml")]
        where = f"; it lies at {nested[0]}" if nested else ""
        yield Finding(f"there is no modelDescription.xml at the root{where}")


@static(
    2,
    "modelDescription.xml follows its schema",
    "FMI 2.0.5 section 2.2; FMI 3.0.2 section 2.4",
    "correct the element or attribute named; the order of elements counts",
)
def schema(fmu: Archive) -> Iterator[Said]:
    _ = fmu.members  # an archive that cannot be opened is the fault of item 1
    try:
        xsd = SCHEMAS / f"fmi{fmu.major}" / f"fmi{fmu.major}ModelDescription.xsd"
        yield from _against(fmu.root, xsd)
        encoding = fmu.root.getroottree().docinfo.encoding or "UTF-8"
        if encoding.upper() != "UTF-8":
            yield Finding(f"the document is encoded in {encoding}, not UTF-8")
        made = fmu.root.get("generationDateAndTime")
        if made is not None and not _is_utc(made):
            yield advice(
                f"generationDateAndTime = {made!r} is no UTC time such as "
                f"2026-11-22T10:00:00Z"
            )
        for problem in fmu.problems.get(2, ()):
            yield Finding(problem)
        count = len(fmu.description.variables)
        yield f"FMI {fmu.root.get('fmiVersion')}, {count} variables"
    except CannotRun as error:
        yield Finding(str(error))


def _against(root: Any, xsd: Path) -> Iterator[Said]:
    checker = etree.XMLSchema(etree.parse(str(xsd)))
    if not checker.validate(root):
        for fault in checker.error_log:
            yield Finding(f"line {fault.line}: {fault.message}")


def _is_utc(text: str) -> bool:
    try:
        return text.endswith("Z") and bool(datetime.fromisoformat(text))
    except ValueError:
        return False


@static(
    10,
    "Binaries lie where an importer looks for them",
    "FMI 2.0.5 sections 2.3, 4.3.1; FMI 3.0.2 section 2.5",
    "name the file <modelIdentifier>.so, .dll or .dylib in binaries/<platform>/",
)
def binary_names(fmu: Archive) -> Iterator[Said]:
    identifiers = {e.get("modelIdentifier") or "" for e in fmu.interfaces()}
    for identifier in identifiers:
        if not re.fullmatch(r"[A-Za-z_]\w*", identifier, re.ASCII):
            yield Finding(f"modelIdentifier = {identifier!r} is no C identifier")
        if fmu.major == 3 and len(identifier) > 64:
            yield advice(f"modelIdentifier has {len(identifier)} letters, at most 64")
    platforms = fmu.description.platforms
    if not platforms and not any(n.startswith("sources/") for n in fmu.names):
        yield Finding("there is neither a binary nor a source file")
    for platform in platforms:
        system = next((s for s in SUFFIXES if s in platform), "")
        if fmu.major == 3 and not re.fullmatch(r"\w+-\w+", platform):
            yield Finding(f"binaries/{platform}: FMI 3 wants <architecture>-<system>")
        for identifier in identifiers:
            name = f"binaries/{platform}/{identifier}{SUFFIXES.get(system, '')}"
            if system and name not in fmu.names:
                yield Finding(f"there is no {name}")
    yield f"platforms: {', '.join(platforms) or 'none, source code only'}"


@static(
    30,
    "Nothing is needed that the FMU does not say",
    "FMI 2.0.5 section 4.3.1; FMI 3.0.2 section 2.5; implementers' guide 3",
    "link the libraries statically, bring them in the binary's folder, or set "
    "needsExecutionTool and tell in documentation/externalDependencies.txt",
)
def dependencies_told(fmu: Archive) -> Iterator[Said]:
    told = [n for n in fmu.names if re.search(r"externalDependencies\.(txt|html)$", n)]
    needs = fmu.description.needs_execution_tool
    if needs and not told:
        text = "needsExecutionTool = true, but documentation/externalDependencies.txt"
        finding = f"{text} is missing"
        yield Finding(finding) if fmu.major == 3 else advice(finding)
    for name in fmu.names:
        if not (name.startswith("binaries/") and name.endswith(".so")):
            continue
        folder = PurePosixPath(name).parent
        foreign = [
            library
            for library in needed_libraries(fmu.content(name))
            if not SYSTEM.match(library) and f"{folder}/{library}" not in fmu.names
        ]
        if foreign and not told:
            yield advice(f"{name} needs {', '.join(foreign)} of the machine")
        yield f"{name} needs {', '.join(foreign) or 'only libc and libm'}"


@static(
    31,
    "Documentation, licence and authorship are told",
    "FMI 2.0.5 sections 2.2.1, 2.3; FMI 3.0.2 section 2.5; implementers' guide",
    "add documentation/index.html, a licence file and the attributes named",
)
def documentation(fmu: Archive) -> Iterator[Said]:
    if "documentation/index.html" not in fmu.names:
        yield advice("there is no documentation/index.html")
    if not any(LICENCES.match(name) for name in fmu.names):
        yield advice("there is no licence in documentation/")
    for attribute in ("author", "version", "copyright", "license"):
        if not fmu.root.get(attribute):
            yield advice(f"modelDescription.xml has no {attribute}")


@static(
    32,
    "Terminals name variables that are there",
    "FMI 3.0.2 section 2.4.10 (terminalsAndIcons.xml)",
    "correct terminalsAndIcons.xml",
)
def terminals(fmu: Archive) -> Iterator[Said]:
    name = next((n for n in fmu.names if n.endswith("/terminalsAndIcons.xml")), None)
    if name is None:
        raise NotApplicable("it has no terminalsAndIcons.xml")
    root = fmu.parsed(name)
    if fmu.major == 3:
        yield from _against(root, SCHEMAS / "fmi3" / "fmi3TerminalsAndIcons.xsd")
    for member in root.iter("TerminalMemberVariable", "TerminalStreamMemberVariable"):
        for key in ("variableName", "inStreamVariableName", "outStreamVariableName"):
            variable = member.get(key)
            if variable and variable not in fmu.description.variables:
                yield Finding(f"terminal member {variable!r} is no variable")
    yield f"{sum(1 for _ in root.iter('Terminal'))} terminals"


@static(
    34,
    "Sources are all there",
    "FMI 2.0.5 section 4.3.1 (SourceFiles); FMI 3.0.2 section 2.5.1",
    "list every C file, and only those, relative to sources/",
)
def sources_listed(fmu: Archive) -> Iterator[Said]:
    there = {n.removeprefix("sources/") for n in fmu.names if n.startswith("sources/")}
    if not there:
        raise NotApplicable("it has no sources")
    listed = source_files(fmu)
    if not listed:
        yield Finding("sources/ is there, but no source file is listed")
    for name in listed:
        if posixpath.normpath(name) not in there:
            yield Finding(f"sources/{name} is listed, but is not there")
    if fmu.major == 3:
        build = "sources/buildDescription.xml"
        if build in fmu.names:
            xsd = SCHEMAS / "fmi3" / "fmi3BuildDescription.xsd"
            yield from _against(fmu.parsed(build), xsd)
    yield f"{len(listed)} source files"


def source_files(fmu: Archive) -> list[str]:
    """Return the C files listed for compilation, relative to ``sources/``."""
    if fmu.major == 3:
        build = "sources/buildDescription.xml"
        if build not in fmu.names:
            return []
        files = fmu.parsed(build).iter("SourceFile")
    else:
        files = (f for group in fmu.root.iter("SourceFiles") for f in group)
    return list(dict.fromkeys(file.get("name") for file in files))
