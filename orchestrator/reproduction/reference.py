"""What ``reference.toml`` of a study says: published figures and where ours come from.

The file holds ``title``, ``source``, ``agreement`` (relative difference up to
which a figure counts as matched; default 0.05) and rows::

    [[figure]]
    id = "mc_ppc.track_500.peak"
    where = "Table 3.2"            # in the source
    published = 3.34               # number or text; left out if there is none
    unit = "um"
    class = "derived"              # or "calibrated", "out of reach"
    why = "friction unknown"       # needed where out of reach
    expected = 2.490               # our own acceptance value, and
    tolerance = 0.005              # how far we may be from it

and one source of our value (none only where out of reach)::

    scenario = "track_500_mc_ppc"  metric = "tracking.peak"  set = ["stop=1"]
    call = "module:function"       key = "s_max"  arguments = { latency = 1 }
    formula = "100 * (1 - a / b)"  with = { a = "other.id", b = "another.id" }

What a design step of the run found is ``metric = "design.<step>.<name>"``.
A called function returns a number or a mapping of numbers, in ``unit``.
"""

import re
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, ValidationError, model_validator

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.evaluation.schema import Strict
from orchestrator.scenario.complaints import complaints
from orchestrator.scenario.reading import read_toml


class FigureSpec(Strict):
    """One row of ``reference.toml``; keys as in the contract above."""

    id: str
    where: str
    published: float | str | None = None
    unit: str = "1"
    class_: Literal["derived", "calibrated", "out of reach"] = Field(alias="class")
    why: str = ""
    expected: float | None = None
    tolerance: float | None = Field(default=None, gt=0)
    agreement: float | None = Field(default=None, gt=0)
    scenario: str | None = None
    metric: str | None = None
    set: tuple[str, ...] = Field(default=(), strict=False)
    call: str | None = None
    key: str | None = None
    arguments: dict[str, Any] = Field(default_factory=dict)
    formula: str | None = None
    with_: dict[str, str] = Field(alias="with", default_factory=dict)

    @model_validator(mode="after")
    def _one_source(self) -> "FigureSpec":
        sources = [self.scenario, self.call, self.formula]
        given = sum(source is not None for source in sources)
        if given > 1:
            raise ValueError("give one of scenario, call and formula")
        if given == 0 and self.class_ != "out of reach":
            raise ValueError("has no source: give scenario, call or formula")
        if self.class_ == "out of reach" and not self.why:
            raise ValueError("is out of reach: say why")
        if (self.scenario is None) != (self.metric is None):
            raise ValueError("scenario and metric are given together")
        if (self.expected is None) != (self.tolerance is None):
            raise ValueError("expected and tolerance are given together")
        return self


class Reference(Strict):
    """A study's published figures."""

    title: str = ""
    source: str = ""
    agreement: float = Field(default=0.05, gt=0)
    figure: list[FigureSpec] = Field(min_length=1)


def read_reference(file: Path) -> Reference:
    """Return a study's published figures.

    Raises:
        ScenarioError: the file is missing or says something wrong.
    """
    raw = read_toml(file)
    try:
        reference = Reference.model_validate(raw)
    except ValidationError as error:
        rows = raw.get("figure", [])
        named = (_named(complaint, rows) for complaint in complaints(error))
        raise ScenarioError(f"{file}: " + "; ".join(named)) from None
    seen: set[str] = set()
    for spec in reference.figure:
        if spec.id in seen:
            raise ScenarioError(f"{file}: two figures are called {spec.id}")
        seen.add(spec.id)
    for spec in reference.figure:
        for name in spec.with_.values():
            if name not in seen:
                remedy = did_you_mean(name, seen)
                raise ScenarioError(f"{file}: {spec.id}: no figure {name!r}; {remedy}")
    return reference


def _named(complaint: str, rows: Any) -> str:
    """Call a row by its id instead of its number."""
    match = re.match(r"figure\.(\d+)", complaint)
    if match is None or not isinstance(rows[int(match[1])], dict):
        return complaint
    name = rows[int(match[1])].get("id", f"number {match[1]}")
    return f"figure {name}{complaint[match.end() :]}"
