"""Stribeck friction of the screw from a run, through a Kalman disturbance observer.

    m v̇ = u - b v - d,    ẋ = v,    ḋ = w,    y = x + n

w and n white; filtered forward and smoothed backward (Rauch, Tung and Striebel), so
that d and v are not late.  Where the screw moves,

    d(v) = ± (d_c + (d_s - d_c) exp(-|v|/Ω))

is fitted with own levels for either direction.  The mass is that of both parts of the
drive together: what lies below its mode.
Source: Gordon 2010, sec. 2.1.3, eq. 2.1; Kalman 1960.
"""

from typing import NamedTuple

import numpy as np
from scipy import linalg, optimize, signal

from fmus.model import FloatArray

PREFIX = "friction."


class Observed(NamedTuple):
    """Smoothed speed v (rad/s) and disturbance d (V), (n,)."""

    v: FloatArray
    d: FloatArray


def observe(
    u: FloatArray,
    y: FloatArray,
    T_s: float,
    m: float,
    b: float,
    noise: float,
    wander: float,
) -> Observed:
    """Return speed and disturbance behind a run.

    Args:
        u, y: control signal (V), held from sample to sample, and reading (rad), (n,).
        T_s: sample time (s).
        m, b: inertia (V s²/rad) and viscous friction (V s/rad) of the whole drive.
        noise: standard deviation of the reading (rad).
        wander: how fast the disturbance may change, V per root of a second.
    """
    A = np.array([[0.0, 1.0, 0.0], [0.0, -b / m, -1 / m], [0.0, 0.0, 0.0]])
    B = np.array([[0.0], [1 / m], [0.0]])
    C = np.array([[1.0, 0.0, 0.0]])
    F, G, *_ = signal.cont2discrete((A, B, C, np.zeros((1, 1))), T_s, "zoh")
    Q = np.diag([0.0, 0.0, wander**2 * T_s])
    P = linalg.solve_discrete_are(F.T, C.T, Q, np.array([[noise**2]]))
    K = P @ C.T / (C @ P @ C.T + noise**2)
    behind = P - K @ C @ P
    back = behind @ F.T @ linalg.inv(P)
    steps = np.asarray(u)[:, None] * G[:, 0]
    states = np.zeros((len(y), 3))
    x = np.array([y[0], 0.0, 0.0])
    for k, reading in enumerate(y):
        x = x + K[:, 0] * (reading - x[0])
        states[k] = x
        x = F @ x + steps[k]
    for k in range(len(y) - 2, -1, -1):
        ahead = F @ states[k] + steps[k]
        states[k] += back @ (states[k + 1] - ahead)
    return Observed(states[:, 1], states[:, 2])


def levels(found: Observed, slowest: float = 0.3) -> dict[str, float]:
    """Return d_c_plus, d_c_minus, d_s_plus, d_s_minus (V) and Omega (rad/s).

    Args:
        found: speed and disturbance; both directions must be there.
        slowest: samples below this speed (rad/s) do not count.

    Raises:
        ValueError: the run does not move in both directions.
    """
    v, d = found
    forward, backward = v > slowest, v < -slowest
    if min(np.count_nonzero(forward), np.count_nonzero(backward)) < 100:
        raise ValueError(f"the run is not faster than {slowest:g} rad/s both ways")

    def apart(x: FloatArray) -> FloatArray:
        sides = []
        for side, sign, c, s in ((forward, 1, 0, 2), (backward, -1, 1, 3)):
            fades = np.exp(-np.abs(v[side]) / x[4])
            sides.append(sign * d[side] - x[c] - (x[s] - x[c]) * fades)
        return np.concatenate(sides)

    mean = float(np.mean(np.abs(d[forward | backward])))
    start = [mean, mean, 1.5 * mean, 1.5 * mean, 10 * slowest]
    x = optimize.least_squares(apart, start, bounds=(1e-9, np.inf), x_scale="jac").x
    names = ("d_c_plus", "d_c_minus", "d_s_plus", "d_s_minus", "Omega")
    return dict(zip(names, map(float, x), strict=True))


def identify(
    u: FloatArray,
    y: FloatArray,
    T_s: float,
    m_1: float,
    m_2: float,
    b_1: float,
    b_2: float,
    begin: float = 0.5,
    noise: float = 1e-6,
    wander: float = 2.0,
    slowest: float = 0.3,
) -> dict[str, float]:
    """Return the friction of a controller's feed-forward, ``friction.d_c_plus`` ...

    Args:
        u, y, T_s: a run's control signal (V), reading (rad), sample time (s).
        m_1, m_2, b_1, b_2: of the drive (V s²/rad, V s/rad).
        begin: what is earlier (s) does not count.
        noise, wander, slowest: as for ``observe`` and ``levels``.
    """
    found = observe(u, y, T_s, m_1 + m_2, b_1 + b_2, noise, wander)
    first = round(begin / T_s)
    kept = Observed(found.v[first:-first], found.d[first:-first])
    return {PREFIX + name: value for name, value in levels(kept, slowest).items()}
