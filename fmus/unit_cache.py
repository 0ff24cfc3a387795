"""What pint said of units by name, kept: importing pint takes a third of a second.

One file per version of pint in the cache of FMUs; a damaged one is made anew.
"""

import json
import tempfile
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TypeAlias

from fmus.cache import cache_folder

Entry: TypeAlias = tuple[dict[str, int], str, str]  # exponents, factor, offset


def read() -> dict[str, Entry]:
    """Return the units known so far."""
    return _read(_file())


def add(name: str, entry: Entry) -> None:
    """Remember a unit, also for later processes."""
    file = _file()
    known = _read(file)
    known[name] = entry
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(
        "w", dir=file.parent, suffix=".tmp", delete=False, encoding="utf-8"
    ) as unfinished:
        json.dump(known, unfinished)
    Path(unfinished.name).replace(file)


def _file() -> Path:
    return cache_folder() / f"units-pint-{_pint()}.json"


@cache
def _pint() -> str:
    return version("pint")


@cache
def _read(file: Path) -> dict[str, Entry]:
    try:
        found: dict[str, Entry] = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found
