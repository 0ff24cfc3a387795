"""Whether an FMU of ours is what its sources make: compiled anew, compared bit for bit.

The binaries of every platform in the archive are compiled from the C sources in it;
nothing of the FMU is executed.  Where it says which module of ours it was made of,
that is built anew too, and every other file compared.
"""

import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from fmus.archive import EXTRA
from fmus.build import build
from fmus.compile import PLATFORMS, compile_library, universal_binary
from fmus.load import BuildError
from fmus.native_source import MODEL_DATA, adapter_sources
from fmus.own import OWN_PACKAGES
from orchestrator.errors import FmuError
from orchestrator.fmu.archive import checked_members, read_member
from orchestrator.fmu.description import FmuDescription, read_fmu

SAME, OTHER, UNKNOWN = "the same", "differs", "not compared"


@dataclass(frozen=True)
class Compared:
    """One file of an FMU: what it was compared with, and the verdict."""

    file: str
    verdict: str
    origin: str


def compared(path: Path) -> list[Compared]:
    """Return every file of an FMU beside what is made anew.

    Raises:
        FmuError: it has no C sources of ours.
        fmus.compile.CompileError: they do not compile.
    """
    fmu = read_fmu(path)
    files = [m.filename for m in checked_members(path) if not m.is_dir()]
    contents = {name: read_member(path, name) for name in files}
    sources = {
        name.removeprefix("sources/"): content.decode("utf-8", "replace")
        for name, content in contents.items()
        if name.startswith("sources/") and name.count("/") == 1
        if name.endswith((".c", ".h"))
    }
    if MODEL_DATA not in sources or EXTRA not in contents:
        raise FmuError(
            f"{path}: has no C sources of ours, from which it could be built anew"
        )
    made = dict(_compiled(fmu, contents, sources))
    binaries = {
        file: Compared(file, SAME if made.get(file) == content else OTHER, "sources/")
        for file, content in contents.items()
        if file.startswith("binaries/")
    }
    module, whole = _built(fmu, contents)
    rest = [
        Compared(file, SAME if whole.get(file) == content else OTHER, module)
        if whole
        else Compared(file, UNKNOWN, module)
        for file, content in contents.items()
        if file not in binaries
    ]
    lost = [Compared(f, OTHER, f"{module} has it") for f in whole if f not in contents]
    return [*binaries.values(), *rest, *lost]


def _compiled(
    fmu: FmuDescription, contents: dict[str, bytes], sources: dict[str, str]
) -> Iterator[tuple[str, bytes]]:
    """Give the binaries that the sources make, for the platforms of an FMU."""
    slices: dict[str, dict[str, bytes]] = {}
    identifier, ours = fmu.model_identifier, adapter_sources()
    adapters = {name: text for name, text in sources.items() if name in ours}
    generated = {name: text for name, text in sources.items() if name not in ours}
    with TemporaryDirectory(prefix="feeddrive-verify-") as folder:
        for platform in PLATFORMS.values():
            place = platform.fmi2_folder if fmu.fmi_major == 2 else platform.fmi3_folder
            file = f"binaries/{place}/{identifier}{platform.suffix}"
            if file in contents:
                built = compile_library(
                    identifier, generated, platform.name, Path(folder), adapters
                )
                slices.setdefault(file, {})[platform.name] = built.read_bytes()
    for file, parts in slices.items():
        one = next(iter(parts.values()))
        yield file, universal_binary(parts) if len(parts) > 1 else one


def _built(
    fmu: FmuDescription, contents: dict[str, bytes]
) -> tuple[str, dict[str, bytes]]:
    """Return the module an FMU says it was made of, and the files that one makes."""
    from lxml import etree

    module = etree.fromstring(contents[EXTRA]).get("module", "")
    if module.partition(".")[0] not in OWN_PACKAGES:
        return f"{module or 'its model'} is not ours", {}
    with TemporaryDirectory(prefix="feeddrive-verify-") as folder:
        try:
            built = build(
                module,
                fmi=3 if fmu.fmi_major == 3 else 2,
                period=fmu.period if fmu.kind == "sampled" else None,
                platforms=list(fmu.platforms),
                folder=Path(folder),
            )
        except BuildError as error:
            return f"{module} cannot be built here ({error})", {}
        with zipfile.ZipFile(built) as archive:
            return module, {name: archive.read(name) for name in archive.namelist()}
