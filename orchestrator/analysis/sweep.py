"""A sweep: a scenario's figures over values that are varied.

``sweep`` carries out every member and keeps what is done (``kept``): each outcome is
a line in the folder of the sweep as soon as it is known, so that an interrupted one
can be resumed; ``figures.parquet`` is made of them at the end.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from orchestrator.analysis.kept import MEMBERS, Identity, done_before, identity, note
from orchestrator.analysis.members import Job, Outcome, Workers, refuse_driven, split
from orchestrator.analysis.variations import Assignment, Axis, Setting, grid
from orchestrator.errors import FeedDriveError, ScenarioError
from orchestrator.quantities.quantity import NoValue, parse_quantity
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import Scenario, load_scenario
from orchestrator.session import naming, run_earlier
from orchestrator.shown import framed

if TYPE_CHECKING:
    import pandas as pd

FIGURES = "figures.parquet"
Progress: TypeAlias = Callable[[int], None]


class Runner(Protocol):
    """Carries out jobs of a composition somewhere: here, or on many machines."""

    executor: str

    def run(self, jobs: Sequence[Job]) -> Iterator[Outcome]: ...


Making: TypeAlias = Callable[[Composition, int], Runner]


@dataclass(frozen=True)
class Sweep:
    """The members of a sweep and what came of them.

    ``rows`` are dictionaries: ``member``, the varied keys, a figure's value per
    ``<metric>.<figure>``, ``met`` and ``failure``; ``units`` those of the figures.
    """

    scenario: str
    keys: tuple[str, ...]
    rows: tuple[Mapping[str, Any], ...]
    units: Mapping[str, str]
    wall_s: float
    executors: tuple[str, ...]
    nominal: Mapping[str, float] = field(default_factory=dict)

    @property
    def failed(self) -> int:
        """How many members failed or diverged."""
        return sum(row["failure"] is not None for row in self.rows)

    @property
    def met(self) -> float:
        """The share of the members that ran and met every expectation: the yield."""
        return sum(bool(row["met"]) for row in self.rows) / max(1, len(self.rows))

    def broken(self) -> dict[str, int]:
        """Return how many members do not meet each expectation."""
        counts: dict[str, int] = {}
        for row in self.rows:
            for figure in row["broken"]:
                counts[figure] = counts.get(figure, 0) + 1
        return counts

    def _repr_html_(self) -> str:
        from orchestrator.report.swept import write_swept

        told = [f"{len(self.rows)} members, yield {100 * self.met:.4g} %"]
        about = self.scenario, self.keys, self.rows, self.units
        return framed(lambda file: write_swept(*about, {}, told, file))

    def to_pandas(self) -> "pd.DataFrame":
        """Return one row per member (needs pandas)."""
        import pandas as pd

        return pd.DataFrame(
            [{k: v for k, v in row.items() if k != "broken"} for row in self.rows]
        )


def sweep(
    scenario: str | Path,
    variations: Sequence[Axis] | Sequence[Assignment],
    *,
    sets: Sequence[str] = (),
    folder: Path | None = None,
    earlier: Path | None = None,
    progress: Progress | None = None,
    making: Making | None = None,
) -> Sweep:
    """Carry out a scenario for every combination of axes, or for each assignment.

    ``sets`` hold for all members; ``folder`` keeps outcomes as they come and what
    stands in it already, or in the folder ``earlier`` of another one, is not done
    again; ``progress`` is told how many are done.  ``making`` returns what carries
    out a composition's members, else this machine.

    Raises:
        FeedDriveError: the scenario, or a member's rates, latencies or FMUs, cannot
            be composed, or what stands in the folder is of another sweep; a member
            that fails while it runs is an outcome.
    """
    begun = perf_counter()
    base = load_scenario(scenario, list(sets))
    with naming(base):
        nominal = compose(base, run_earlier)
    if not nominal.scenario.spec.metrics:
        raise ScenarioError(f"{base.file}: a sweep shows figures; add [metrics]")
    assignments = _assignments(variations)
    this = identity(nominal, sets, assignments)
    there = earlier or folder
    rows, units = done_before(there, this, assignments) if there else ({}, {})
    executors: set[str] = set()
    if progress:
        progress(len(rows))
    with _Lines(folder, this, units) as lines, closing(Workers()) as workers:
        if earlier and earlier != folder:
            for row in rows.values():
                lines.add(row)
        where = making or workers
        left = {i: a for i, a in enumerate(assignments) if i not in rows}
        for group, jobs in _groups(base, nominal, left, sets, where):
            executors.add(group.executor)
            for outcome in group.run(jobs):
                row = _row(outcome, assignments[outcome.index])
                lines.know({k: str(q.unit) for k, q in outcome.figures.items()})
                rows[outcome.index] = row
                lines.add(row)
                if progress:
                    progress(len(rows))
    found = Sweep(
        base.name,
        this.keys,
        tuple(rows[i] for i in sorted(rows)),
        lines.units,
        perf_counter() - begun,
        tuple(sorted(executors)),
        {k: v for k in this.keys if (v := _value(nominal, k)) is not None},
    )
    if folder is not None:
        write_table(found, folder / FIGURES)
    return found


def _assignments(
    variations: Sequence[Axis] | Sequence[Assignment],
) -> list[Mapping[str, Setting]]:
    axes = [v for v in variations if isinstance(v, Axis)]
    if axes and len(axes) != len(variations):
        raise ScenarioError("a sweep takes axes or assignments, not both")
    if axes:
        return list(grid(axes))
    return [v for v in variations if not isinstance(v, Axis)]


def _groups(
    base: Scenario,
    composition: Composition,
    members: Mapping[int, Assignment],
    sets: Sequence[str],
    making: Making,
) -> Iterator[tuple[Runner, list[Job]]]:
    """Yield every composition with the members that share it.

    What is a number of a component, and in which unit, is judged by the composition
    that a member has, not by the nominal one.
    """
    jobs: dict[tuple[str, ...], list[Job]] = {}
    for index, assignment in members.items():
        values, more = split(composition, assignment)
        jobs.setdefault(more, []).append(Job(index, values))
    for more, sharing in jobs.items():
        if not more:
            keys = dict.fromkeys(k for job in sharing for k in members[job.index])
            refuse_driven(composition, "--vary", keys)
            yield making(composition, len(sharing)), sharing
            continue
        scenario = load_scenario(base.file, [*sets, *more])
        with naming(scenario):
            composed = compose(scenario, run_earlier)
        left = {job.index: _without(members[job.index], more) for job in sharing}
        _refuse_other_units(composition, composed, left)
        yield from _groups(base, composed, left, [*sets, *more], making)


def _without(assignment: Assignment, sets: Sequence[str]) -> Assignment:
    return {k: v for k, v in assignment.items() if f"{k}={v}" not in sets}


def _refuse_other_units(
    nominal: Composition, composed: Composition, members: Mapping[int, Assignment]
) -> None:
    """Raise ``ScenarioError`` if a number without a unit means two quantities."""
    plain = {k for a in members.values() for k, v in a.items() if _is_plain(v)}
    for key in sorted(plain):
        one, other = _unit(nominal, key), _unit(composed, key)
        if one != other and None not in (one, other):
            raise ScenarioError(
                f"--vary {key}: is in {one} with one FMU and in {other} with "
                f'another; write values with their unit, --vary "{key}=1 {one},2 {one}"'
            )


def _is_plain(setting: Setting) -> bool:
    with suppress(ValueError):
        return not isinstance(setting, str) or parse_quantity(setting).unit == "1"
    return False


def _unit(composition: Composition, key: str) -> str | None:
    with suppress(FeedDriveError):
        return str(composition.unit(key))
    return None


def _value(composition: Composition, key: str) -> float | None:
    with suppress(FeedDriveError, ValueError, TypeError):
        return composition.parameter(key).value
    return None


def nominal_value(scenario: str | Path, sets: Sequence[str]) -> Callable[[str], float]:
    """Return the function that gives a key's value in the scenario as it stands.

    Raises (the function):
        ScenarioError: the key is no number of a component.
    """
    found = compose(load_scenario(scenario, list(sets)), run_earlier)

    def nominal(key: str) -> float:
        return found.parameter(key).value

    return nominal


def _row(outcome: Outcome, assignment: Assignment) -> dict[str, Any]:
    figures = {
        name: None
        if isinstance(q, NoValue) or not isfinite(q.value)
        else float(q.value)
        for name, q in outcome.figures.items()
    }
    return {
        "member": outcome.index,
        **assignment,
        **figures,
        "met": outcome.met,
        "broken": [c.figure for c in outcome.checks if not c.met],
        "failure": outcome.failure,
    }


class _Lines:
    """Outcomes on disk as they come, one JSON object a line, and units of figures."""

    def __init__(
        self, folder: Path | None, this: Identity, units: Mapping[str, str]
    ) -> None:
        self._folder, self._this, self.units = folder, this, dict(units)
        self._file = (folder / MEMBERS).open("a", encoding="utf-8") if folder else None
        if folder:
            note(folder, this, units)

    def __enter__(self) -> "_Lines":
        return self

    def __exit__(self, *_: object) -> None:
        if self._file:
            self._file.close()

    def know(self, units: Mapping[str, str]) -> None:
        """Take the units of a member's figures."""
        if units.items() <= self.units.items():
            return
        self.units |= units
        if self._folder:
            note(self._folder, self._this, self.units)

    def add(self, row: Mapping[str, Any]) -> None:
        """Append a member's row."""
        if self._file:
            self._file.write(json.dumps(row) + "\n")
            self._file.flush()


def write_table(sweep: Sweep, file: Path) -> None:
    """Write the members as a Parquet table, units of the figures as metadata."""
    import pyarrow as pa
    import pyarrow.parquet

    columns: dict[str, list[Any]] = {}
    names = _columns(sweep.rows)
    for name in names:
        values = [row.get(name) for row in sweep.rows]
        if any(isinstance(v, str) for v in values):
            values = [None if v is None else str(v) for v in values]
        columns[name] = values
    fields = []
    for name, values in columns.items():
        about = {"unit": sweep.units[name]} if name in sweep.units else None
        fields.append(pa.field(name, pa.array(values).type, metadata=about))
    table = pa.table(list(columns.values()), schema=pa.schema(fields))
    partial: Any = file.with_suffix(".partial")
    pyarrow.parquet.write_table(table, partial)
    partial.replace(file)


def _columns(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    names = dict.fromkeys(name for row in rows for name in row)
    return [name for name in names if name != "broken"]
