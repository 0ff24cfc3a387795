"""Gains of the gantry's controllers, from the plant's parameters and the published
specifications.

Filters are those of the run-time modules.  Designs are in the s-domain; the delay
of (1/2 + latency) samples counts with its phase.
Source: Gordon 2010, sec. 4.4.1, 4.4.2.
"""

import numpy as np

from controllers.gantry import filters as gantry_filters
from controllers.gantry import x_filters as gantry_x_filters
from controllers.synthesis.gantry.continuous import x_filters, y_filters
from controllers.synthesis.loop_shaping import shape
from plants.gantry import frame as gantry


def x_axis(
    m_x: float,
    omega_l_hz: float | None = None,
    f_c_hz: float = 130.0,
    pm_deg: float = 35.0,
    pi_deg: float = -10.0,
    leads: int = 2,
    lead_deg: float | None = None,
    latency: int = 1,
    T_s: float = 1 / 15_000,
) -> dict[str, float]:
    """Return K, T_i, T_d, a of the double lead with integrator (eq. 4.17, 4.18).

    Args:
        m_x: mass of the table (V s²/m).
        omega_l_hz: bandwidth of the drive's lag (Hz), None for none.
        f_c_hz, pm_deg, pi_deg: crossover (Hz), margin, phase of the integrator (deg).
        leads: number of leads.
        lead_deg: phase of all leads together instead of the one the margin asks for.
        latency, T_s: delay in whole samples, and the sample time (s).

    Raises:
        ValueError: the leads cannot give the phase.
    """
    omega_c = 2 * np.pi * f_c_hz
    filters = x_filters(gantry_x_filters.Parameters(), np.array([1j * omega_c]))[0]
    P = filters * mass_behind(omega_c, m_x, omega_l_hz, (0.5 + latency) * T_s)
    margin = np.deg2rad(pm_deg)
    if lead_deg is not None:
        phase = np.mod(np.angle(P), -2 * np.pi)
        margin = np.pi + phase + np.deg2rad(pi_deg + lead_deg)
    found = shape(P, omega_c, float(margin), float(np.deg2rad(pi_deg)), leads)
    return {"K": found.K, "T_i": found.T_i, "T_d": found.T_d, "a": found.a}


def x_calculator(**arguments: float) -> dict[str, float]:
    """Return what eq. 4.17 prints: ``phi_lead`` of all leads (deg) and ``gamma``.

    Arguments as of ``x_axis``.
    """
    gains = x_axis(**arguments)  # type: ignore[arg-type]
    gamma = float(np.sqrt(gains["T_d"] * gains["a"]))
    phi = 2 * np.arctan(gamma) - np.pi / 2
    leads = arguments.get("leads", 2)
    return {"gamma": gamma, "phi_lead": float(np.rad2deg(phi) * leads)} | gains


def drive_lag(
    angle_deg: float = -261.0,
    f_c_hz: float = 130.0,
    latency: int = 1,
    T_s: float = 1 / 15_000,
) -> dict[str, float]:
    """Return what eq. 4.17 says about the drive: the lag nobody else explains.

    Args:
        angle_deg: phase of plant, filters and delay at the crossover (deg).
        f_c_hz, latency, T_s: crossover (Hz), whole samples, sample time (s).

    Returns:
        ``residual`` (deg), and as one pole ``omega_l_hz`` (Hz) or as ``delay`` (s).
    """
    omega_c = 2 * np.pi * f_c_hz
    filters = x_filters(gantry_x_filters.Parameters(), np.array([1j * omega_c]))[0]
    known = -np.pi + np.angle(filters) - (0.5 + latency) * T_s * omega_c
    residual = known - np.deg2rad(angle_deg)
    return {
        "residual": float(np.rad2deg(residual)),
        "omega_l_hz": float(f_c_hz / np.tan(residual)),
        "delay": float(residual / omega_c),
    }


