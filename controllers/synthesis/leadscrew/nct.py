"""Nominal characteristic trajectory and compensator gains from an open-loop run.

A current pulse drives the mechanism and it comes to rest, braked or not.  From the
switch-off to the first passage of the final position x_f

    e = x_f - x,   ė = v                               the trajectory
    v_NCT = α e near the origin                        instead of the spring region
    X/U = K α / (s (s + α)),  K = x_f / (u_r t_r)      the simplified object
    K_p = 2ζω_n / (α K),  K_i = ω_n² / (α K)

Source: Maeda 2007, sec. 3.1.1 to 3.1.3, eq. 3-3 to 3-11 (eq. 3-7 prints t_f for t_r).
"""

import numpy as np

from controllers.leadscrew.nominal_trajectory import POINTS
from fmus.model import FloatArray

MM = 1e3  # per metre: the law is stated in mm, s and A


def trajectory(
    x: FloatArray, v: FloatArray, T_s: float, t_off: float, alpha: float
) -> dict[str, FloatArray]:
    """Return the table of a trajectory that is a line of slope alpha at the origin.

    Args:
        x, v: position (m) and velocity (m/s) of the open-loop run, shape (n,), from
            t = 0 until rest.
        T_s: time between two of their values (s).
        t_off: when the current was switched off or to braking (s).
        alpha: inclination near the origin (1/s).

    Returns:
        e_nct (mm) and edot_nct (mm/s), shape (POINTS,), from the origin to the error
        at the switch-off; finer towards the origin.

    Raises:
        ValueError: the mechanism does not decelerate to rest, or the line does not
            meet the curve.
    """
    e, edot = deceleration(x, v, T_s, t_off)
    below = np.flatnonzero(edot < alpha * e)
    if len(below) == 0 or below[0] == 0:
        raise ValueError(f"a line of {alpha} 1/s does not meet the trajectory")
    # linear in between, where the curve comes under the line
    near = slice(below[0] - 1, below[0] + 1)
    e_m = float(np.interp(0.0, (alpha * e - edot)[near], e[near]))
    points = np.geomspace(e_m, e[-1], POINTS - 1)
    rates = np.interp(points, e, edot)
    return {"e_nct": np.append(0.0, points), "edot_nct": np.append(0.0, rates)}


def deceleration(
    x: FloatArray, v: FloatArray, T_s: float, t_off: float
) -> tuple[FloatArray, FloatArray]:
    """Return e (mm), ascending from the last sample before x_f, and ė (mm/s).

    Raises:
        ValueError: the mechanism does not run towards its rest after t_off.
    """
    off = round(t_off / T_s)
    e = MM * (x[-1] - np.asarray(x)[off:])
    rate = MM * np.asarray(v)[off:]
    passed = int(np.argmax(e <= 0))
    e, rate = e[:passed][::-1], rate[:passed][::-1]
    if len(e) < 3 or np.any(np.diff(e) <= 0):
        raise ValueError(
            f"the run does not decelerate from {t_off:g} s to rest in one direction"
        )
    return e, rate


def gains(
    x: FloatArray,
    T_s: float,
    u_r: float,
    t_r: float,
    alpha: float,
    zeta: float,
    omega_n_T: float,
) -> dict[str, float]:
    """Return the compensator's gains.

    Args:
        x: position (m) of the run with an unbraked pulse, shape (n,), recorded at
            the controller's sample time.
        T_s: that sample time (s).
        u_r, t_r: height (A) and duration (s) of the pulse.
        alpha: inclination of the trajectory near the origin (1/s).
        zeta, omega_n_T: design parameters ζ and ω_n T_s (rad).

    Returns:
        K_p (A s/mm), K_i (A/mm).
    """
    K = simplified_object(x, u_r, t_r)
    omega_n = omega_n_T / T_s
    return {
        "K_p": 2 * zeta * omega_n / (alpha * K),
        "K_i": omega_n**2 / (alpha * K),
    }


def simplified_object(x: FloatArray, u_r: float, t_r: float) -> float:
    """Return K (mm/(A s)) of a run with an unbraked pulse; x (m) ends at rest."""
    return float(MM * (x[-1] - x[0]) / (u_r * t_r))


def line(alpha: float, e_end: float) -> dict[str, FloatArray]:
    """Return the table of a trajectory that is a line of slope alpha (1/s).

    It is held constant beyond e_end (mm).  Source: Maeda 2007, fig. 7-1.
    """
    e = np.linspace(0.0, e_end, POINTS)
    return {"e_nct": e, "edot_nct": alpha * e}
