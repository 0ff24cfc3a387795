"""The conditional notch from the end of one open-loop pulse.

    x = x_f + A e^{-σt} cos(ωt + φ)    from the farthest position on

How far the table springs back, max x - x_f, is the range in which friction is a spring
and the notch acts; ω is where it stands.  ω and σ from the linear prediction of the
samples (a pole pair), by least squares of x_{k+1} + x_{k-1} over x_k and x_{k-1}.
Source: Maeda 2007, sec. 4.4, fig. 4-3 (290 nm and 215 Hz from 3 A for 0.15 s).
"""

from typing import NamedTuple

import numpy as np

from fmus.model import FloatArray

MM = 1e3  # per metre: the notch's range is stated in mm


class End(NamedTuple):
    """Spring-back (m), frequency (Hz) and damping ratio of the vibration at the end."""

    retraction: float
    f_hz: float
    zeta: float


def end(x: FloatArray, T_s: float, duration: float = 0.03) -> End:
    """Return how a run (n,) (m) that moves forward and comes to rest ends.

    Args:
        x: position (m), (n,), at rest at the end.
        T_s: sample time (s).
        duration: of the part behind the farthest position that counts (s).

    Raises:
        ValueError: the table does not spring back, or does not vibrate.
    """
    x = np.asarray(x, dtype=float)
    top = int(np.argmax(x))
    rest = float(x[-1])
    tail = x[top : top + round(duration / T_s)] - rest
    if len(tail) < 20 or tail[0] <= 0:
        raise ValueError("the run does not turn back before its end: nothing springs")
    columns = np.stack([tail[1:-1], tail[:-2], np.ones(len(tail) - 2)], axis=1)
    a, b, _ = np.linalg.lstsq(columns, tail[2:])[0]
    pole = np.roots([1.0, -a, -b])[0]
    s = np.log(complex(pole)) / T_s
    if abs(s.imag) < 1e-6 * abs(s):
        raise ValueError("the run comes to rest without vibrating")
    zeta = -s.real / abs(s)
    return End(float(tail[0]), float(abs(s.imag)) / (2 * np.pi), float(zeta))


def notch(x: FloatArray, T_s: float, duration: float = 0.03) -> dict[str, float]:
    """Return ``notch.omega_hz`` (Hz) and ``notch.e_n`` (mm): a design step.

    Args:
        x, T_s, duration: as for ``end``.
    """
    found = end(x, T_s, duration)
    return {"notch.omega_hz": found.f_hz, "notch.e_n": MM * found.retraction}
