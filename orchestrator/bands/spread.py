"""What a published figure could be, over what its source does not print.

``bands.toml`` of a study has a table per scenario::

    [track_500_p_pi]
    scenario = "p_pi_c_track_500"
    set = ["plant.friction.on=true"]       # what holds throughout
    members = 32                           # of a Sobol sequence, always the same
    rows = { "p_pi_c.track_500.peak" = "tracking.peak" }    # row: figure of the run
    [[track_500_p_pi.unknown]]
    keys = ["trajectory.j_max"]            # all take the same value
    between = [200, 1000]
    why = "the jerk is not printed"

A member takes a value of each range, even over all of them; the band of a row is from
the least figure of the members to the largest.  Members that fail or diverge are
counted and left out: the source's drive ran.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from orchestrator.analysis.sweep import sweep
from orchestrator.analysis.variations import Tolerance, sample
from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.evaluation.schema import Strict
from orchestrator.quantities.quantity import Quantity
from orchestrator.reproduction.published import Published, Statement
from orchestrator.reproduction.reference import FigureSpec, read_reference
from orchestrator.scenario.complaints import complaints
from orchestrator.scenario.reading import read_toml

FILE = "bands.toml"
SEED = 20


class Unknown(Strict):
    """Keys that take one value together, and between what."""

    keys: tuple[str, ...] = Field(min_length=1, strict=False)
    between: tuple[float, float] = Field(strict=False)
    why: str


class Spread(Strict):
    """The members of a scenario, and which rows they give a band."""

    scenario: str
    set: tuple[str, ...] = Field(default=(), strict=False)
    members: int = Field(default=32, ge=2)
    rows: dict[str, str] = Field(min_length=1)
    unknown: tuple[Unknown, ...] = Field(min_length=1, strict=False)


@dataclass(frozen=True)
class Band:
    """What a row could be: from ``low`` to ``high`` in the row's unit.

    ``inside`` tells whether the published value, or a value that it allows, is there;
    ``members`` ran, ``failed`` did not or diverged; ``over`` says over what.
    """

    row: str
    where: str
    published: str
    unit: str
    low: float
    high: float
    inside: bool
    members: int
    failed: int
    over: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the object that ``reproduce --bands --json`` prints of it."""
        return {**self.__dict__, "over": list(self.over)}


def read_bands(study: Path) -> dict[str, Spread]:
    """Return the spreads of a study by name, none where it has no file.

    Raises:
        ScenarioError: the file says something wrong.
    """
    file = study / FILE
    if not file.exists():
        return {}
    found = {}
    for name, table in read_toml(file).items():
        try:
            found[name] = Spread.model_validate(table)
        except ValidationError as error:
            told = "; ".join(f"{name}: {text}" for text in complaints(error))
            raise ScenarioError(f"{file}: {told}") from None
    return found


def bands(
    study: Path,
    members: int | None = None,
    told: Callable[[str], None] = lambda text: None,
) -> list[Band]:
    """Return the bands of a study's rows, one sweep for each scenario.

    ``members`` takes the place of the file's numbers; ``told`` hears of each sweep.

    Raises:
        FeedDriveError: the file is wrong, or a scenario cannot be composed.
    """
    rows = read_reference(study / "reference.toml").figures
    found: list[Band] = []
    for name, spread in read_bands(study).items():
        for row in spread.rows:
            if row not in rows:
                remedy = did_you_mean(row, rows)
                raise ScenarioError(f"{study / FILE}: {name}: no row {row!r}; {remedy}")
        found += _bands(study, name, spread, rows, members or spread.members)
        told(name)
    return found


def _bands(
    study: Path, name: str, spread: Spread, rows: Mapping[str, FigureSpec], n: int
) -> list[Band]:
    drawn = sample(
        [Tolerance(u.keys[0], "uniform", *u.between) for u in spread.unknown],
        "sobol",
        n,
        SEED,
    )
    members = [
        {key: one[u.keys[0]] for u in spread.unknown for key in u.keys} for one in drawn
    ]
    for row in spread.rows:
        said = rows[row].published
        if isinstance(said, Statement) and said.other:
            raise ScenarioError(
                f"{name}: {row} is compared with {said.other}, of which the "
                f"members of a band say nothing; leave the row out"
            )
    done = sweep(study / f"{spread.scenario}.toml", members, sets=spread.set)
    over = tuple(
        f"{', '.join(u.keys)} {u.between[0]:g} to {u.between[1]:g}: {u.why}"
        for u in spread.unknown
    )
    found = []
    for row, figure in spread.rows.items():
        if figure not in done.units:
            remedy = did_you_mean(figure, done.units)
            raise ScenarioError(
                f"{name}: {spread.scenario} has no {figure!r}; {remedy}"
            )
        spec = rows[row]
        unit = done.units[figure]
        values = [
            Quantity(float(one[figure]), unit).to(spec.unit).value
            for one in done.rows
            if one["failure"] is None and one.get(figure) is not None
        ]
        if not values:
            raise ScenarioError(f"{name}: no member has {figure}")
        low, high = min(values), max(values)
        inside = _inside(spec.published, low, high)
        published = "" if spec.published is None else str(spec.published)
        head = row, spec.where, published, spec.unit, low, high, inside
        found.append(Band(*head, len(values), n - len(values), over))
    return found


def _inside(published: Published | None, low: float, high: float) -> bool:
    if isinstance(published, Statement):
        ends = published.between or (published.above, published.below)
        least, most = ends
        return (most is None or low < most) and (least is None or high > least)
    return isinstance(published, int | float) and low <= published <= high
