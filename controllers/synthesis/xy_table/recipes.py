"""Where to start tuning the XY table's P/PI cascade, from its axis alone.

    T_σ = τ + (n + 3/2) T_s,   m = 1/b

Dead time, n samples of latency, the hold and half a sample of differentiation make
the small time constant of the recipes in ``controllers.synthesis.recipes``; b is the
acceleration by one volt.
"""

import numpy as np

from controllers.synthesis import recipes


def p_pi(
    b: float,
    tau: float,
    T_s: float = 5e-4,
    latency: float = 0.0,
    phase_margin_deg: float = 45.0,
    damping: float = 1.0,
) -> dict[str, float]:
    """Return k_v (1/s), k_p (V s/mm) and k_i (V/mm) to start from.

    Args:
        b: numerator of the axis (mm/(V s²)).
        tau: its dead time (s).
        T_s, latency: sample time (s), and samples the control signal is late.
        phase_margin_deg: of the velocity loop (degrees).
        damping: of the position loop.

    Raises:
        ValueError: b is not positive, or the margin not between 0 and 90 degrees.
    """
    if not b > 0:
        raise ValueError(f"b = {b:g} is not greater than 0")
    T_sigma = tau + (latency + 1.5) * T_s
    found = recipes.cascade(1 / b, T_sigma, np.deg2rad(phase_margin_deg), damping)
    return {"k_v": found.K_v, "k_p": found.velocity.K_p, "k_i": found.velocity.K_i}


def speed_pi(
    b: float,
    tau: float,
    T_s: float = 5e-4,
    latency: float = 0.0,
    phase_margin_deg: float = 45.0,
) -> dict[str, float]:
    """Return k_p (V s/mm) and k_i (V/mm) alone, arguments as of ``p_pi``."""
    found = p_pi(b, tau, T_s, latency, phase_margin_deg)
    return {name: found[name] for name in ("k_p", "k_i")}
