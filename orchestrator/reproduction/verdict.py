"""Our figures beside the published ones: verdict, regression, and how many of each.

The verdict is about the source (``published.py``); the regression about ourselves:
``holds`` or ``FAILED`` where ``expected`` is given, ``FAILED`` also where the run does
not have the figure it should have.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from orchestrator.quantities.quantity import NoValue, Quantity
from orchestrator.reproduction.published import Statement, Verdict, judge
from orchestrator.reproduction.reference import FigureSpec

Regression: TypeAlias = Literal["holds", "FAILED"]

MEANING: dict[Verdict, str] = {
    "agrees": "the published number within the agreement, or the statement is kept",
    "differs": "further from the published number than the agreement",
    "contradicts": "a bound, range or comparison of the source is violated",
    "computed": "nothing is published",
    "out of reach": "ours lacks what the source does not print, or there is no number",
}
CLASSES = ("derived", "calibrated", "out of reach")


@dataclass(frozen=True)
class Figure:
    """A published figure, ours, and what each makes of the other.

    ``difference`` is ours - published, ``lost`` says why the run did not have the
    figure, ``agreement`` is what the verdict allowed.
    """

    spec: FigureSpec
    value: float | None
    verdict: Verdict
    regression: Regression | None
    agreement: float
    difference: float | None = None
    lost: str = ""

    @property
    def why(self) -> str:
        """Why ours is missing or not the published one, as far as known."""
        drawn = self.spec.published == "drawn" and "drawn there, without numbers"
        return "; ".join(text for text in (self.lost, drawn, self.spec.why) if text)

    def row(self) -> dict[str, Any]:
        """Return the object that ``reproduce --json`` prints for this figure."""
        published: Any = self.spec.published
        if isinstance(published, Statement):
            published = published.model_dump(exclude_defaults=True)
        return {
            "id": self.spec.id,
            "where": self.spec.where,
            "obtained": self.spec.obtained,
            "published": published,
            "value": self.value,
            "unit": self.spec.unit,
            "class": self.spec.class_,
            "verdict": self.verdict,
            "regression": self.regression,
            "agreement": self.agreement,
            "expected": self.spec.expected,
            "tolerance": self.spec.allowed,
            "difference": self.difference,
            "why": self.why,
        }


def judge_figure(
    spec: FigureSpec, values: Mapping[str, Quantity | None], agreement: float
) -> Figure:
    """Return a figure with its verdict; ``values`` has it and those it is held against.

    ``agreement`` is the study's, for rows without their own.
    """
    agreement = spec.agreement or agreement
    found = values[spec.id]
    if isinstance(found, NoValue):
        verdict: Verdict = "computed" if spec.published is None else "differs"
        return Figure(spec, None, verdict, "FAILED", agreement, lost=found.why)
    numbers = {
        name: None
        if quantity is None or isinstance(quantity, NoValue)
        # compared in this figure's own unit
        else quantity.to(spec.unit).value
        for name, quantity in values.items()
        if name in (spec.id, spec.other)
    }
    value = numbers[spec.id]
    verdict = judge(spec.published, value, numbers, agreement, spec.rounded)
    return Figure(
        spec,
        value,
        "out of reach" if spec.class_ == "out of reach" else verdict,
        _regression(spec, value),
        agreement,
        _difference(spec, value, numbers),
    )


def _regression(spec: FigureSpec, value: float | None) -> Regression | None:
    if value is None or spec.expected is None or spec.allowed is None:
        return None
    return "holds" if abs(value - spec.expected) <= spec.allowed else "FAILED"


def _difference(
    spec: FigureSpec, value: float | None, numbers: Mapping[str, float | None]
) -> float | None:
    published = spec.published
    if isinstance(published, Statement) and published.equals is not None:
        other = numbers[published.equals]
        published = None if other is None else (published.factor or 1) * other
    if value is None or not isinstance(published, float):
        return None
    return value - published


def summary(figures: Sequence[Figure]) -> dict[str, Any]:
    """Return how many figures there are of each verdict and class, and regressions."""
    verdicts = {
        verdict: {
            kind: sum(f.verdict == verdict and f.spec.class_ == kind for f in figures)
            for kind in CLASSES
        }
        for verdict in MEANING
    }
    regressions = [f.regression for f in figures]
    return {
        "figures": len(figures),
        "verdicts": verdicts,
        "regression": {
            "holds": regressions.count("holds"),
            "FAILED": regressions.count("FAILED"),
            "not expected": regressions.count(None),
        },
        "without why": [
            f.spec.id
            for f in figures
            if f.verdict in ("differs", "contradicts") and not f.why
        ],
    }
