"""K_track: one linear tracking controller, e = r - u_c → v_t, by H-infinity.

    w = (r, d),   z = (W_e e, W_v v_t),   y = e

d enters at the plant's input with δ volts.  With r alone the plant's poles 0 and
-21.8 rad/s are zeros of the problem, the first on the imaginary axis: the controller
would cancel both and leave no stiffness against a constant force.  The plant is the
rigid body, in metres: with the flexible mode the controller cancels that mode and is
unstable elsewhere on the stroke (docs/studies/ball_screw_lpv.md).

Source: Hanifzadegan 2014, sec. 4.3.1, 4.4.1, eq. 4.1, 4.2, Table 4.1; δ is our choice.
"""

from typing import NamedTuple

import numpy as np

from controllers.synthesis.ball_screw_lpv.loops import Loop
from controllers.synthesis.ball_screw_lpv.plants import VOLT, rigid_body
from controllers.synthesis.lpv.h_infinity import h_infinity
from controllers.synthesis.lpv.norm import peak
from controllers.synthesis.lpv.systems import (
    GeneralisedPlant,
    System,
    residualised,
)
from controllers.synthesis.lpv.weights import decibels, shelf

W_E = (decibels(-140), decibels(4), 750.0, 3)  # M_L, M_H, ω_b (rad/s), k
W_V = 6e-4
DELTA = 150.0  # V


class Tracking(NamedTuple):
    """K (continuous, SI), the smallest γ, and the true norm with this very K."""

    K: System
    gamma: float
    norm: float


def design(
    W_e: tuple[float, float, float, int] = W_E,
    W_v: float = W_V,
    delta: float = DELTA,
    plant: System | None = None,
    fastest: float = 1e5,
) -> Tracking:
    """Return the H-infinity controller.

    Args:
        W_e: M_L, M_H, ω_b (rad/s) and order of the weight on the error.
        W_v: weight on the command (1/V).
        delta: size of the disturbance at the plant's input (V).
        plant: f_m → u_c; the rigid body if None.
        fastest: poles of K beyond (rad/s) become gain: an optimum has one.
    """
    generalised = plant_with_weights(W_e, W_v, delta, plant)
    found = h_infinity(generalised)
    K = residualised(found.K, fastest)
    return Tracking(K, found.gamma, peak(generalised.close(K))[0])


def damped(G: System, K_vib: System) -> System:
    """Return f_m → u_c of a plant (f_m, f_c) → (u_m, u_c) under K_vib (continuous).

    What K_track is designed for anew once the mode is damped (4.4.2: T to 1500 rad/s).
    """
    closed = Loop(G, K_vib=K_vib).closed()
    return System(
        closed.A, closed.B[:, [0]] / VOLT, closed.C[[1]], closed.D[[1]][:, [0]]
    )


def plant_with_weights(
    W_e: tuple[float, float, float, int] = W_E,
    W_v: float = W_V,
    delta: float = DELTA,
    plant: System | None = None,
) -> GeneralisedPlant:
    """Return the generalised plant; arguments as of ``design``."""
    G, W = rigid_body() if plant is None else plant, shelf(*W_e)
    n, k = len(G.A), len(W.A)
    zero = np.zeros
    return GeneralisedPlant(
        A=np.block([[G.A, zero((n, k))], [-W.B @ G.C, W.A]]),
        B_1=np.block([[zero((n, 1)), VOLT * delta * G.B], [W.B, zero((k, 1))]]),
        B_2=np.vstack([VOLT * G.B, zero((k, 1))]),
        C_1=np.vstack([np.hstack([-W.D @ G.C, W.C]), zero((1, n + k))]),
        C_2=np.hstack([-G.C, zero((1, k))]),
        D_11=np.array([[W.D[0, 0], 0.0], [0.0, 0.0]]),
        D_12=np.array([[0.0], [W_v]]),
        D_21=np.array([[1.0, 0.0]]),
    )
