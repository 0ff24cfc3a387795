"""P-PI gains by margins, of the drive with its current loop.

    |S|_max = s_max in z,  phase margin at the first crossover in s,  K_iv/K_pv given

The source tuned both of its controllers to like margins and prints no P-PI gain; the
two margins leave the corner of the integral open.
Source: Gordon 2010, sec. 3.3 (30 degrees, 3.25).
"""

import numpy as np
from scipy import optimize

from controllers.synthesis.ball_screw.loops import continuous_loop, sampled_loop
from controllers.synthesis.frequency import battery, respond
from fmus.model import FloatArray

GAINS = ("K_px", "K_pv", "K_iv")
START = (250.0, 0.8)  # K_px (1/s), K_pv (V s/rad)
F_HZ: FloatArray = np.linspace(20.0, 400.0, 1901)


def margins(
    controller: str, latency: int = 1, T_s: float = 5e-5, **parameters: float
) -> dict[str, float]:
    """Return ``phase_margin_deg`` (first crossover in s) and ``s_max`` (in z).

    Args:
        controller: ``mc_ppc`` or ``p_pi``.
        latency, T_s: delay in whole samples, sample time (s).
        parameters: by name, see ``controllers.synthesis.ball_screw.loops``.
    """
    continuous = respond(continuous_loop(controller, True, parameters), F_HZ)
    sampled = respond(sampled_loop(controller, True, parameters, latency, T_s), F_HZ)
    found = battery(continuous)
    first = int(np.argmax(found.falling))
    return {
        "phase_margin_deg": float(np.rad2deg(found.phase_margins[first])),
        "s_max": battery(sampled).s_max,
    }


def tune(
    phase_margin_deg: float = 30.0,
    s_max: float = 3.25,
    corner: float = 3.556,
    latency: int = 1,
    T_s: float = 5e-5,
    **parameters: float,
) -> dict[str, float]:
    """Return K_px (1/s), K_pv (V s/rad) and K_iv (V/rad) that land on both margins.

    Args:
        phase_margin_deg: at the first crossover, continuous (deg).
        s_max: largest |S|, sampled.
        corner: K_iv / K_pv (1/s).
        latency, T_s: delay in whole samples, sample time (s).
        parameters: of drive and controller by name.

    Raises:
        ValueError: no gains near the start have these margins together.
    """

    def gains(x: FloatArray) -> dict[str, float]:
        K_px, K_pv = np.exp(x)
        return dict(zip(GAINS, map(float, (K_px, K_pv, corner * K_pv)), strict=True))

    def apart(x: FloatArray) -> list[float]:
        found = margins("p_pi", latency, T_s, **(parameters | gains(x)))
        wanted = phase_margin_deg, s_max
        of = found["phase_margin_deg"], found["s_max"]
        return [a / b - 1 for a, b in zip(of, wanted, strict=True)]

    start = np.log(START)
    bounds = (start - 1.0, start + 1.0)
    best = optimize.least_squares(apart, start, bounds=bounds, diff_step=1e-4)
    if np.max(np.abs(best.fun)) > 1e-3:
        named = ", ".join(f"{k} {v:.4g}" for k, v in gains(best.x).items())
        raise ValueError(
            f"no P-PI gains with a phase margin of {phase_margin_deg:g} deg and "
            f"|S| up to {s_max:g}; nearest {named}, apart by {best.fun.tolist()}"
        )
    return gains(best.x)
