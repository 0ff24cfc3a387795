"""Files that a scenario names stand beside the file that names them.

A layer that is inherited from another folder names its files by whole paths, so that
an heir finds what its base found: FMUs, models, signals, runs of a design, baselines.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

_MODELS = (".fmu", ".py")  # any other ``fmu`` is the name of a module


def scenario_beside(folder: Path, name: str) -> str:
    """Return the path or published name of a scenario named in ``folder``."""
    if name.endswith(".toml"):
        return str(folder / name)
    return name if "/" in name else str(folder / f"{name}.toml")


def homed(layer: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return a layer of ``folder`` whose files are named by whole paths."""

    def model(name: str) -> str:
        return str(folder / name) if name.endswith(_MODELS) else name

    def scenario(name: str) -> str:
        return scenario_beside(folder, name)

    def file(name: str) -> str:
        return str(folder / name)

    places: dict[str, Mapping[str, Callable[[str], str]]] = {
        "components": {"fmu": model, "data": file},
        "design": {"from_run": scenario},
    }
    found = dict(layer)
    for table, keys in places.items():
        entries = found.get(table)
        if isinstance(entries, dict):
            found[table] = {name: _rewritten(e, keys) for name, e in entries.items()}
    like = found.get("expect_like")
    if isinstance(like, str):
        found["expect_like"] = file(like)
    elif isinstance(like, dict):
        found["expect_like"] = _rewritten(like, {"folder": file})
    return found


def _rewritten(entry: Any, keys: Mapping[str, Callable[[str], str]]) -> Any:
    """Return an entry with the texts under ``keys`` rewritten; no table stays as is."""
    if not isinstance(entry, dict):
        return entry
    return {
        key: keys[key](value) if key in keys and isinstance(value, str) else value
        for key, value in entry.items()
    }