def averaging(
    m: float,
    m_x: float,
    L: float,
    J_0: float,
    d: float,
    c: float,
    k: float,
    f_c_hz: float = 60.0,
    pm_deg: float = 40.0,
    damping_increase: float = 5.9,
    effective: bool = True,
    omega_l_hz: float | None = None,
    latency: int = 1,
    T_s: float = 1 / 15_000,
) -> dict[str, float]:
    """Return K, T_d, a of D(s) and the active damping beta, for the table at x = 0.

    D is the lead that crosses the averaged loop h D/(m s²) at f_c_hz (eq. 4.24,
    4.26); beta multiplies the yaw damping by 1 + ``damping_increase`` (eq. 4.28).

    Args:
        m, m_x, L, J_0, d, c, k: the gantry (``plants.gantry.frame``).
        f_c_hz, pm_deg: crossover (Hz) and phase margin (deg).
        damping_increase: added over existing yaw damping.
        effective: the increase is meant with the filters' gain at the yaw mode.
        omega_l_hz: bandwidth of the drives' lag (Hz), None for none.
        latency, T_s: delay in whole samples, and the sample time (s).

    Raises:
        ValueError: one lead cannot give the phase.
    """
    filters = gantry_filters.Parameters()
    omega_c = 2 * np.pi * f_c_hz
    h = y_filters(filters, np.array([1j * omega_c]))[0]
    P = h * mass_behind(omega_c, m, omega_l_hz, (0.5 + latency) * T_s)
    found = shape(P, omega_c, float(np.deg2rad(pm_deg)))

    plant = gantry.Parameters(m=m, m_x=m_x, L=L, J_0=J_0, d=d, c=c, k=k)
    now = gantry.geometry(0.0, plant)
    beta = damping_increase * c / (2 * now.a_1 * now.a_2)
    if effective:
        beta = beta / gain_at_yaw(plant)
    return {"K": found.K, "T_d": found.T_d, "a": found.a, "beta": float(beta)}


def added_damping(beta: float, p: gantry.Parameters | None = None) -> float:
    """Return the yaw damping that beta adds, in % of what is there (eq. 4.28).

    Args:
        beta: active damping (V s/m), acting through the filters' gain at the mode.
        p: the gantry, table at x = 0.
    """
    p = gantry.Parameters() if p is None else p
    now = gantry.geometry(0.0, p)
    return float(100 * 2 * beta * gain_at_yaw(p) * now.a_1 * now.a_2 / p.c)


def gain_at_yaw(p: gantry.Parameters) -> float:
    """Return |h| of the filter pack at the yaw mode, table at x = 0."""
    yaw = np.array([1j * np.sqrt(p.k / gantry.geometry(0.0, p).J)])
    return float(np.abs(y_filters(gantry_filters.Parameters(), yaw)[0]))


def mass_behind(
    omega: float, m: float, omega_l_hz: float | None, delay: float
) -> complex:
    """Return the response at omega (rad/s) of a mass m behind lag and delay (s)."""
    s = 1j * omega
    P = np.exp(-s * delay) / (m * s**2)
    if omega_l_hz is not None:
        P = P / (1 + s / (2 * np.pi * omega_l_hz))
    return complex(P)


def pid(
    m: float, f_c_hz: float = 16.0, T_d: float = 0.016, ratio: float = 4.0
) -> dict[str, float]:
    """Return K_p, K_i, K_d of the baseline: averaged loop crosses at f_c_hz.

    Args:
        m: mass of gantry and table (V s²/m).
        f_c_hz: crossover (Hz), s-domain.
        T_d: derivative time K_d/K_p (s).
        ratio: reset time over derivative time.
    """
    s = np.array([2j * np.pi * f_c_hz])
    h = y_filters(gantry_filters.Parameters(lead_on=False), s)
    T_i = ratio * T_d
    form = 1 + 1 / (T_i * s) + T_d * s
    K_p = float(1 / np.abs(h * form / (m * s * s))[0])
    return {"K_p": K_p, "K_i": K_p / T_i, "K_d": K_p * T_d}
