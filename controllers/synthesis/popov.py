"""Absolute stability of a linear loop with one memoryless gain N(e), by frequency.

The loop gain is G(jω) N with N in a sector.  Of use:

    crossing     where G meets the negative real axis: N constant, N < -1/Re G
    Popov        Re[(1 + jωq) G] > -1/K for one q >= 0:  0 <= N(e) <= K
    circle       the same with q = 0; N may then depend on time too

For a sector [a, K] the loop is shifted first, G/(1 + aG), K - a; it must be
stable with N = a, which the caller knows.
Source: Anang et al. 2018, sec. 3.3, eq. 7; Khalil, Nonlinear Systems, sec. 7.1.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.optimize import brentq, linprog

from controllers.synthesis.frequency import ComplexArray
from fmus.model import FloatArray

Locus: TypeAlias = Callable[[FloatArray], ComplexArray]

GRID: FloatArray = np.geomspace(1e-2, 1e5, 14_001)  # rad/s


class Crossing(NamedTuple):
    """A crossing of the negative real axis: Re G and ω (rad/s)."""

    re: float
    omega: float


class Sector(NamedTuple):
    """The sector [a, K] that is certified, with the multiplier's q (s)."""

    K: float
    q: float


def crossing(G: Locus, omega: FloatArray = GRID) -> Crossing:
    """Return the crossing of the negative real axis that is farthest left.

    The Popov plot (Re G, ω Im G) has the same crossings as the Nyquist plot.

    Args:
        G: frequency response, ω (n,) in rad/s -> complex (n,).
        omega: grid that separates the crossings, ascending, shape (n,).

    Raises:
        ValueError: G does not cross the negative real axis on the grid.
    """
    values = G(omega)
    changes = np.flatnonzero(np.diff(np.sign(values.imag)) != 0)
    found = []
    for i in changes:
        at = brentq(
            lambda w: float(G(np.array([w]))[0].imag),
            omega[i],
            omega[i + 1],
            xtol=1e-12 * omega[i],
        )
        found.append(Crossing(float(G(np.array([at]))[0].real), float(at)))
    if not found or (leftmost := min(found)).re >= 0:
        raise ValueError("the locus does not cross the negative real axis")
    return leftmost


def shifted(G: Locus, a: float) -> Locus:
    """Return G/(1 + aG): the loop with the gain a closed around it."""

    def moved(omega: FloatArray) -> ComplexArray:
        values = G(omega)
        shift: ComplexArray = values / (1 + a * values)
        return shift

    return moved


def popov(
    G: Locus, a: float = 0.0, omega: FloatArray = GRID, q: float | None = None
) -> Sector:
    """Return the largest sector [a, K] that Popov's criterion certifies.

    Linear in (1/K, q), hence solved as a linear program; ``q = 0`` asks the
    circle criterion instead.  K is infinite where nothing limits it.

    Args:
        G: frequency response, ω (n,) in rad/s -> complex (n,).
        a: lower end of the sector.
        omega: frequencies at which the criterion is asked, shape (n,).
        q: slope of the Popov line (s), found if not given.
    """
    values = shifted(G, a)(omega)
    # -Re G + q ω Im G <= 1/(K - a) at every frequency, q in seconds per unit scale
    scale = 1 / float(np.median(omega))
    rows = np.column_stack([omega * scale * values.imag, -np.ones_like(omega)])
    bounds = (0, None) if q is None else (q / scale, q / scale)
    best = linprog([0, 1], rows, values.real, bounds=[bounds, (0, None)])
    inverse, slope = float(best.x[1]), float(best.x[0]) * scale
    return Sector(a + 1 / inverse if inverse > 0 else np.inf, slope)
