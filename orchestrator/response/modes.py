"""Whether anything grows: by eigenvalues of equations, or by what periods differ.

An integrator, a counter and a free oscillation stay as large as they are, |z| = 1;
rounding moves an eigenvalue no further than its condition allows.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

Real = NDArray[np.float64]

ROUNDING = 1e3  # times what rounding of each element does to an eigenvalue
FITTED = 0.1  # of the last difference: what two before it need not explain
GROWN = 1e-3  # growth over a period that is not told from none


@dataclass(frozen=True)
class Growth:
    """The mode that grows fastest: by ``rate`` (1/s), turning at ``hz``."""

    rate: float
    hz: float

    def __str__(self) -> str:
        turning = f", turning at {self.hz:.3g} Hz" if self.hz else ""
        return (
            f"grows by {self.rate:.3g} 1/s (tenfold in {self.tenfold:.3g} s){turning}"
        )

    @property
    def tenfold(self) -> float:
        """After how long (s) it is ten times as large."""
        return float(np.log(10) / self.rate)


def growth(A: Real, seconds: float) -> Growth | None:
    """Return what grows fastest in x = A x after each ``seconds``; None: nothing."""
    if not len(A) or np.max(np.abs(np.linalg.eigvals(A))) <= 1:
        return None
    z, left, right = eig(A, left=True, right=True)
    moved = np.sum(np.abs(left) * (np.abs(A) @ np.abs(right)), axis=0)
    along = np.abs(np.sum(left.conj() * right, axis=0))
    unsure = ROUNDING * np.finfo(float).eps * moved
    grown = np.abs(z)
    beyond = (grown - 1) * along > unsure
    if not np.any(beyond):
        return None
    largest = z[beyond][np.argmax(grown[beyond])]
    turn = abs(float(np.angle(largest))) / (2 * np.pi * seconds)
    return Growth(float(np.log(abs(largest))) / seconds, turn)


def grows(values: Real, fitted: float = FITTED) -> bool:
    """Whether the differences of successive periods (periods, n) grow, and evenly.

    The last one must follow from the two before, as of a mode or a pair of them:
    noise does not.  z² = a z + b then says how they go on.
    """
    if len(values) < 4:
        return False
    one, two, three = np.diff(values[-4:], axis=0)
    size = np.linalg.norm(three)
    if not 0 < size < np.inf:
        return False
    before = np.column_stack([two, one])
    (a, b), *_ = np.linalg.lstsq(before / size, three / size, rcond=1e-9)
    left = float(np.linalg.norm(three - before @ [a, b]) / size)
    largest = float(np.max(np.abs(np.roots([1.0, -a, -b]))))
    return left < fitted and largest > 1 + GROWN + 3 * left
