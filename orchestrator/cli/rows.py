"""Options of verbs that read files of signals: what lies between their rows."""

from fractions import Fraction
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.errors import ScenarioError
from orchestrator.quantities.quantity import parse_period

if TYPE_CHECKING:
    from orchestrator.signals.ticks import Interpolation

Between = Annotated[
    str, typer.Option("--interpolation", help="hold or linear, between the rows")
]
Rate = Annotated[
    str | None,
    typer.Option("--rate", help='how far apart the rows are, e.g. "10 kHz"'),
]


def interpolation(text: str) -> "Interpolation":
    """Return what ``--interpolation`` chooses.

    Raises:
        ScenarioError: it is neither hold nor linear.
    """
    if text == "hold":
        return "hold"
    if text == "linear":
        return "linear"
    raise ScenarioError(f"--interpolation {text}: choose hold or linear")


def time(text: str | None, option: str) -> Fraction | None:
    """Return the time (s) that an option such as ``--rate`` gives, if it is given.

    Raises:
        ScenarioError: it is no time and no rate.
    """
    if text is None:
        return None
    try:
        return parse_period(text)
    except ValueError as error:
        raise ScenarioError(f"{option}: {error}") from None
