"""What a source says of a figure, as data, and whether ours keeps to it.

``published`` of a row is one of::

    100                                          a number
    "drawn"                                      a curve or picture without numbers
    { below = 10 }  { above = 0 }                a bound
    { between = [160, 250] }                     a range, ends included
    { equals = "other.id" }                      as another figure of ours, or
    { less_than = "other.id", factor = 0.5 }     below half of it, or
    { greater_than = "other.id", percent = 40 }  above it by at least 40 percent

and any of the tables may quote the sentence: ``says = "did not change"``.
``factor`` multiplies the other figure, ``percent`` moves it further.

A number differs, a bound, range or comparison is contradicted; ``agreement`` is
the relative difference that a number or ``equals`` allows.  ``rounded`` is the
step to which a number was printed; half of it is allowed besides.
"""

from collections.abc import Mapping
from math import inf
from typing import Literal, TypeAlias

from pydantic import Field, model_validator

from orchestrator.evaluation.schema import Strict

Verdict: TypeAlias = Literal[
    "agrees", "differs", "contradicts", "computed", "out of reach"
]


class Statement(Strict):
    """A bound, a range, or a comparison with another figure of the study."""

    below: float | None = None
    above: float | None = None
    between: tuple[float, float] | None = Field(default=None, strict=False)
    equals: str | None = None
    less_than: str | None = None
    greater_than: str | None = None
    factor: float | None = Field(default=None, gt=0)
    percent: float | None = Field(default=None, gt=0)
    says: str = ""

    @model_validator(mode="after")
    def _says_one_thing(self) -> "Statement":
        numbers = (self.below, self.above, self.between)
        names = (self.equals, self.less_than, self.greater_than)
        if sum(given is not None for given in (*numbers, *names)) != 1:
            raise ValueError(
                "give one of below, above, between, equals, less_than, greater_than"
            )
        if self.between is not None and self.between[0] >= self.between[1]:
            raise ValueError("between takes the lower end, then the upper end")
        if self.factor is not None and self.percent is not None:
            raise ValueError("give factor or percent, not both")
        moved = self.factor is not None or self.percent is not None
        if moved and self.other is None:
            raise ValueError("factor and percent belong to a comparison with a figure")
        if self.equals is not None and self.percent is not None:
            raise ValueError("equals takes a factor; agreement is how far it may be")
        return self

    @property
    def other(self) -> str | None:
        """The figure it is compared with, if any."""
        return self.equals or self.less_than or self.greater_than

    def __str__(self) -> str:
        if self.between is not None:
            return "{:g} to {:g}".format(*self.between)
        if self.below is not None:
            return f"< {self.below:g}"
        if self.above is not None:
            return f"> {self.above:g}"
        sign = "=" if self.equals else "<" if self.less_than else ">"
        times = self._times()
        return (
            f"{sign} {self.other}" if times == 1 else f"{sign} {times:g} {self.other}"
        )

    def _times(self) -> float:
        if self.percent is not None:
            return 1 + (-self.percent if self.less_than else self.percent) / 100
        return self.factor or 1.0

    def keeps(self, value: float, other: float | None, agreement: float) -> bool:
        """Tell whether ``value`` keeps to it; ``other`` is the figure compared with."""
        if self.between is not None:
            return self.between[0] <= value <= self.between[1]
        if other is None:
            low = -inf if self.above is None else self.above
            return low < value < (inf if self.below is None else self.below)
        limit = self._times() * other
        if self.equals:
            return abs(value - limit) <= agreement * abs(limit)
        return value < limit if self.less_than else value > limit


Published: TypeAlias = float | Literal["drawn"] | Statement


def judge(
    published: Published | None,
    value: float | None,
    values: Mapping[str, float | None],
    agreement: float,
    rounded: float = 0.0,
) -> Verdict:
    """Return what the published figure makes of ours; ``values`` has the others'."""
    if value is None or published == "drawn":
        return "out of reach"
    if published is None:
        return "computed"
    if isinstance(published, Statement):
        other = None if published.other is None else values[published.other]
        if published.other is not None and other is None:
            return "out of reach"
        return "agrees" if published.keeps(value, other, agreement) else "contradicts"
    assert not isinstance(published, str)
    limit = agreement * abs(published) + rounded / 2
    return "agrees" if abs(value - published) <= limit else "differs"
