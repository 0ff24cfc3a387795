"""Coulomb and viscous friction, and how long to brake, from one open-loop run.

    v̇ = a i - c v - f    while the table moves one way

From the moments v(t_2) - v(t_1) over many intervals, by least squares: integrals
of i and v need no derivative of a reading.  With the moved inertia J + M r² known,
r = lead/2π,

    T_c = f (J + M r²)/r,    C_sd = c (J + M r²),    a = K_m r/(J + M r²)

The shortest pulse of braking u_b (1 + cos πt/t_b)/2 that stops the table stops it at
its end: with the run's a, c and f its t_b is solved for.  A much longer one stops it
while the current still overcomes the friction, and turns it back.
Source: Maeda 2007, appendix ("by traditional means"), fig. 2-3, 5-2 (the period "is
adjusted by try-and-error so that the velocity approaches zero without becoming
negative").
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from fmus.model import FloatArray

SLOWEST = 2e-3  # m/s: below it the bristle is not at its end


class Motion(NamedTuple):
    """a (m/s² per A), c (1/s), f (m/s²), and the speed error left (m/s, rms)."""

    a: float
    c: float
    f: float
    left: float


def fit(x: FloatArray, i: FloatArray, T_s: float, slowest: float = SLOWEST) -> Motion:
    """Return the law of motion behind a run that moves in the positive direction.

    Args:
        x: position (m), (n,).
        i: current (A), (n,), of the interval that ends at its sample, as ``axis.i`` is
            recorded.
        T_s: sample time (s).
        slowest: speed (m/s) below which samples do not count.

    Raises:
        ValueError: fewer than 50 samples move, or the current does not change.
    """
    x, i = np.asarray(x, dtype=float), np.asarray(i, dtype=float)
    v = np.gradient(x, T_s)
    moving = np.flatnonzero(v > slowest)
    if len(moving) < 50:
        raise ValueError(f"the run moves faster than {slowest:g} m/s for no 50 samples")
    here = slice(moving[0], moving[-1] + 1)
    t = np.arange(len(x))[here] * T_s
    charge = np.cumsum(i)[here] * T_s
    columns = np.stack([charge, -x[here], -t, np.ones_like(t)], axis=1)
    size = np.linalg.norm(columns, axis=0)
    weighed = columns / np.maximum(size, 1e-300)
    if np.min(size) == 0 or np.linalg.cond(weighed) > 1e8:
        raise ValueError("the current does not change: its effect is not told apart")
    a, c, f, _ = found = np.linalg.lstsq(weighed, v[here])[0] / size
    left = float(np.sqrt(np.mean((columns @ found - v[here]) ** 2)))
    return Motion(float(a), float(c), float(f), left)


def friction(
    x: FloatArray,
    i: FloatArray,
    T_s: float,
    J: float,
    M: float,
    lead: float,
    slowest: float = SLOWEST,
) -> dict[str, float]:
    """Return T_c (N m) and C_sd (N m s/rad) of the rotor: a design step.

    Args:
        x, i, T_s, slowest: as for ``fit``.
        J, M, lead: rotor's inertia (kg m²), mass of the table (kg), lead (m).
    """
    found = fit(x, i, T_s, slowest)
    r = lead / (2 * np.pi)
    inertia = J + M * r * r
    return {"T_c": found.f * inertia / r, "C_sd": found.c * inertia}


def braking(
    x: FloatArray,
    i: FloatArray,
    T_s: float,
    t_off: float,
    u_b: float = 6.0,
    slowest: float = SLOWEST,
) -> dict[str, float]:
    """Return t_b (s) of a fading pulse that brakes to rest: a design step.

    Args:
        x, i, T_s, slowest: of a run with the pulse wanted, braked by a D controller,
            as for ``fit``.
        t_off: when the braking begins (s).
        u_b: its height (A).

    Raises:
        ValueError: the run does not move at t_off, or shows no Coulomb friction.
    """
    found = fit(x, i, T_s, slowest)
    off = round(t_off / T_s)
    # one-sided: the acceleration jumps at t_off
    v_0 = float(3 * x[off] - 4 * x[off - 1] + x[off - 2]) / (2 * T_s)
    if v_0 <= slowest:
        raise ValueError(f"the run does not move at {t_off:g} s, when braking begins")

    if found.f <= 0:
        raise ValueError("the run shows no Coulomb friction: nothing ends its motion")

    def at_the_end(t_b: float) -> float:
        """Return the speed (m/s) when a pulse of that length, held by samples, ends."""
        t = np.arange(0.0, t_b, T_s)
        held = u_b * (1 + np.cos(np.pi * t / t_b)) / 2
        pushed = found.a * T_s * np.sum(held * np.exp(found.c * (t + T_s / 2 - t_b)))
        # friction alone: f/c (1 - e^{-c t_b}), written for c of any size
        rubbed = found.f * t_b * _mean_decay(found.c * t_b)
        return float(v_0 * np.exp(-found.c * t_b) - pushed - rubbed)

    # with friction alone it stops before v_0/f
    return {"t_b": float(brentq(at_the_end, 0.0, v_0 / found.f, xtol=1e-7))}


def _mean_decay(product: float) -> float:
    """Return (1 - e^{-p})/p."""
    return float(-np.expm1(-product) / product) if abs(product) > 1e-9 else 1.0
