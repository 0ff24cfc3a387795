"""Every way a run can be refused or fail; the only errors a user meets.

A message names file, component, variable and time as far as they apply, what
was expected, and what to do.  ``exit_code`` is what the command returns.
"""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from unicodedata import category


class FeedDriveError(Exception):
    """Base of all errors a user can cause or meet.

    ``folder`` is that of the run whose rows until then can be read.
    """

    exit_code = 2
    folder: Path | None = None


class ScenarioError(FeedDriveError):
    """A scenario, override or map does not say something that can be run."""


class WiringError(FeedDriveError):
    """Ports, units or loops of a composition do not fit."""


class ScheduleError(FeedDriveError):
    """Periods, offsets or the stop time cannot be met exactly."""


class FmuError(FeedDriveError):
    """An FMU file is missing, damaged, unsafe or not usable here."""


class DesignError(FeedDriveError):
    """An offline design step could not be carried out."""


class FitError(FeedDriveError):
    """Measured data and a scenario do not make a fit."""


class ResponseError(FeedDriveError):
    """A composition has no such loop, or its response cannot be measured."""


class PluginError(FeedDriveError):
    """What another package adds to feeddrive cannot be used."""


class TuneError(FeedDriveError):
    """What is to be tuned is not there, or no values keep the constraints."""


class SimulationError(FeedDriveError):
    """A run failed after it had begun; what was recorded stays readable."""

    exit_code = 1


class ProcessEnded(SimulationError):
    """The process of an FMU ended before its run did."""


class Interrupted(FeedDriveError):
    """A run was stopped by Ctrl-C after rows had been written; says where they are."""

    exit_code = 130


def shown(text: str) -> str:
    """Return a text for a terminal: what would steer it is shown instead of obeyed.

    Control characters, those that turn the direction of writing and halves of
    characters (of names that are no UTF-8) are written as Python writes them.
    """
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() or c in "\n\t" or category(c) == "Zs" else repr(c)[1:-1]
        for c in text
    )


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return a remedy for a misspelt name: the nearest, or all there are."""
    names = sorted(known)
    if near := get_close_matches(name, names, n=3, cutoff=0.5):
        return f"did you mean {' or '.join(map(repr, near))}?"
    if not names:
        return "there are none."
    more = f" and {len(names) - 12} more" if len(names) > 12 else ""
    shown = ", ".join(names[:12]) + more
    return f"there are: {shown}."
