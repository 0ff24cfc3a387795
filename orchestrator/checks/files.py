"""Static items about the archive and its files."""

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
SUFFIXES = {"linux": ".so", "windows": ".dll", "darwin": ".dylib"}
FMI2_PLATFORM = re.compile(r"(linux|win|darwin)(32|64)")
FMI3_PLATFORM = re.compile(r"\w+-(\w+)")
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
        yield from against(fmu.root, xsd)
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


def against(root: Any, xsd: Path) -> Iterator[Said]:
    """Say where a document does not follow a schema."""
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
        suffix = _suffix(platform, fmu.major)
        if fmu.major == 3 and not FMI3_PLATFORM.fullmatch(platform):
            yield Finding(f"binaries/{platform}: FMI 3 wants <architecture>-<system>")
        for identifier in identifiers:
            name = f"binaries/{platform}/{identifier}{suffix}"
            if suffix and name not in fmu.names:
                yield Finding(f"there is no {name}")
    yield f"platforms: {', '.join(platforms) or 'none, source code only'}"


def _suffix(platform: str, major: int) -> str:
    """Return how libraries are named in a folder of binaries, "" if unknown."""
    pattern = FMI2_PLATFORM if major == 2 else FMI3_PLATFORM
    found = pattern.fullmatch(platform)
    system = found[1] if found else ""
    return SUFFIXES.get("windows" if system == "win" else system, "")


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
        yield from against(root, SCHEMAS / "fmi3" / "fmi3TerminalsAndIcons.xsd")
    for member in root.iter("TerminalMemberVariable", "TerminalStreamMemberVariable"):
        for key in ("variableName", "inStreamVariableName", "outStreamVariableName"):
            variable = member.get(key)
            if variable and variable not in fmu.description.variables:
                yield Finding(f"terminal member {variable!r} is no variable")
    yield f"{sum(1 for _ in root.iter('Terminal'))} terminals"
