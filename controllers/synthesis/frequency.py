"""Margins, sensitivity and disturbance response of a loop, s- or z-domain.

A loop is a plant (u, d) → (y_1, ..., y_m) and a controller
(y_1, ..., y_m, x_r, ẋ_r, ẍ_r, ...) → u, both continuous or both sampled with one
T_s; feedback signs are the controller's own.  It is broken at u:

    L = -C_y P_u,   S = 1/(1 + L),   y = P_d d + P_u S C_y P_d d + P_u S C_r x_r

``latency`` delays u by whole samples.  The controlled output is the plant's last.
Margins come from python-control on a dense grid with interpolated crossings, all
of them: a drive with an antiresonance crosses |L| = 1 more than once.
"""

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import control as ct
import numpy as np
from numpy.typing import NDArray

from controllers.synthesis.linearise import without_bystanders
from fmus.model import FloatArray

ComplexArray: TypeAlias = NDArray[np.complex128]

GRID_HZ: FloatArray = np.linspace(1.0, 400.0, 7981)  # every 0.05 Hz


@dataclass(frozen=True)
class Loop:
    """Plant, controller and the whole samples u is late.

    The feedback's sign is the controller's own.

    Raises:
        ValueError: the sample times differ, or a continuous loop is to be late.
    """

    plant: ct.StateSpace
    controller: ct.StateSpace
    latency: int = 0

    def __post_init__(self) -> None:
        if self.plant.dt != self.controller.dt:
            raise ValueError(
                f"plant has sample time {self.plant.dt}, controller "
                f"{self.controller.dt}: sample the plant first"
            )
        if self.latency and not self.plant.isdtime(strict=True):
            raise ValueError("latency counts samples: a continuous loop has none")


class Response(NamedTuple):
    """Frequency response of a loop, complex arrays of shape (n,).

    ``tracking`` is x_r → controlled output, zero where the controller takes no
    command.
    """

    f_hz: FloatArray
    L: ComplexArray
    disturbance: ComplexArray
    tracking: ComplexArray


class Battery(NamedTuple):
    """What is read off a loop between the ends of the grid.

    Arrays are ordered by frequency.  ``crossovers_hz`` holds every |L| = 1 with
    its ``phase_margins`` (rad); ``falling`` tells those at which |L| falls.
    ``gain_margins`` (ratios) belong to ``phase_crossovers_hz``.  Rows of
    ``bands_hz``, shape (n, 2), are where |S| < 1; a band that reaches the low
    end of the grid counts from 0.  The disturbance response has the unit of
    y/d: its most negative real part and its largest magnitude.
    """

    crossovers_hz: FloatArray
    falling: NDArray[np.bool_]
    phase_margins: FloatArray
    phase_crossovers_hz: FloatArray
    gain_margins: FloatArray
    s_max: float
    s_max_hz: float
    bands_hz: FloatArray
    real_min: float
    real_min_hz: float
    magnitude_max: float
    magnitude_max_hz: float


def respond(loop: Loop, f_hz: FloatArray = GRID_HZ) -> Response:
    """Evaluate a loop at the frequencies of shape (n,).

    Commands of a sampled controller are samples of the exact derivatives.
    """
    omega = 2 * np.pi * np.asarray(f_hz, dtype=float)
    point: ComplexArray = np.asarray(1j * omega, dtype=np.complex128)
    if loop.plant.isdtime(strict=True):
        point = np.exp(loop.plant.dt * point)
    P, C = evaluate(loop.plant, point), evaluate(loop.controller, point)
    if loop.latency:
        C = C * (point**-loop.latency)[:, None, None]
    measured = loop.plant.noutputs
    orders = np.arange(loop.controller.ninputs - measured)
    command = (1j * omega[:, None]) ** orders

    P_u, P_d = P[:, :, 0], P[:, :, -1]
    C_y, C_r = C[:, 0, :measured], C[:, 0, measured:]
    L = -np.sum(C_y * P_u, axis=1)
    u_d = np.sum(C_y * P_d, axis=1) / (1 + L)
    u_r = np.sum(C_r * command, axis=1) / (1 + L)
    return Response(
        np.asarray(f_hz, dtype=float),
        L,
        P_d[:, -1] + P_u[:, -1] * u_d,
        P_u[:, -1] * u_r,
    )


