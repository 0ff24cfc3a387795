"""Singular values, sensitivity and stability of a loop of several signals.

    L = G K,   S = (I + L)⁻¹,   disturbance G_d = S G

A loop here is a sampled plant u → y and controller y → u, without commands.
Responses are arrays (n, outputs, inputs).  Crossovers are where the upper singular
value of L passes 1, interpolated on logarithmic axes.  A sampled loop that is
stable when opened has as many poles outside a circle as det(I + L) turns
clockwise about 0 along it.
Source: Gordon 2010, sec. 4.4.2 (equation 4.21 and the definitions after it).
"""

from typing import NamedTuple

import control as ct
import numpy as np

from controllers.synthesis.frequency import (
    ComplexArray,
    Loop,
    bands_between,
    delayed,
    evaluate,
)
from controllers.synthesis.linearise import without_bystanders
from fmus.model import FloatArray

GRID_HZ: FloatArray = np.geomspace(1.0, 1500.0, 6000)


class MultiResponse(NamedTuple):
    """G and K (error to control signal) at the frequencies f_hz (n,)."""

    f_hz: FloatArray
    G: ComplexArray
    K: ComplexArray

    @property
    def L(self) -> ComplexArray:
        return np.asarray(self.G @ self.K)

    @property
    def S(self) -> ComplexArray:
        return np.asarray(np.linalg.inv(np.eye(self.G.shape[1]) + self.L))


def respond(loop: Loop, f_hz: FloatArray = GRID_HZ) -> MultiResponse:
    """Evaluate a sampled loop at the frequencies (n,)."""
    z = np.exp(2j * np.pi * np.asarray(f_hz) * loop.plant.dt)
    late = (z**-loop.latency)[:, None, None]
    return MultiResponse(
        np.asarray(f_hz, dtype=float),
        evaluate(loop.plant, z),
        np.asarray(-evaluate(loop.controller, z) * late),
    )


def upper(M: ComplexArray) -> FloatArray:
    """Return the upper singular values of matrices (n, i, j)."""
    return np.asarray(np.linalg.norm(M, 2, axis=(1, 2)))


def crossings(f_hz: FloatArray, value: FloatArray, level: float = 1.0) -> FloatArray:
    """Return where a positive curve passes a level, linear in the logarithms."""
    above = np.log(value / level)
    (k,) = np.nonzero(np.signbit(above[:-1]) != np.signbit(above[1:]))
    part = above[k] / (above[k] - above[k + 1])
    log_f = np.log(f_hz)
    return np.asarray(np.exp(log_f[k] + part * (log_f[k + 1] - log_f[k])))


def bands_below(f_hz: FloatArray, value: FloatArray) -> FloatArray:
    """Return the bands where a positive curve is below 1, (m, 2); from 0 at the end."""
    return bands_between(f_hz, value, crossings(f_hz, value))


def poles(loop: Loop) -> ComplexArray:
    """Return the closed loop's eigenvalues in z, late samples included."""
    controller = delayed(without_bystanders(loop.controller), loop.latency)
    eigenvalues: ComplexArray = ct.feedback(loop.plant, controller, sign=1).poles()
    return eigenvalues


def clockwise_turns(loop: Loop, radius: float = 1 + 2e-5, points: int = 20_000) -> int:
    """Return the clockwise turns of det(I + L) about 0 on the circle |z| = radius.

    They count the closed-loop poles outside it (the opened loop has none there).
    """
    # dense near z = 1, where the integrators stand
    angle = np.geomspace(1e-6, np.pi, points)
    around = 1j * np.concatenate([[0.0], angle])
    z = np.asarray(radius * np.exp(around), dtype=np.complex128)
    K = -evaluate(loop.controller, z) * (z**-loop.latency)[:, None, None]
    L = evaluate(loop.plant, z) @ K
    det = np.linalg.det(np.eye(L.shape[1]) + L)
    turned = np.sum(np.angle(det[1:] / det[:-1]))
    return round(-float(turned) / np.pi)  # the other half circle mirrors this one
