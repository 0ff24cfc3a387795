"""When the periods of a run are those of a steady state.

1. all that is observed has answered, once that could have arrived: nothing yet is no
   answer;
2. periods agree, or differ by noise alone, for as long as anything is under way;
3. nothing grows, neither in what answers nor without injection.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orchestrator.response.modes import grows

Real = NDArray[np.float64]
Bools = NDArray[np.bool_]

AGREED = 1e-7  # of the rms of a period, from one to the next
MIN, EVEN = 4, 1.3  # ratio of differences from period to period that are noise alone
FINE, UNEVEN = 1e-5, 3.0  # and of differences as small as that, which are round-off
ROUND_OFF = 1e-12  # of a signal, that its difference to another run may be
HUGE = 1e50  # no signal of a stable loop
EXACT = 1e-3  # of a difference without injection that is no mode: it may be in motion


@dataclass(frozen=True)
class Periods:
    """What was observed, (observed, periods, n): more than without injection
    (``quiet``), and how many periods it may be ``late``."""

    values: Real
    quiet: Real
    late: int

    @property
    def sizes(self) -> Real:
        """The rms of each period (observed, periods); what is round-off is 0."""
        size = np.sqrt(np.mean(self.values**2, axis=2))
        round_off = ROUND_OFF * np.max(np.abs(self.quiet), axis=(1, 2))
        found: Real = np.where(size > round_off[:, None], size, 0.0)
        return found

    @property
    def silent(self) -> Bools:
        """Which of what is observed (observed,) does not answer in the last period."""
        found: Bools = self.sizes[:, -1] == 0
        return found

    @property
    def finite(self) -> bool:
        return bool(np.max(np.abs(self.values[:, -1])) < HUGE)

    def steady(self, *, last: bool) -> int | None:
        """Return how many of the periods are transient, None if all may be.

        The ``last`` try takes periods whose differences do not grow, whatever else
        these do, if they are small.
        """
        answering = ~self.silent
        if not self.finite or self.growing:
            return None
        if not np.any(answering):
            return 0
        sizes = self.sizes[answering]
        values = self.values[answering] / sizes[:, -1, None, None]
        waited = max(self.late, 1, *(int(n) for n in np.argmax(sizes > 0, axis=1) + 1))
        first = _agreeing(values, last=last)
        return (
            first if first is not None and waited <= values.shape[1] - first else None
        )

    @property
    def growing(self) -> bool:
        """Whether differences of successive periods grow, injected or not."""
        if not self.finite:
            return True
        answers = (
            self.values
            / np.where(self.silent, np.inf, self.sizes[:, -1])[:, None, None]
        )
        return grows(_side_by_side(answers)) or any(
            grows(quiet, EXACT) for quiet in self.quiet
        )


def _side_by_side(values: Real) -> Real:
    """Return (observed, periods, n) as (periods, all of them)."""
    return values.transpose(1, 0, 2).reshape(values.shape[1], -1)


def _agreeing(values: Real, *, last: bool) -> int | None:
    size = np.sqrt(np.mean(values[:, -1] ** 2))
    apart = np.sqrt(np.mean(np.diff(values, axis=1) ** 2, axis=(0, 2)))
    late = np.flatnonzero(apart > max(AGREED * size, 2 * apart[-1]))
    first = int(late[-1]) + 2 if len(late) else 1
    if apart[-1] <= AGREED * size:
        return first
    tail = apart[len(apart) // 2 :]
    ratio = UNEVEN if np.max(tail) < FINE * size else EVEN
    even = len(apart) >= MIN and np.max(tail) <= ratio * np.min(tail)
    noise = apart[-1] < size / 2 and first <= len(apart) // 2
    return first if noise and (even or last) else None
