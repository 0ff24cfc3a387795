"""P/PI gains of the XY table by margins of both loops and by disturbance response.

    speed      L_v = k_p (1 + ω_i/s) s G                           eq. 2
    position   L_p = k_v/s · L_v / (1 + L_v)                       eq. 3
    stiffness  y/d = G / (1 + L_v + k_v L_v / s)                   eq. 8

A corner ω_i = k_i/k_p fixes where L_v turns by half, its gain margin then k_p and its
phase margin ω_i; the margins of L_p fix k_v.  At low frequencies y/d = s/(k_v k_i), so
that a step of force leaves ∫y dt = d/(k_v k_i): of all gains that keep at least the
margins asked for, ``stiffest`` takes those with the largest k_v k_i.  Crossings are
interpolated on a grid of frequencies.
Source: Anang et al. 2018, sec. 3.1, 3.2, eq. 2, 3, 8 (4 to 10 dB, 30 to 70 degrees).
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from controllers.synthesis.frequency import ComplexArray
from controllers.synthesis.frf_estimate import identify
from fmus.model import FloatArray

OMEGA: FloatArray = np.geomspace(0.1, 6000.0, 6000)  # rad/s
CORNERS = (0.5, 400.0)  # of the integral, rad/s


class Gains(NamedTuple):
    """k_p (V s/mm), k_i (V/mm), k_v (1/s) of ``controllers.xy_table.p_pi``."""

    k_p: float
    k_i: float
    k_v: float


class Margins(NamedTuple):
    """Gain margin (a ratio) and phase margin (rad): the smallest of all crossings."""

    gain: float
    phase: float


def margins(L: ComplexArray) -> Margins:
    """Return the margins of an open loop L at OMEGA, (n,).

    Raises:
        ValueError: the loop does not cross |L| = 1, or not the negative real axis.
    """
    size, phase = _polar(L)
    at_half = _at(phase + np.pi, size)
    at_unity = _at(size, phase)
    if not len(at_half) or not len(at_unity):
        raise ValueError("the loop does not cross over on the grid of frequencies")
    return Margins(float(np.exp(-np.max(at_half))), float(np.pi + np.min(at_unity)))


def _polar(L: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return ln |L| and the phase (rad), which begins between 90 and -270 degrees."""
    phase = np.unwrap(np.angle(L))
    turns = np.round((phase[0] + np.pi / 2) / (2 * np.pi))
    return np.log(np.abs(L)), phase - 2 * np.pi * turns


def _at(crossing: FloatArray, value: FloatArray) -> FloatArray:
    """Return the value wherever the other curve falls through zero."""
    i = np.flatnonzero((crossing[:-1] > 0) & (crossing[1:] <= 0))
    share = crossing[i] / (crossing[i] - crossing[i + 1])
    return np.asarray(value[i] + share * (value[i + 1] - value[i]))


def axis(b: float, a_1: float, a_0: float, tau: float) -> ComplexArray:
    """Return G (mm/V) of eq. 1 at OMEGA, (n,): b e^{-τs} / (s² + a_1 s + a_0)."""
    s = 1j * OMEGA
    return np.asarray(b * np.exp(-tau * s) / (s * s + a_1 * s + a_0))


def speed_loop(G: ComplexArray, k_p: float, omega_i: float) -> ComplexArray:
    """Return L_v (n,) with the corner omega_i (rad/s)."""
    return np.asarray(k_p * (1j * OMEGA + omega_i) * G)


def position_loop(L_v: ComplexArray, k_v: float) -> ComplexArray:
    """Return L_p (n,)."""
    return np.asarray(k_v / (1j * OMEGA) * L_v / (1 + L_v))


def disturbance(G: ComplexArray, gains: Gains) -> ComplexArray:
    """Return y/d (mm/V), (n,), eq. 8 with D/K_f in volts."""
    L_v = speed_loop(G, gains.k_p, gains.k_i / gains.k_p)
    return np.asarray(G / (1 + L_v + gains.k_v / (1j * OMEGA) * L_v))


