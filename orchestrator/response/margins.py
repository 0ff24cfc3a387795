"""What margin a measured loop has: crossovers, gain, phase, delay, modulus.

L is the open loop with u = -L u_after, S = 1/(1 + L), T = L S.  Between two lines
log |L| and the phase go linearly over log f; the peak of |S| is a parabola through
its three largest neighbours.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Real: TypeAlias = NDArray[np.float64]
Complex: TypeAlias = NDArray[np.complex128]


TINY = 1e-300  # of a magnitude whose logarithm is taken
FAR = np.log(1e3)  # a gain by which nothing is multiplied


@dataclass(frozen=True)
class Crossover:
    """Where |L| = 1, and how much phase (deg, -180 to 180) is left there."""

    hz: float
    phase_margin_deg: float


@dataclass(frozen=True)
class GainMargin:
    """Where L is real and negative, and the gain (dB) that makes it -1 there."""

    hz: float
    db: float


@dataclass(frozen=True)
class Margins:
    """The margins of one loop; all that a loop has none of is infinite.

    ``phase_margin_deg`` is the smallest by magnitude, ``gain_margin_db`` by how much
    the gain may grow, ``crossover_hz`` where |L| first passes 1.  Gain margins beyond
    60 dB are left out.
    """

    crossovers: tuple[Crossover, ...]
    gain_margins: tuple[GainMargin, ...]
    s_max: float
    s_max_hz: float

    @property
    def modulus_margin(self) -> float:
        """The least distance of L from -1."""
        return 1 / self.s_max

    @property
    def phase_margin_deg(self) -> float:
        found = (c.phase_margin_deg for c in self.crossovers)
        return min(found, key=abs, default=np.inf)

    @property
    def gain_margin_db(self) -> float:
        return min((m.db for m in self.gain_margins if m.db > 0), default=np.inf)

    @property
    def crossover_hz(self) -> float:
        return min((c.hz for c in self.crossovers), default=np.inf)

    @property
    def delay_margin_s(self) -> float:
        """The dead time that takes the loop to its border."""
        turns = ((c.phase_margin_deg % 360 / 360 / c.hz) for c in self.crossovers)
        return min(turns, default=np.inf)


def margins(hz: Real, L: Complex) -> Margins:
    """Return the margins of L (n,) at the lines ``hz`` (n,), ascending."""
    size, phase = np.log(np.maximum(np.abs(L), TINY)), np.unwrap(np.angle(L))
    x = np.log(hz)
    crossovers = tuple(
        Crossover(float(np.exp(f)), _half_turn(180 + np.degrees(p)))
        for f, p in _zeros(x, size, phase)
    )
    gains: list[GainMargin] = []
    for turn in range(int(np.min(phase) // np.pi), int(np.max(phase) // np.pi) + 2):
        if turn % 2:
            for f, m in _zeros(x, phase - turn * np.pi, size):
                if abs(m) < FAR:
                    gains.append(GainMargin(float(np.exp(f)), -20 / np.log(10) * m))
    peak_hz, s_max = peak(hz, np.abs(1 / (1 + L)))
    return Margins(crossovers, tuple(sorted(gains, key=lambda g: g.hz)), s_max, peak_hz)


def peak(hz: Real, size: Real) -> tuple[float, float]:
    """Return where a magnitude is largest, and how large: a parabola over log f."""
    i = int(np.argmax(size))
    if 0 < i < len(hz) - 1:
        x, y = np.log(hz[i - 1 : i + 2]), size[i - 1 : i + 2]
        a, b, _ = np.polyfit(x - x[1], y, 2)
        if a < 0:
            return float(hz[i] * np.exp(-b / (2 * a))), float(y[1] - b**2 / (4 * a))
    return float(hz[i]), float(size[i])


def delayed(hz: Real, L: Complex, seconds: float) -> Complex:
    """Return the loop with this much more (or less) dead time in it."""
    later: Complex = L * np.exp(-2j * np.pi * hz * seconds)
    return later


def _zeros(x: Real, y: Real, other: Real) -> Iterator[tuple[float, float]]:
    """Yield where y changes its sign, and what ``other`` is there."""
    for i in np.flatnonzero((y[:-1] > 0) != (y[1:] > 0)):
        share = y[i] / (y[i] - y[i + 1])
        yield (
            float(x[i] + share * (x[i + 1] - x[i])),
            float(other[i] + share * (other[i + 1] - other[i])),
        )


def _half_turn(degrees: float) -> float:
    return float((degrees + 180) % 360 - 180)
