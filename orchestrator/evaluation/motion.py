"""Figures of positioning: step responses, contours of two axes, stability limits.

What a run does not show (it never settles, nothing oscillates) is a figure
without a value that says why.
"""

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ScenarioError
from orchestrator.quantities.quantity import NoValue, Quantity

Array = NDArray[np.float64]


def step_response(
    time: Array, y: Array, height: float, band: float, unit: str
) -> dict[str, Quantity]:
    """Return rise time (10 to 90 %), time to 90 %, overshoot, positioning time
    and last error.

    ``y`` (n,) rises from 0 to ``height`` at time 0; crossings are interpolated,
    the positioning time is the first row after the last one with
    |height - y| > band, all in the unit of ``y``.  A level that is not reached, or
    an error that ends outside the band, leaves its times without a value.

    Raises:
        ScenarioError: the height is 0.
    """
    if height == 0:
        raise ScenarioError("height: a step of height 0 has no response")
    part = y / height
    t_10, t_90 = (_first_crossing(time, part, level) for level in (0.1, 0.9))
    e = height - y
    outside = np.flatnonzero(np.abs(e) > band)
    settled = int(outside[-1]) + 1 if len(outside) else 0
    rise = t_90 if isinstance(t_90, NoValue) else Quantity(t_90.value - t_10.value, "s")
    settling = Quantity(float(time[settled]), "s") if settled < len(y) else None
    return {
        "rise": rise,
        "reach": t_90,
        "overshoot": Quantity(100 * max(0.0, float(np.max(part)) - 1), "%"),
        "settling": settling
        or NoValue(
            "s",
            why=f"not settled: the error is {Quantity(float(e[-1]), unit)} at "
            f"{time[-1]:g} s, outside the band of {Quantity(band, unit)}",
        ),
        "error": Quantity(float(e[-1]), unit),
    }


def _first_crossing(time: Array, y: Array, level: float) -> Quantity:
    above = np.flatnonzero(y >= level)
    if len(above) == 0:
        nearest = f"{100 * np.max(y):.4g} % at most by {time[-1]:g} s"
        return NoValue("s", why=f"{100 * level:g} % of height not reached: {nearest}")
    k = int(above[0])
    if k == 0:
        return Quantity(float(time[0]), "s")
    fraction = (level - y[k - 1]) / (y[k] - y[k - 1])
    return Quantity(float(time[k - 1] + fraction * (time[k] - time[k - 1])), "s")


def contour_error(x: Array, y: Array, shape: str, size: float) -> Array:
    """Return how far each point lies outside a contour around the origin, (n,).

    ``circle``: √(x² + y²) - size, its radius; ``diamond``: |x| + |y| - size, half
    its diagonal; ``square``: distance from a square of side ``size`` on its corner;
    ``rose``: distance from four petals of length ``size``, r = size cos 2φ.
    """
    if shape == "circle":
        return np.asarray(np.hypot(x, y) - size)
    reach = np.abs(x) + np.abs(y)
    if shape == "diamond":
        return np.asarray(reach - size)
    foot_x, foot_y = nearest_on_contour(x, y, shape, size)
    distance = np.hypot(x - foot_x, y - foot_y)
    if shape == "rose":
        r = np.hypot(x, y)
        within = size * np.abs(np.cos(2 * np.arctan2(y, x)))
        return np.asarray(np.copysign(distance, r - within))
    return np.asarray(np.copysign(distance, reach - size * np.sqrt(0.5)))


def nearest_on_contour(
    x: Array, y: Array, shape: str, size: float
) -> tuple[Array, Array]:
    """Return the point of a contour that is nearest to each point, two of (n,)."""
    if shape == "circle":
        r = np.hypot(x, y)
        return size * x / r, size * y / r
    if shape == "rose":
        return _nearest_on_rose(x, y, size)
    corner = size if shape == "diamond" else size * np.sqrt(0.5)
    # in the first quadrant, along the side from the corner on the x axis
    along = np.clip((corner - np.abs(x) + np.abs(y)) / 2, 0.0, corner)
    return np.copysign(corner - along, x), np.copysign(along, y)


def _nearest_on_rose(x: Array, y: Array, size: float) -> tuple[Array, Array]:
    """Return the nearest points: of 4096 on the rose, then by Newton's rule."""
    from scipy.spatial import cKDTree

    def at(phi: Array) -> tuple[Array, Array]:
        r = size * np.cos(2 * phi)
        return r * np.cos(phi), r * np.sin(phi)

    coarse = 2 * np.pi * np.arange(4096) / 4096
    _, nearest = cKDTree(np.stack(at(coarse), axis=1)).query(np.stack([x, y], axis=1))
    phi = coarse[nearest]
    for _ in range(4):
        # slope and curvature of half the squared distance; (q, across) is the point
        # in the frame that is turned by φ
        c, s = np.cos(phi), np.sin(phi)
        q, across = x * c + y * s, y * c - x * s
        r, r_1, r_2 = (
            size * f
            for f in (np.cos(2 * phi), -2 * np.sin(2 * phi), -4 * np.cos(2 * phi))
        )
        slope = (r - q) * r_1 - across * r
        steep = r_1 * r_1 + (r - q) * r_2 - 2 * across * r_1 + q * r
        phi = phi - slope / np.where(steep > 0, steep, np.inf)
    return at(phi)


def sustained(
    time: Array, y: Array, level: Array, dwell: float, tail: float, span: float
) -> float | None:
    """Return the level on the first stair that ends in a sustained oscillation.

    ``level`` (n,) is held for ``dwell`` (s) on each stair, from time 0; ``y`` (n,)
    oscillates if it spans more than ``span`` in the last ``tail`` (s) of a stair;
    None if it does on no stair.
    """
    slack = 1e-9 * dwell
    for stair in range(int((time[-1] + slack) // dwell)):
        end = (stair + 1) * dwell
        rows = (time >= end - tail - slack) & (time < end - slack)
        if np.ptp(y[rows]) > span:
            return float(level[rows][0])
    return None


def onset(
    time: Array, y: Array, ramp: Array, piece: float, unit: str
) -> dict[str, Quantity]:
    """Return ramp and time where the oscillation of y stops to decay; all (n,).

    The logarithm of its size, piece by piece (s), is smallest there (parabola
    through the three lowest pieces).  Second differences leave slow motion out.
    An oscillation that only decays or only grows leaves both without a value.
    """
    rows = max(2, round(piece * (len(time) - 1) / (time[-1] - time[0])))
    count = len(y) // rows
    curvature = np.diff(y, 2, prepend=y[0], append=y[-1])
    size = np.std(curvature[: count * rows].reshape(count, rows), axis=1)
    lowest = int(np.argmin(size))
    if not 0 < lowest < count - 1:
        ends = f"{ramp[0]:g} and {Quantity(float(ramp[-1]), unit)}"
        why = (
            f"no onset between {ends}: the oscillation does not first decay and then "
            "grow"
        )
        return {"limit": NoValue(unit, why=why), "time": NoValue("s", why=why)}
    left, here, right = np.log(size[lowest - 1 : lowest + 2])
    middle = lowest + 0.5 * (left - right) / (left - 2 * here + right)
    at = float(np.interp((middle + 0.5) * rows - 0.5, np.arange(len(time)), time))
    limit = float(np.interp(at, time, ramp))
    return {"limit": Quantity(limit, unit), "time": Quantity(at, "s")}
