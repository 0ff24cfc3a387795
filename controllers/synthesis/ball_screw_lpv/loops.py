"""The controlled drive at one nut position: responses and poles, continuous or sampled.

    v_m = K_track (r - u_c) + K_vib (u_m - u_c)

Source: Hanifzadegan 2014, fig. 4.1.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from controllers.synthesis.ball_screw_lpv.plants import VOLT
from controllers.synthesis.lpv.systems import (
    ComplexArray,
    Matrix,
    System,
    poles,
    response,
)

NONE = System(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.zeros((1, 1)))


@dataclass(frozen=True)
class Loop:
    """Plant (f_m, f_c) → (u_m, u_c), K_track and K_vib, all of one kind of time.

    ``latency`` delays v_m by whole samples.
    """

    plant: System
    K_track: System = NONE
    K_vib: System = NONE
    latency: int = 0

    def closed(self) -> System:
        """Return (v, f_c, r) → (u_m, u_c, v_m), v added to the command v_m."""
        G, T, V = self.plant, self.K_track, self.K_vib
        controller = _late(_beside(T, V), self.latency)
        n, k = len(G.A), len(controller.A)
        B = np.hstack([VOLT * G.B[:, :1], G.B[:, 1:], np.zeros((n, 1))])
        seen = np.array([[0.0, -1.0], [1.0, -1.0]]) @ G.C  # e at r = 0, u_m - u_c
        command = np.array([[1.0], [0.0]])
        A = np.block(
            [
                [G.A + B[:, :1] @ controller.D @ seen, B[:, :1] @ controller.C],
                [controller.B @ seen, controller.A],
            ]
        )
        B = np.vstack([B, np.zeros((k, 3))])
        B[:, [2]] += np.vstack(
            [VOLT * G.B[:, :1] @ controller.D @ command, controller.B @ command]
        )
        C = np.vstack(
            [
                np.hstack([G.C, np.zeros((2, k))]),
                np.hstack([controller.D @ seen, controller.C]),
            ]
        )
        D = np.zeros((3, 3))
        D[2, 2] = (controller.D @ command).item()
        D[2, 0] = 1.0
        return System(A, B, C, D)

    def tracking(self, points: ComplexArray) -> ComplexArray:
        """Return T, r → u_c, at points s or z (n,)."""
        return response(self.closed(), points)[:, 1, 2]

    def sensitivity(self, points: ComplexArray) -> ComplexArray:
        """Return S = 1 - T, r → e."""
        return 1.0 - self.tracking(points)

    def disturbance(self, points: ComplexArray) -> ComplexArray:
        """Return f_c → u_c (m/N)."""
        return response(self.closed(), points)[:, 1, 1]

    def radius(self) -> float:
        """Return the largest magnitude of the poles: below 1 if sampled and stable."""
        return float(np.max(np.abs(poles(self.closed()))))

    def abscissa(self) -> float:
        """Return the largest real part of the poles (rad/s)."""
        return float(np.max(poles(self.closed()).real))


def held(plant: System, T_s: float) -> System:
    """Return a plant whose inputs are held over samples of T_s (s)."""
    n, m = plant.B.shape
    whole = np.zeros((n + m, n + m))
    whole[:n, :n], whole[:n, n:] = plant.A, plant.B
    whole = expm(whole * T_s)
    return System(whole[:n, :n], whole[:n, n:], plant.C, plant.D)


def crossing(omega: Matrix, value: Matrix, level: float) -> float:
    """Return where a curve last leaves a level (interpolated in log ω), nan if never.

    The last grid interval whose ends lie on either side of the level counts.
    """
    above = value > level
    changes = np.flatnonzero(above[:-1] != above[1:])
    if not len(changes):
        return float("nan")
    k = changes[-1]
    share = (level - value[k]) / (value[k + 1] - value[k])
    return float(omega[k] * (omega[k + 1] / omega[k]) ** share)


def _beside(track: System, vib: System) -> System:
    """Return (e, u_m - u_c) → v, the sum of both controllers."""
    n, k = len(track.A), len(vib.A)
    A = np.block([[track.A, np.zeros((n, k))], [np.zeros((k, n)), vib.A]])
    B = np.block([[track.B, np.zeros((n, 1))], [np.zeros((k, 1)), vib.B]])
    return System(A, B, np.hstack([track.C, vib.C]), np.hstack([track.D, vib.D]))


def _late(system: System, samples: int) -> System:
    for _ in range(samples):
        n = len(system.A)
        system = System(
            np.block([[system.A, np.zeros((n, 1))], [system.C, np.zeros((1, 1))]]),
            np.vstack([system.B, system.D]),
            np.hstack([np.zeros((1, n)), np.eye(1)]),
            np.zeros_like(system.D),
        )
    return system
