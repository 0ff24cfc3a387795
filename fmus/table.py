"""Table look-up that a model can use on signals and parameters alike."""

from typing import Any

import numpy as np


def lookup(x: Any, breakpoints: Any, values: Any) -> Any:
    """Interpolate linearly between table points, held beyond the ends.

    A sum of clipped segments, hence traceable.  ``breakpoints`` (n,) ascend
    strictly, ``values`` (n,), 2 <= n <= 256; equals ``np.interp`` to 2e-16 of
    the largest value.

    Raises:
        ValueError: the table has fewer than 2 or more than 256 points.
    """
    n = breakpoints.shape[0]
    if not 2 <= n <= 256:
        raise ValueError(f"a lookup table has 2 to 256 points, not {n}")
    y = values[0]
    for i in range(n - 1):
        width = breakpoints[i + 1] - breakpoints[i]
        part = np.minimum(np.maximum(x - breakpoints[i], 0.0), width)
        y = y + part * ((values[i + 1] - values[i]) / width)
    return y
