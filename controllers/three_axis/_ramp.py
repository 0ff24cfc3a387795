"""A parameter that runs from 0 to 1 with half a cosine of speed at either end.

    q̇ = w/2 (1 - cos πt/t_r) in the first t_r, w, and back;   w = 1/(T - t_r)

Speed, acceleration and jerk are bounded: t_r sets the jerk.
"""

from typing import Any, NamedTuple

import numpy as np


class Progress(NamedTuple):
    """The parameter and its rate (1/s)."""

    q: Any
    rate: Any


def progress(t: Any, T: Any, t_r: Any) -> Progress:
    """Return the parameter t seconds after its start; T is the whole time.

    Before it is 0, after it 1; with t_r = 0 it moves at once.
    """
    ramp = np.maximum(t_r, 1e-9 * T)
    w = 1 / (T - ramp)
    begun = np.minimum(np.maximum(t, 0.0), ramp)
    even = np.minimum(np.maximum(t - ramp, 0.0), T - 2 * ramp)
    left = np.minimum(np.maximum(T - t, 0.0), ramp)
    q = w * (_risen(begun, ramp) + even + ramp / 2 - _risen(left, ramp))
    shortest = np.minimum(begun, left)
    return Progress(q, w / 2 * (1 - np.cos(np.pi * shortest / ramp)))


def _risen(s: Any, ramp: Any) -> Any:
    """Return the integral of the ramp's speed, of w, to s seconds."""
    return s / 2 - ramp / (2 * np.pi) * np.sin(np.pi * s / ramp)
