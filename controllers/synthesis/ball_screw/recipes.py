"""Where to start tuning the ball screw's P-PI cascade, from its drive alone.

    T_σ = (n + 3/2) T_s + 1/ω_lpf + Σ 2 (ζ_p - ζ_z)/ω_n

n samples of latency, the hold and half a sample of differentiation, and what the
filter pack lags by at low frequency, make the small time constant of the recipes in
``controllers.synthesis.recipes``; the drive counts as one mass.
"""

import numpy as np

from controllers.ball_screw import filter_pack
from controllers.synthesis import recipes


def p_pi(
    m_1: float,
    m_2: float,
    T_s: float = 5e-5,
    latency: float = 1.0,
    phase_margin_deg: float = 45.0,
    damping: float = 1.0,
    filters: filter_pack.Parameters | None = None,
) -> dict[str, float]:
    """Return K_px (1/s), K_pv (V s/rad) and K_iv (V/rad) to start from.

    Args:
        m_1, m_2: screw and table inertia (V s²/rad).
        T_s, latency: sample time (s), and samples the control signal is late.
        phase_margin_deg: of the velocity loop (degrees).
        damping: of the position loop.
        filters: the filter pack behind the cascade, as published if None.

    Raises:
        ValueError: the margin is not between 0 and 90 degrees.
    """
    T_sigma = (latency + 1.5) * T_s + lag(filters or filter_pack.Parameters())
    margin = np.deg2rad(phase_margin_deg)
    return _named(recipes.cascade(m_1 + m_2, T_sigma, margin, damping))


def p_pi_of_bandwidths(
    m_1: float, m_2: float, velocity_hz: float, integral_hz: float, position_hz: float
) -> dict[str, float]:
    """Return the same gains of bandwidths (Hz), ``recipes.of_bandwidths``."""
    return _named(
        recipes.of_bandwidths(m_1 + m_2, velocity_hz, integral_hz, position_hz)
    )


def lag(p: filter_pack.Parameters) -> float:
    """Return by how much (s) a filter pack lags at low frequency."""
    notches = (
        (p.omega_n1_hz, p.zeta_z1, p.zeta_p1),
        (p.omega_n2_hz, p.zeta_z2, p.zeta_p2),
    )
    own = sum(2 * (zeta_p - zeta_z) / f for f, zeta_z, zeta_p in notches)
    return float((own + 1 / p.omega_lpf_hz) / (2 * np.pi))


def _named(found: recipes.Cascade) -> dict[str, float]:
    K_p, K_i = found.velocity
    return {"K_px": found.K_v, "K_pv": K_p, "K_iv": K_i}
