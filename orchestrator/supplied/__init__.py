"""What comes along: foreign FMUs to try a swap with, and a project to start from.

The FMUs are C of their own, with other names, other units, the other sense of
rotation, built for this machine when asked for.  ``project`` is what ``new`` copies.
"""

import zipfile
from pathlib import Path

from fmus.cache import cache_folder
from fmus.compile import PLATFORMS, compile_alone, host_platform
from fmus.native_source import adapter_sources
from orchestrator.errors import FmuError, did_you_mean

PREFIX = "supplied."
HERE = Path(__file__).parent
PROJECT = HERE / "project"


def build_supplied(name: str, folder: Path) -> Path:
    """Build ``supplied.<name>`` into a folder and return the FMU's path.

    Raises:
        FmuError: there is no such FMU.
        fmus.compile.CompileError: the compiler is missing or fails.
    """
    known = sorted(file.stem for file in HERE.glob("*.c"))
    stem = name.removeprefix(PREFIX)
    if stem not in known:
        remedy = did_you_mean(stem, known)
        raise FmuError(f"{name}: there is no supplied FMU {stem!r}; {remedy}")
    headers = {n: t for n, t in adapter_sources().items() if n.startswith("fmi2")}
    sources = {n: text for n, text in headers.items() if n.endswith(".h")}
    sources[f"{stem}.c"] = (HERE / f"{stem}.c").read_text(encoding="utf-8")
    platform = host_platform()
    library = compile_alone(stem, sources, platform, cache_folder() / "libraries")
    place = f"binaries/{PLATFORMS[platform].fmi2_folder}/{library.name}"
    file = folder / f"{stem}.fmu"
    folder.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(HERE / f"{stem}.xml", "modelDescription.xml")
        archive.write(library, place)
    return file
