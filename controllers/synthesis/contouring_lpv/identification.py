"""The axes' flexible factors from their measured responses, stable by constraint.

A multisine moves all three axes, which are not coupled; the last period is taken.
The rigid body is known from before (Table 8.1), so that G_flex = G/G_rigid; what is
left of its slow transient shows as the difference of the last two periods.

Source: Hanifzadegan 2014, sec. 8.3, fig. 8.6, Table 8.2.
"""

import numpy as np

from controllers.synthesis.ball_screw_lpv.mode_identification import responses
from controllers.synthesis.rational_fit import stable_fit
from fmus.model import FloatArray
from plants.three_axis import _axes

AXES = {"x": _axes.X, "y": _axes.Y, "z": _axes.Z}


def flexible(
    T_s: float,
    v_m: FloatArray,
    u_cx: FloatArray,
    u_cy: FloatArray,
    u_cz: FloatArray,
    f_0_hz: float = 5.0,
    spacing_hz: float = 5.0,
    lines: int = 91,
) -> dict[str, FloatArray]:
    """Return the modes of all axes from one run, as ``plants.three_axis`` takes them.

    Args:
        T_s: sample time of the signals (s).
        v_m: command to all axes (V), shape (n,).
        u_cx, u_cy, u_cz: positions (m), shape (n,).
        f_0_hz, spacing_hz, lines: of the multisine (``plants.disturbances``).

    Raises:
        ValueError: the record does not hold two periods.
    """
    n = round(1 / (spacing_hz * T_s))
    if len(v_m) < 2 * n + 1:
        raise ValueError(f"{len(v_m)} samples do not hold two periods of {n}")
    f_hz = f_0_hz + spacing_hz * np.arange(lines)
    omega = np.asarray(2 * np.pi * f_hz, dtype=np.float64)
    s = 1j * omega
    found: dict[str, FloatArray] = {}
    for (name, axis), u_c in zip(AXES.items(), (u_cx, u_cy, u_cz), strict=True):
        before, last = np.asarray(u_c[-2 * n - 1 : -1]).reshape(2, n)
        fading = np.exp(axis.pole * T_s * np.arange(2 * n)).reshape(2, n)
        change = fading[1] - fading[0]
        left = change @ (last - before) / (change @ change)
        y = (last - left * fading[1])[:, None]
        G = responses(f_hz, T_s, np.asarray(v_m[-n - 1 : -1]), y)[:, 0]
        flex = G * s * (s - axis.pole) / axis.gain
        modes = stable_fit(omega, flex, len(axis.denominator) - 1)
        found |= {f"{name}.{key}": value for key, value in modes._asdict().items()}
    return found
