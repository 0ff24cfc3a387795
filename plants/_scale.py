"""What a scale of sine periods adds to a position: interpolation error and noise.

y = x + A sin(2πx/λ) + σ n

The sine is the first harmonic of the error within a signal period λ; n is a standard
normal number (``plants._noise``).  All are in the unit of x.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Var
from plants._noise import P


class Scale(NamedTuple):
    """One scale; lengths are those of the motion it measures."""

    A: Annotated[float, Var("m", "amplitude of the interpolation error", min=0)] = 0.0
    period: Annotated[float, Var("m", "signal period", min=1e-12)] = 4e-6
    sigma: Annotated[float, Var("m", "standard deviation of noise", min=0)] = 0.0


class Sequence(NamedTuple):
    seed: Annotated[
        float, Var("1", "number of the noise's sequence, whole", min=0, max=P - 1)
    ] = 1.0


def seen(x: Any, n: Any, scale: Scale, per: Any = 1.0) -> Any:
    """Return what the scale makes of x; ``per`` is metres per unit of x."""
    turn = 2 * np.pi * (x * per / scale.period)
    return x + (scale.A * np.sin(turn) + scale.sigma * n) / per
