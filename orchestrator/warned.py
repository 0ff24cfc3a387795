"""What a user has to know of a run that goes on all the same.

``warn`` is for whatever may change a figure: a conversion that is a guess, a value
that was not taken over, a setting without effect.  It is logged, which a terminal
shows without ``-v``, and stands in ``Run.warnings``: JSON and report.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from orchestrator.errors import shown

LOG = logging.getLogger("feeddrive")
_COLLECTED: ContextVar[list[str] | None] = ContextVar("warnings", default=None)


def warn(text: str) -> None:
    """Say something once to the user, and to the run that is being made."""
    collected = _COLLECTED.get()
    if collected is None:
        LOG.warning("%s", shown(text))
    elif text not in collected:
        LOG.warning("%s", shown(text))
        collected.append(text)


@contextmanager
def collecting() -> Iterator[list[str]]:
    """Give the list that takes what is warned of inside, and nowhere else."""
    found: list[str] = []
    token = _COLLECTED.set(found)
    try:
        yield found
    finally:
        _COLLECTED.reset(token)
