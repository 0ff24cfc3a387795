"""What ``reference.toml`` of a study says: published figures and where ours come from.

The file holds ``title``, ``source``, ``agreement`` (relative difference up to
which a number counts as agreeing; default 0.05), ``obtained`` (how the source got
its figures where a row does not say) and rows::

    [[figure]]
    id = "mc_ppc.track_500_prefilter.peak"
    where = "Table 3.2"            # in the source
    obtained = "measured"          # there; or "computed", "plot", "stated"
    published = 3.34               # see published.py; left out if there is nothing
    unit = "um"
    class = "derived"              # or "calibrated", "out of reach"
    why = "friction unknown"       # why ours is not the published one, or is here
    agreement = 0.1                # where it is not the study's
    expected = 0.063               # our own acceptance value, and
    tolerance = 0.01               # how far we may be from it; or "1 %" of it

and one source of our value (none only where out of reach)::

    scenario = "track_500_mc_ppc"  metric = "tracking.peak"  set = ["stop=1"]
    call = "module:function"       key = "s_max"  arguments = { latency = 1 }
    formula = "100 * (1 - a / b)"  with = { a = "other.id", b = { scenario = ... } }

A scenario may be run many times over: ``repeats``, see ``repeats.py``.

What a design step of the run found is ``metric = "design.<step>.<name>"``.
A called function returns a number or a mapping of numbers, in ``unit``.
``[[table]]`` writes many rows at once, see ``table.py``.

``derived`` follows from what the source prints, ``calibrated`` rests on a number that
we chose against published figures, ``out of reach`` needs what the source does not
print; the latter is never judged.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.evaluation.schema import Strict
from orchestrator.reproduction.published import Published, Statement
from orchestrator.reproduction.repeats import Repeats
from orchestrator.reproduction.table import Table, TableError, expand
from orchestrator.scenario.complaints import complaints
from orchestrator.scenario.reading import read_toml

PERCENT = re.compile(r"(\d+\.?\d*) ?%")


class Source(Strict):
    """Where a value of ours comes from; keys as in the contract above."""

    unit: str = "1"
    scenario: str | None = None
    metric: str | None = None
    set: tuple[str, ...] = Field(default=(), strict=False)
    repeats: Repeats | None = None
    call: str | None = None
    key: str | None = None
    arguments: dict[str, Any] = Field(default_factory=dict)
    formula: str | None = None
    with_: dict[str, "str | Source"] = Field(alias="with", default_factory=dict)

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        sources = [self.scenario, self.call, self.formula]
        given = sum(source is not None for source in sources)
        if given > 1:
            raise ValueError("give one of scenario, call and formula")
        if given == 0 and not self._may_lack_source():
            raise ValueError("has no source: give scenario, call or formula")
        if (self.scenario is None) != (self.metric is None):
            raise ValueError("scenario and metric are given together")
        if self.repeats is not None and self.scenario is None:
            raise ValueError("repeats belong to a scenario")
        return self

    def _may_lack_source(self) -> bool:
        return False

    def sources(self) -> Iterator["Source"]:
        """Yield this source and those written inside its formula."""
        yield self
        for of in self.with_.values():
            if not isinstance(of, str):
                yield from of.sources()


class FigureSpec(Source):
    """One row of ``reference.toml``; keys as in the contract above."""

    id: str
    where: str
    obtained: Literal["measured", "computed", "plot", "stated"] | None = None
    published: Published | None = None
    class_: Literal["derived", "calibrated", "out of reach"] = Field(alias="class")
    why: str = ""
    agreement: float | None = Field(default=None, gt=0)
    rounded: float = Field(default=0.0, ge=0)
    expected: float | None = None
    tolerance: float | str | None = None

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.class_ == "out of reach" and not self.why:
            raise ValueError("is out of reach: say why")
        if self.published is None and not self.why:
            raise ValueError("has nothing published: say why it is here")
        if (self.expected is None) != (self.tolerance is None):
            raise ValueError("expected and tolerance are given together")
        if isinstance(self.tolerance, str) and not PERCENT.fullmatch(self.tolerance):
            raise ValueError(f'tolerance {self.tolerance!r}: write 0.1 or "1 %"')
        if not isinstance(self.tolerance, str | None) and self.tolerance <= 0:
            raise ValueError(f"tolerance {self.tolerance:g} must be greater than 0")
        return self

    def _may_lack_source(self) -> bool:
        return self.class_ == "out of reach"

    @property
    def other(self) -> str | None:
        """The figure that the published statement compares ours with, if any."""
        return self.published.other if isinstance(self.published, Statement) else None

    @property
    def allowed(self) -> float | None:
        """How far ours may be from ``expected``, in ``unit``."""
        if isinstance(self.tolerance, str) and self.expected is not None:
            return float(self.tolerance.rstrip(" %")) / 100 * abs(self.expected)
        assert not isinstance(self.tolerance, str)
        return self.tolerance


class _File(Strict):
    title: str = ""
    source: str = ""
    agreement: float = Field(default=0.05, gt=0)
    obtained: Literal["measured", "computed", "plot", "stated"] = "measured"
    table: list[dict[str, Any]] = Field(default_factory=list)
    figure: list[dict[str, Any]] = Field(default_factory=list)


@dataclass(frozen=True)
class Reference:
    """A study's published figures, those of its tables first."""

    title: str
    source: str
    agreement: float
    figures: dict[str, FigureSpec]
    tables: tuple[Table, ...]


def read_reference(file: Path) -> Reference:
    """Return a study's published figures.

    Raises:
        ScenarioError: the file is missing or says something wrong.
    """
    try:
        written = _File.model_validate(read_toml(file))
    except ValidationError as error:
        raise ScenarioError(f"{file}: " + "; ".join(complaints(error))) from None
    try:
        expanded = [expand(table, set(_keys())) for table in written.table]
    except TableError as error:
        raise ScenarioError(f"{file}: {error}") from None
    rows = [row for _, rows in expanded for row in rows]
    figures: dict[str, FigureSpec] = {}
    for number, row in enumerate([*rows, *written.figure]):
        spec = _figure(file, number, {"obtained": written.obtained, **row})
        if spec.id in figures:
            raise ScenarioError(f"{file}: two figures are called {spec.id}")
        figures[spec.id] = spec
    if not figures:
        raise ScenarioError(f"{file}: there must be at least one figure")
    for spec in figures.values():
        for name in _named_by(spec):
            if name not in figures:
                remedy = did_you_mean(name, figures)
                raise ScenarioError(f"{file}: {spec.id}: no figure {name!r}; {remedy}")
    tables = tuple(table for table, _ in expanded)
    agreement = written.agreement
    return Reference(written.title, written.source, agreement, figures, tables)


def _keys() -> Iterator[str]:
    for name, field in FigureSpec.model_fields.items():
        yield field.alias or name


def _figure(file: Path, number: int, row: dict[str, Any]) -> FigureSpec:
    try:
        return FigureSpec.model_validate(row)
    except ValidationError as error:
        name = f"figure {row.get('id', f'number {number}')}"
        told = "; ".join(f"{name}: {text}" for text in complaints(error))
        raise ScenarioError(f"{file}: {told}") from None


def _named_by(spec: FigureSpec) -> Iterator[str]:
    """Yield the ids that a row names."""
    if spec.other is not None:
        yield spec.other
    for source in spec.sources():
        yield from (of for of in source.with_.values() if isinstance(of, str))
