"""Designs that are shipped as data files: found, made anew, compared.

A package ``controllers.synthesis.<drive>`` that ships designs has a module ``designs``
with ``FOLDER``, where the files lie, and ``DESIGNS``, a mapping from a name to a
function that returns the new files as text, by name.  A file is one JSON object; what
``design`` holds in it are the figures, everything else numbers the controller reads.
"""

import importlib
import json
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.errors import DesignError, did_you_mean

ROOM = "controllers.synthesis"


@dataclass(frozen=True)
class Shipped:
    """A design: ``make`` returns its files as text, which lie in ``folder``."""

    name: str
    folder: Path
    make: Callable[[], Mapping[str, str]]


@dataclass(frozen=True)
class Change:
    """One quantity of a file; ``before`` is None where there was none.

    ``difference`` is the largest of all entries over the largest entry before.
    """

    file: str
    quantity: str
    before: float | None
    after: float | None
    difference: float | None


def shipped_designs() -> dict[str, Shipped]:
    """Return all shipped designs, by name as in ``ball_screw_lpv.k_vib``."""
    found = {}
    for package in pkgutil.iter_modules(importlib.import_module(ROOM).__path__):
        if not package.ispkg:
            continue
        folder = importlib.import_module(f"{ROOM}.{package.name}").__path__
        if "designs" not in {module.name for module in pkgutil.iter_modules(folder)}:
            continue
        module = importlib.import_module(f"{ROOM}.{package.name}.designs")
        for name, make in module.DESIGNS.items():
            full = f"{package.name}.{name}"
            found[full] = Shipped(full, module.FOLDER, make)
    return found


def find_design(name: str) -> Shipped:
    """Return the shipped design of a name.

    Raises:
        DesignError: there is none.
    """
    found = shipped_designs()
    if name not in found:
        raise DesignError(f"no shipped design {name!r}; {did_you_mean(name, found)}")
    return found[name]


def make_anew(design: Shipped) -> Mapping[str, str]:
    """Return the files of a design, made anew.

    Raises:
        DesignError: the solver is not installed, finds nothing, or what it finds
            keeps no bound.
    """
    try:
        files = design.make()
    except (ImportError, ValueError) as error:
        raise DesignError(f"{design.name}: {error}") from None
    for file, text in files.items():
        for key, value in json.loads(text).get("design", {}).items():
            if isinstance(value, float) and not np.isfinite(value):
                raise DesignError(
                    f"{design.name}: {key} of {file} is {value}: what the solver found "
                    "keeps no bound when it is checked without it; try other weights, "
                    "points or solver. Nothing is written"
                )
    return files


def compare(design: Shipped, files: Mapping[str, str]) -> Iterator[Change]:
    """Yield what differs between the shipped files and new ones."""
    for name, text in files.items():
        path = design.folder / name
        before = json.loads(path.read_text()) if path.is_file() else {}
        after = json.loads(text)
        old, new = before.pop("design", {}), after.pop("design", {})
        for key, value in new.items():
            if isinstance(value, float | int):
                yield _figure(name, key, old.get(key), float(value))
        for key, value in after.items():
            if isinstance(value, list):
                yield _entries(name, key, before.get(key), value)


def write(design: Shipped, files: Mapping[str, str]) -> None:
    """Put new files in the place of the shipped ones.

    Raises:
        OSError: they cannot be written.
    """
    for name, text in files.items():
        (design.folder / name).write_text(text)


def _figure(file: str, key: str, before: Any, after: float) -> Change:
    if before is None:
        return Change(file, key, None, after, None)
    scale = abs(before) or 1.0
    return Change(file, key, float(before), after, abs(after - before) / scale)


def _entries(file: str, key: str, before: Any, after: Any) -> Change:
    new = np.array(after, dtype=float)
    old = None if before is None else np.array(before, dtype=float)
    if old is None or old.shape != new.shape:
        return Change(file, f"{key} {new.shape}", None, None, None)
    scale = float(np.max(np.abs(old))) or 1.0
    worst = float(np.max(np.abs(new - old))) / scale
    return Change(file, f"{key} {new.shape}", None, None, worst)
