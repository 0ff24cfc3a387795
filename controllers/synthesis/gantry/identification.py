"""What recorded runs of the gantry tell about it: yaw, mass distribution, pre-filters.

Source: Gordon 2010, sec. 4.3.3, eq. 4.32.
"""

import numpy as np

from controllers.synthesis import frf_identification, prefilter
from fmus.model import FloatArray
from plants.gantry import frame as gantry


def yaw(
    T_s: float,
    u_1: FloatArray,
    u_2: FloatArray,
    y_1: FloatArray,
    y_2: FloatArray,
    m: float = gantry.Parameters().m,
    m_x: float = gantry.Parameters().m_x,
    L: float = gantry.Parameters().L,
    d: float = gantry.Parameters().d,
    alpha_1: float | None = None,
    t_1: float = 0.5,
    t_2: float = 2.0,
    period: float = 1.0,
    f_0_hz: float = 60.0,
    f_1_hz: float = 150.0,
) -> dict[str, float]:
    """Return J_0, c, k of the gantry from a run with a multisine on either motor.

    Args:
        T_s: sample time of the signals (s).
        u_1, u_2: control signals, shape (n,) (V).
        y_1, y_2: readings of the ends, shape (n,) (m).
        m, m_x, L, d: what is known (``plants.gantry.frame``), table at x = 0.
        alpha_1: share of the mass at the left end, by default from m_x and d.
        t_1, t_2: begin of the periods with the left and the right motor excited (s).
        period: their length (s).
        f_0_hz, f_1_hz: lowest and highest line; they stand every 1/period (Hz).

    Raises:
        ValueError: the signals are too short.
    """
    n = round(period / T_s)
    starts = [round(t / T_s) for t in (t_1, t_2)]
    if max(starts) + n > len(u_1):
        raise ValueError(f"the record ends before {t_2 + period:g} s")
    u, y = (
        np.stack([np.column_stack(pair)[k : k + n] for k in starts])
        for pair in ((u_1, u_2), (y_1, y_2))
    )
    f_hz = np.arange(round(f_0_hz * period), round(f_1_hz * period) + 1) / period
    G = frf_identification.responses(f_hz, T_s, u, y)
    if alpha_1 is None:
        known = gantry.Parameters(m=m, m_x=m_x, L=L, d=d)
        alpha_1 = float(gantry.geometry(0.0, known).a_2 / L)
    found = frf_identification.identify(f_hz, G, m, alpha_1, L)
    return {"J_0": found.J - m_x * d * d, "c": found.c, "k": found.k}


def mass_distribution(
    T_s: float, a_r: FloatArray, u_1: FloatArray, u_2: FloatArray
) -> dict[str, float]:
    """Return m (V s²/m), alpha_1, alpha_2 from a tracking run, u_i ≈ m_i a_r.

    Args:
        T_s: sample time of the signals (s).
        a_r: commanded acceleration, shape (n,) (m/s²).
        u_1, u_2: control signals, shape (n,) (V).

    Raises:
        ValueError: the command does not accelerate.
    """
    a_r = np.asarray(a_r, dtype=float)
    power = a_r @ a_r
    if power == 0:
        raise ValueError("the command does not accelerate: no mass to be seen")
    m_1, m_2 = float(a_r @ u_1 / power), float(a_r @ u_2 / power)
    m = m_1 + m_2
    return {"m": m, "alpha_1": m_1 / m, "alpha_2": m_2 / m}


def schedule(
    T_s: float,
    a_r: FloatArray,
    u_1: FloatArray,
    u_2: FloatArray,
    m_x: float = gantry.Parameters().m_x,
    L: float = gantry.Parameters().L,
    d: float = gantry.Parameters().d,
) -> dict[str, float]:
    """Return m and alpha_0 of a controller's schedule from a tracking run at x = 0.

    Arguments as of ``mass_distribution``; m_x, L, d are known.
    """
    found = mass_distribution(T_s, a_r, u_1, u_2)
    assumed = gantry.geometry(0.0, gantry.Parameters(m=found["m"], m_x=m_x, L=L, d=d))
    return {"m": found["m"], "alpha_0": found["alpha_2"] - float(assumed.a_1 / L)}


def x_prefilter(
    T_s: float, x_r: FloatArray, x_m: FloatArray, f_hz: float = 80.0
) -> dict[str, float]:
    """Return K_vel ... K_snap of the x axis from a run without them (eq. 4.20).

    Args:
        T_s: sample time of the signals (s).
        x_r, x_m: command and reading, shape (n,) (m), at rest in the first sample.
        f_hz: pole of the pre-filter's low-passes (Hz).
    """
    x_r, x_m = np.asarray(x_r, dtype=float), np.asarray(x_m, dtype=float)
    return prefilter.identify(x_r - x_r[0], x_m - x_r[0], T_s, f_hz)


def y_prefilters(
    T_s: float,
    y_r: FloatArray,
    y_1m: FloatArray,
    y_2m: FloatArray,
    f_hz: float = 80.0,
) -> dict[str, float]:
    """Return the gains of both ends, as the whole controllers call them (eq. 4.32).

    Args:
        T_s: sample time of the signals (s).
        y_r, y_1m, y_2m: command and readings, shape (n,) (m).
        f_hz: pole of the pre-filter's low-passes (Hz).
    """
    gains: dict[str, float] = {}
    for end, reading in ((1, y_1m), (2, y_2m)):
        found = x_prefilter(T_s, y_r, reading, f_hz)
        gains |= {f"prefilter.{name}_{end}": K for name, K in found.items()}
    return gains
