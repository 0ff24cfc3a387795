"""In what kept runs, or locks, differ: scenario, FMUs, versions, figures.

A lock says everything that was resolved, so that what two locks have in common is
what the two runs have in common.
"""

import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from orchestrator.errors import ScenarioError
from orchestrator.history.folder import METRICS, RUNS
from orchestrator.history.listing import entries, find
from orchestrator.quantities.quantity import NoValue, Quantity

LOCK = "scenario.lock.toml"
ABSENT = "–"
PARTS = {
    "digests": "FMUs",
    "sources": "FMUs",
    "contents": "FMUs",
    "versions": "versions",
    "design": "scenario",
    "overrides": "scenario",
    "scenario": "scenario",
}


@dataclass(frozen=True)
class Kept:
    """A run or lock: what was resolved and, of a run, its folder and figures."""

    label: str
    lock: Mapping[str, Any]
    folder: Path | None = None
    figures: Mapping[str, Quantity] = field(default_factory=dict)


class Difference(NamedTuple):
    """What is not the same in all: where it belongs, its key, a text for each."""

    part: str
    key: str
    values: tuple[str, ...]


def kept(name: str) -> Kept:
    """Return the run of a folder or of a name that ``runs`` lists, or a lock file.

    Raises:
        ScenarioError: there is none, or it holds no lock.
    """
    path = Path(name)
    if path.is_file():
        return Kept(name, _lock(path))
    if not path.is_dir():
        path = find(name.removeprefix(f"{RUNS}/"), entries(RUNS)).folder
    lock = _lock(path / LOCK)
    has_rows = (path / "result").is_dir()
    return Kept(name.rstrip("/"), lock, path if has_rows else None, _figures(path))


def differences(runs: Sequence[Kept]) -> list[Difference]:
    """Return every key of the locks whose values are not all equal."""
    flat = [dict(_flat(run.lock)) for run in runs]
    found = []
    for key in dict.fromkeys(key for one in flat for key in one):
        values = tuple(one.get(key, ABSENT) for one in flat)
        if len(set(values)) > 1:
            first, _, rest = key.partition(".")
            if first == "lock":
                part = PARTS.get(rest.partition(".")[0], "scenario")
                key = rest
            else:
                part = "scenario"
            found.append(Difference(part, key, values))
    order = ("scenario", "FMUs", "versions")
    return sorted(found, key=lambda d: order.index(d.part))


def _lock(file: Path) -> Mapping[str, Any]:
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ScenarioError(
            f"{file.parent}: holds no run: there is no {file.name} in it"
        ) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{file}: {error}") from None


def _flat(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    for key, value in table.items():
        name = f"{above}.{key}" if above else key
        if isinstance(value, Mapping):
            yield from _flat(value, name)
        elif isinstance(value, list):
            yield name, ", ".join(map(str, value))
        else:
            whole = isinstance(value, float) and value.is_integer()  # 300 is 300.0
            yield name, str(int(value) if whole else value)


def _figures(folder: Path) -> dict[str, Quantity]:
    """Return the figures of a run; none where it is not complete."""
    try:
        told = json.loads((folder / METRICS).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return {
        name: NoValue(figure["unit"], why=figure.get("why") or "none")
        if figure["value"] is None
        else Quantity(figure["value"], figure["unit"])
        for name, figure in told.get("metrics", {}).items()
    }
