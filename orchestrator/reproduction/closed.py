"""Differences of the first edition that the second closed, as data.

``closed.toml`` of a study::

    [[difference]]
    what = "P-PI: S_max in s and z"
    first = ["p_pi_a.s_max_current", "p_pi_a.s_max_z_current"]    # ids of rows
    second = ["p_pi_c.s_max_current", "p_pi_c.s_max_z_current"]
    free = "three gains for nine figures"

The rows of both editions stand in ``reference.toml``, side by side: each pair has the
same published figure.  ``free`` says how many numbers were chosen against published
figures and for how many; what they were not chosen against is predicted.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from pydantic import Field, ValidationError, model_validator

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.evaluation.schema import Strict
from orchestrator.reproduction.reference import FigureSpec, read_reference
from orchestrator.reproduction.verdict import Figure
from orchestrator.scenario.complaints import complaints
from orchestrator.scenario.reading import read_toml

FILE = "closed.toml"


class Difference(Strict):
    """Rows of one difference, in pairs; keys as in the contract above."""

    what: str
    first: tuple[str, ...] = Field(min_length=1, strict=False)
    second: tuple[str, ...] = Field(min_length=1, strict=False)
    free: str

    @model_validator(mode="after")
    def _in_pairs(self) -> Self:
        if len(self.first) != len(self.second):
            raise ValueError("first and second name as many rows as each other")
        return self


class _File(Strict):
    difference: list[Difference] = Field(min_length=1)


@dataclass(frozen=True)
class Closed:
    """One difference with its figures; texts are in the rows' own units."""

    what: str
    published: str
    first: str
    second: str
    unit: str
    free: str

    def as_json(self) -> dict[str, Any]:
        """Return the object that ``reproduce --closed --json`` prints of it."""
        return dict(self.__dict__)


def read_closed(study: Path) -> tuple[Difference, ...]:
    """Return the differences of a study, none where it has no file.

    Raises:
        ScenarioError: the file says something wrong, or names no row.
    """
    file = study / FILE
    if not file.exists():
        return ()
    try:
        found = _File.model_validate(read_toml(file)).difference
    except ValidationError as error:
        raise ScenarioError(f"{file}: " + "; ".join(complaints(error))) from None
    rows = read_reference(study / "reference.toml").figures
    for one in found:
        for name in (*one.first, *one.second):
            if name not in rows:
                remedy = did_you_mean(name, rows)
                raise ScenarioError(f"{file}: {one.what}: no row {name!r}; {remedy}")
        for before, after in zip(one.first, one.second, strict=True):
            if _published(rows[before]) != _published(rows[after]):
                fault = f"{before} and {after} have not the same published figure"
                raise ScenarioError(f"{file}: {one.what}: {fault}")
    return tuple(found)


def rows_of(differences: Sequence[Difference]) -> tuple[str, ...]:
    """Return the ids of all rows that the differences name, each once."""
    named = (name for one in differences for name in (*one.first, *one.second))
    return tuple(dict.fromkeys(named))


def closed(
    differences: Sequence[Difference], figures: Mapping[str, Figure]
) -> list[Closed]:
    """Return the differences with the figures of a reproduction."""
    found = []
    for one in differences:
        specs = [figures[name].spec for name in one.second]
        units = [spec.unit for spec in specs]
        shared = units[0] if len(set(units)) == 1 else ""

        def told(values: Sequence[str], units: Sequence[str] = units) -> str:
            apart = len(set(units)) > 1
            both = zip(values, units, strict=True)
            return ", ".join(f"{v} {u}" if apart and u != "1" else v for v, u in both)

        found.append(
            Closed(
                one.what,
                told([_published(spec) for spec in specs]),
                told([_value(figures[name]) for name in one.first]),
                told([_value(figures[name]) for name in one.second]),
                "" if shared == "1" else shared,
                one.free,
            )
        )
    return found


def _published(spec: FigureSpec) -> str:
    """Return a number, or a statement by its bounds, whatever it is told as."""
    if isinstance(spec.published, int | float):
        return f"{spec.published:g}"
    return "-" if spec.published is None else str(spec.published)


def _value(figure: Figure) -> str:
    return "-" if figure.value is None else f"{figure.value:.4g}"