def evaluate(system: ct.StateSpace, point: ComplexArray) -> ComplexArray:
    """Return a system at complex points (n,) of its own plane, (n, rows, columns)."""
    return np.asarray(np.moveaxis(system.horner(point, warn_infinite=False), -1, 0))


def battery(response: Response) -> Battery:
    """Read crossovers, margins, sensitivity and disturbance figures off a loop."""
    f_hz, L = response.f_hz, response.L
    omega = 2 * np.pi * f_hz
    gm, pm, sm, w_gm, w_pm, w_sm = _margins(L, omega)
    nearest = np.argmin(sm) if len(sm) else None
    S = 1 / (1 + L)
    worst = int(np.argmax(np.abs(S)))
    s_max, s_max_hz = float(np.abs(S[worst])), float(f_hz[worst])
    if nearest is not None and 1 / sm[nearest] >= s_max:
        s_max, s_max_hz = float(1 / sm[nearest]), float(w_sm[nearest] / (2 * np.pi))
    slope = np.interp(w_pm, omega, np.gradient(np.abs(L), omega))
    d = response.disturbance
    softest, largest = int(np.argmin(d.real)), int(np.argmax(np.abs(d)))
    return Battery(
        crossovers_hz=w_pm / (2 * np.pi),
        falling=slope < 0,
        phase_margins=np.deg2rad(pm),
        phase_crossovers_hz=w_gm / (2 * np.pi),
        gain_margins=gm,
        s_max=s_max,
        s_max_hz=s_max_hz,
        bands_hz=_bands(S, f_hz),
        real_min=float(d.real[softest]),
        real_min_hz=float(f_hz[softest]),
        magnitude_max=float(np.abs(d[largest])),
        magnitude_max_hz=float(f_hz[largest]),
    )


def _margins(L: ComplexArray, omega: FloatArray) -> tuple[FloatArray, ...]:
    """Return (gm, pm, sm, w_gm, w_pm, w_sm) of python-control, each one once."""
    gm, pm, sm, w_gm, w_pm, w_sm = ct.stability_margins(
        ct.frd(L, omega, smooth=True), returnall=True
    )
    # a crossing that falls on a grid point is found from both sides
    gains, phases = _distinct(w_gm), _distinct(w_pm)
    return gm[gains], pm[phases], sm, w_gm[gains], w_pm[phases], w_sm


def _distinct(omega: FloatArray) -> NDArray[np.bool_]:
    return np.diff(omega, prepend=-np.inf) > 1e-9 * omega


def _bands(S: ComplexArray, f_hz: FloatArray) -> FloatArray:
    # |S| = 1 is the gain crossover of S
    crossings = _margins(S, 2 * np.pi * f_hz)[4] / (2 * np.pi)
    return bands_between(f_hz, np.abs(S), crossings)


def bands_between(
    f_hz: FloatArray, value: FloatArray, crossings: FloatArray
) -> FloatArray:
    """Return the bands where a curve is below 1, (m, 2), from where it passes 1.

    A band that reaches the low end of the grid counts from 0.
    """
    edges = np.concatenate([f_hz[:1], crossings, f_hz[-1:]])
    middles = (edges[:-1] + edges[1:]) / 2
    below = np.interp(middles, f_hz, value) < 1
    bands: FloatArray = np.column_stack([edges[:-1], edges[1:]])[below]
    bands[bands == f_hz[0]] = 0.0
    return bands


def poles(loop: Loop) -> ComplexArray:
    """Return the closed loop's eigenvalues in s or z, late samples included.

    States of the controller that serve its commands only are no part of the loop.
    """
    controller = without_bystanders(loop.controller[:, : loop.plant.noutputs])
    controller = delayed(controller, loop.latency)
    closed = ct.feedback(loop.plant[:, :1], controller, sign=1)
    eigenvalues: ComplexArray = closed.poles()
    return eigenvalues


def delayed(system: ct.StateSpace, samples: int) -> ct.StateSpace:
    """Return a sampled system whose outputs are late by whole samples."""
    eye = np.eye(system.noutputs)
    zero = np.zeros_like(eye)
    one = ct.ss(zero, eye, eye, zero, system.dt, remove_useless_states=False)
    for _ in range(samples):
        system = one * system
    return system