def by_margins(
    b: float,
    a_1: float,
    a_0: float,
    tau: float,
    speed_gain_db: float = 9.31,
    speed_phase_deg: float = 56.4,
    position_gain_db: float = 9.1,
    delay: float = 0.0,
) -> dict[str, float]:
    """Return k_p, k_i, k_v that have exactly these margins: a design step.

    Args:
        b, a_1, a_0, tau: axis, mm/(V s²), 1/s, 1/s², s.
        speed_gain_db, speed_phase_deg: margins of the speed loop.
        position_gain_db: gain margin of the position loop.
        delay: further dead time of both loops, such as half a sample of the hold (s).

    Raises:
        ValueError: no corner of the integral gives both margins of the speed loop.
    """
    G = axis(b, a_1, a_0, tau + delay)
    wanted = float(10 ** (speed_gain_db / 20))
    phase = float(np.deg2rad(speed_phase_deg))

    def gain(omega_i: float) -> float:
        return _gain_margin(speed_loop(G, 1.0, omega_i)) / wanted

    def excess(omega_i: float) -> float:
        return margins(speed_loop(G, gain(omega_i), omega_i)).phase - phase

    low, high = CORNERS
    if excess(low) < 0 or excess(high) > 0:
        ends = [np.rad2deg(excess(one) + phase) for one in CORNERS]
        raise ValueError(
            f"with a gain margin of {speed_gain_db:g} dB the speed loop has phase "
            f"margins from {ends[1]:.4g} to {ends[0]:.4g} degrees, not "
            f"{speed_phase_deg:g}"
        )
    omega_i = float(brentq(excess, low, high, xtol=1e-10))
    k_p = gain(omega_i)
    unit = position_loop(speed_loop(G, k_p, omega_i), 1.0)
    k_v = _gain_margin(unit) / 10 ** (position_gain_db / 20)
    return Gains(k_p, omega_i * k_p, k_v)._asdict()


def _gain_margin(L: ComplexArray) -> float:
    """Return that of a loop whose magnitude need not pass 1."""
    size, phase = _polar(L)
    at_half = _at(phase + np.pi, size)
    if not len(at_half):
        raise ValueError("the loop does not turn by half: no gain margin limits it")
    return float(np.exp(-np.max(at_half)))


def stiffest(
    b: float,
    a_1: float,
    a_0: float,
    tau: float,
    gain_db: float = 9.1,
    phase_deg: float = 56.4,
    delay: float = 0.0,
) -> dict[str, float]:
    """Return k_p, k_i, k_v with the least ∫y dt after a step of force, by margins.

    Args:
        b, a_1, a_0, tau, delay: as for ``by_margins``.
        gain_db, phase_deg: that either loop keeps at least.

    Raises:
        ValueError: no gains keep them.
    """
    G = axis(b, a_1, a_0, tau + delay)
    asked = Margins(10 ** (gain_db / 20), float(np.deg2rad(phase_deg)))

    def gains(omega_i: float) -> Gains:
        k_p = _largest(speed_loop(G, 1.0, omega_i), asked)
        k_v = _largest(position_loop(speed_loop(G, k_p, omega_i), 1.0), asked)
        return Gains(k_p, omega_i * k_p, k_v)

    def slope(log_corner: float) -> float:
        """Return the low-frequency y/(s d), in logarithm."""
        try:
            found = gains(float(np.exp(log_corner)))
        except ValueError:
            return np.inf
        return -float(np.log(found.k_v * found.k_i))

    tried = np.linspace(np.log(CORNERS[0]), np.log(CORNERS[1]), 25)
    values = [slope(float(one)) for one in tried]
    best = int(np.argmin(values))
    if not np.isfinite(values[best]):
        raise ValueError(
            f"no gains keep {gain_db:g} dB and {phase_deg:g} degrees in both loops"
        )
    near = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
    found = minimize_scalar(slope, bounds=near, method="bounded")
    return gains(float(np.exp(found.x)))._asdict()


def _largest(unit: ComplexArray, asked: Margins) -> float:
    """Return the largest gain at which a loop keeps the margins asked for."""
    highest = _gain_margin(unit) / asked.gain

    def kept(gain: float) -> float:
        return margins(np.asarray(gain * unit)).phase - asked.phase

    def enough(gain: float) -> bool:
        try:
            return kept(gain) >= 0
        except ValueError:  # so low that it does not cross over
            return False

    if enough(highest):
        return highest
    low = high = highest
    while low > highest / 1e3:
        low, high = low / 1.1, low
        if enough(low):
            return float(brentq(kept, low, high, xtol=1e-15))
    raise ValueError(
        f"no gain keeps a phase margin of {np.rad2deg(asked.phase):.4g} degrees"
    )


def from_run(
    u: FloatArray,
    y: FloatArray,
    T_s: float,
    speed_gain_db: float = 9.31,
    speed_phase_deg: float = 56.4,
    position_gain_db: float = 9.1,
    scale: float = 1e3,
) -> dict[str, float]:
    """Return the gains of ``by_margins`` for the drive behind a run: a design step.

    The run's frequency response and its fit are those of
    ``controllers.synthesis.frf_estimate``.

    Args:
        u, y, T_s: control signal (V), position, sample time (s) of the run.
        speed_gain_db, speed_phase_deg, position_gain_db: as for ``by_margins``.
        scale: from the unit of y to mm.
    """
    drive = identify(u, y, T_s, scale=scale)
    return by_margins(
        **drive,
        speed_gain_db=speed_gain_db,
        speed_phase_deg=speed_phase_deg,
        position_gain_db=position_gain_db,
    )
