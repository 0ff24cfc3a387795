"""Loops of the XY table under the cascades P/PI and NP/PI, with the exact dead time.

    speed      PI G V_est                              eq. 2
    position   k_v PI G / (1 + PI G V_est)             eq. 3
    error      E/Z_ref = 1 / (1 + N · position)        eq. 8, 9

with PI = k_p + k_i/s, G the traced plant behind e^{-τs}, and V_est = s, or
s/(1 + s/ω_c) where the controller's estimator filters.

Parameters are given by name as in ``ball_screw_loops``: ``tau``, ``k_v``,
``estimator.filtered``.  Figures bear the names of the study's figures: margins in
dB and degrees as published, frequencies in rad/s.
Source: Anang et al. 2018, sec. 3 and 4.
"""

from typing import Any, NamedTuple

import control as ct
import numpy as np
from scipy.optimize import brentq

from controllers.synthesis.frequency import (
    GRID_HZ,
    Battery,
    ComplexArray,
    Response,
    battery,
)
from controllers.synthesis.linearise import linearise
from controllers.synthesis.parameters import share
from controllers.synthesis.popov import crossing, popov
from controllers.xy_table import p_pi as p_pi_cascade
from controllers.xy_table.position_np import nonlinear_gain
from fmus.model import FloatArray
from plants.xy_table import axis as xy_table


class Loops(NamedTuple):
    """Complex responses of shape (n,): G (mm/V), speed and position loop."""

    G: ComplexArray
    speed: ComplexArray
    position: ComplexArray


class Cascade:
    """The table under the cascade P/PI with parameters by name, see the module.

    Raises:
        LookupError: no parameter of plant or controller of that name.
    """

    def __init__(self, **parameters: Any) -> None:
        records = {
            "plant": xy_table.model.parameters,
            "controller": p_pi_cascade.model.parameters,
        }
        drive, self.p = share(parameters, records)
        self.tau = drive.tau
        self.plant: ct.StateSpace = linearise(
            xy_table.model, parameters=drive, inputs=["u"], outputs=["y"]
        )

    def loops(self, omega: FloatArray) -> Loops:
        """Evaluate the loops at the frequencies of shape (n,) (rad/s)."""
        p, s = self.p, 1j * np.asarray(omega, dtype=float)
        G = self.plant.horner(s, warn_infinite=False)[0, 0] * np.exp(-self.tau * s)
        PI = p.k_p + p.k_i / s
        V_est = s
        if p.estimator.filtered:
            V_est = s / (1 + s / (2 * np.pi * p.estimator.omega_c_hz))
        speed = PI * G * V_est
        return Loops(G, speed, p.k_v * PI * G / (1 + speed))

    def position(self, omega: FloatArray) -> ComplexArray:
        """Return the position loop alone, shape (n,)."""
        return self.loops(omega).position

    def speed_battery(self, f_hz: FloatArray = GRID_HZ) -> Battery:
        """Return the figures of the speed loop; its disturbance is d -> v (mm/s/V)."""
        G, L, _ = self.loops(2 * np.pi * f_hz)
        s = 2j * np.pi * f_hz
        return battery(Response(f_hz, L, s * G / (1 + L), L / (1 + L)))

    def position_battery(self, f_hz: FloatArray = GRID_HZ) -> Battery:
        """Return the figures of the position loop; its disturbance is d -> y (mm/V)."""
        G, speed, L = self.loops(2 * np.pi * f_hz)
        return battery(Response(f_hz, L, G / (1 + speed) / (1 + L), L / (1 + L)))

    def tracking_error(self, f_hz: float, amplitude: float, N: float) -> float:
        """Return the amplitude of the steady error with N held (eq. 8, 9)."""
        L = self.position(np.array([2 * np.pi * f_hz]))[0]
        return float(amplitude / np.abs(1 + N * L))


def figures(**parameters: Any) -> dict[str, float]:
    """Return margins of both loops and what Popov's criterion says of the gain N.

        speed_gain_margin, position_gain_margin        dB
        speed_phase_margin, position_phase_margin      degrees
        ..._gain_crossover, ..._phase_crossover        rad/s
        popov_crossing, popov_omega       leftmost crossing of the real axis; rad/s
        K_max                             -1/crossing (eq. 7)
        popov_K, popov_q                  sector [0, K] by Popov; s
        popov_shifted_K, popov_shifted_q  sector [1, K], since N >= 1; s
        circle_shifted_K                  the same by the circle criterion

    Raises:
        LookupError: no parameter of plant or controller of that name.
    """
    cascade = Cascade(**parameters)
    locus = cascade.position
    at = crossing(locus)
    plain, tight, circle = popov(locus), popov(locus, 1.0), popov(locus, 1.0, q=0.0)
    return {
        **_margins("speed", cascade.speed_battery()),
        **_margins("position", cascade.position_battery()),
        "popov_crossing": at.re,
        "popov_omega": at.omega,
        "K_max": -1 / at.re,
        "popov_K": plain.K,
        "popov_q": plain.q,
        "popov_shifted_K": tight.K,
        "popov_shifted_q": tight.q,
        "circle_shifted_K": circle.K,
    }


def tracking_error(
    f_hz: float, amplitude: float = 10.0, N: float = 1.0, **parameters: Any
) -> float:
    """Return the amplitude of the steady error under a sine with N held (eq. 8, 9).

    Args:
        f_hz: frequency of the reference (Hz).
        amplitude: of the reference, in the unit of the result.
        N: nonlinear gain, a number.
        parameters: by name, see the module.
    """
    return Cascade(**parameters).tracking_error(f_hz, amplitude, N)


def quasi_static_error(
    f_hz: float,
    amplitude: float = 10.0,
    KO: float = 3.5,
    e_max: float = 0.5,
    **parameters: Any,
) -> float:
    """Return the largest steady error of NP/PI as if N were held at its own value.

    The e that solves e = |E(jω; N(e))|; amplitude, e and e_max in mm, KO in 1/mm.
    """
    cascade = Cascade(**parameters)

    def excess(e: float) -> float:
        N = float(nonlinear_gain(e, KO, e_max))
        return cascade.tracking_error(f_hz, amplitude, N) - e

    return float(brentq(excess, 0.0, amplitude, xtol=1e-14))


def gain_for_error(
    f_hz: float, error: float, amplitude: float = 10.0, **parameters: Any
) -> float:
    """Return the constant N whose steady error is ``error``, of amplitude's unit."""
    cascade = Cascade(**parameters)

    def excess(N: float) -> float:
        return cascade.tracking_error(f_hz, amplitude, N) - error

    return float(brentq(excess, 1e-3, 1e3, xtol=1e-14))


def largest_gain(KO: float = 3.5, e_max: float = 0.5) -> float:
    """Return K_e, the nonlinear gain at e_max (table 1); KO in 1/mm, e_max in mm."""
    return float(nonlinear_gain(e_max, KO, e_max))


def _margins(loop: str, found: Battery) -> dict[str, float]:
    gain, phase = np.argmin(found.gain_margins), np.argmin(found.phase_margins)
    return {
        f"{loop}_gain_margin": float(20 * np.log10(found.gain_margins[gain])),
        f"{loop}_phase_crossover": float(2 * np.pi * found.phase_crossovers_hz[gain]),
        f"{loop}_phase_margin": float(np.rad2deg(found.phase_margins[phase])),
        f"{loop}_gain_crossover": float(2 * np.pi * found.crossovers_hz[phase]),
    }
