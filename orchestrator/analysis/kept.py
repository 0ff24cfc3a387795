"""What a sweep keeps in its folder, and whether another may go on with it.

``members.jsonl`` has an outcome a line.  ``sweep.json`` says of which sweep: the
scenario as it is composed, with its FMUs, designs, metrics and expectations, what is
set, which keys are varied, files named among their values, and the units of figures.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, TypeAlias

from fmus.cache import digest
from orchestrator.analysis.variations import Assignment
from orchestrator.errors import ScenarioError
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.lock import locked

MEMBERS, SWEEP = "members.jsonl", "sweep.json"
Rows: TypeAlias = dict[int, dict[str, Any]]
_SAID = ("title", "description")  # change no figure


@dataclass(frozen=True)
class Identity:
    """What two sweeps have in common of which one may go on with the other."""

    scenario: str
    sets: tuple[str, ...]
    keys: tuple[str, ...]
    files: Mapping[str, str]

    def refusal(self, earlier: "Identity") -> str:
        """Return in words why members of an earlier sweep are none of this one."""
        if earlier.sets != self.sets:
            return f"they are of {_sets(earlier.sets)}, this one of {_sets(self.sets)}"
        if set(earlier.keys) != set(self.keys):
            theirs, ours = ", ".join(earlier.keys), ", ".join(self.keys)
            return f"they vary {theirs}, this one {ours}"
        if earlier.scenario != self.scenario:
            return (
                "the scenario has changed since: a value, an FMU, a design, a metric, "
                "an expectation, or a version of what computes"
            )
        if changed := [
            n for n, d in earlier.files.items() if self.files.get(n, d) != d
        ]:
            return f"{changed[0]} has changed since"
        return ""


def _sets(sets: Sequence[str]) -> str:
    return " ".join(f'--set "{text}"' for text in sets) or "the scenario without --set"


def identity(
    nominal: Composition, sets: Sequence[str], assignments: Sequence[Assignment]
) -> Identity:
    """Return what tells a sweep from others."""
    tables = locked(nominal)
    said = {k: v for k, v in tables.items() if k not in _SAID}
    text = json.dumps(said, sort_keys=True, default=str)
    values = {v for a in assignments for v in a.values() if isinstance(v, str)}
    files = sorted(v for v in values if v.endswith((".py", ".fmu")))
    return Identity(
        hashlib.sha256(text.encode()).hexdigest(),
        tuple(sets),
        tuple(dict.fromkeys(key for a in assignments for key in a)),
        {name: digest(Path(name)) for name in files if Path(name).is_file()},
    )


def note(folder: Path, one: Identity, units: Mapping[str, str]) -> None:
    """Write of which sweep the members of a folder are."""
    partial = folder / f"{SWEEP}.partial"
    told = {**asdict(one), "units": dict(units)}
    partial.write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")
    partial.replace(folder / SWEEP)


def done_before(
    folder: Path, one: Identity, assignments: Sequence[Assignment]
) -> tuple[Rows, dict[str, str]]:
    """Return the rows that a sweep has left in a folder, and the units of figures.

    Raises:
        ScenarioError: they are of other members.
    """
    rows = _rows(folder / MEMBERS)
    if not rows:
        return {}, {}
    try:
        told = json.loads((folder / SWEEP).read_text(encoding="utf-8"))
        units = {str(k): str(v) for k, v in told["units"].items()}
        found = {f.name: told[f.name] for f in fields(Identity)}
        found |= {name: tuple(found[name]) for name in ("sets", "keys")}
        why = one.refusal(Identity(**found))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        why = f"its {SWEEP} cannot be read, so nobody knows of which"
    if not why and any(not _is_of(row, i, assignments) for i, row in rows.items()):
        why = "they have other values"
    if why:
        raise ScenarioError(
            f"{folder}: holds members of another sweep: {why}; give the same "
            f"scenario, --set, --vary, --sample and --seed, or begin anew, without "
            f"--resume or in another folder"
        )
    return rows, units


def _rows(file: Path) -> Rows:
    rows: Rows = {}
    for line in file.read_text(encoding="utf-8").splitlines() if file.exists() else ():
        with suppress(json.JSONDecodeError):  # the last line of a killed sweep
            row = json.loads(line)
            rows[row["member"]] = row
    return rows


def _is_of(
    row: Mapping[str, Any], index: int, assignments: Sequence[Assignment]
) -> bool:
    if index >= len(assignments):
        return False
    return all(row.get(k) == v for k, v in assignments[index].items())
