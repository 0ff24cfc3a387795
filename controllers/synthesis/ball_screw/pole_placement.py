"""Mode-compensating pole placement of the ball-screw drive.

    u = -K z,  z = (x_1, x_2, ẋ_1, ẋ_2, ∫x_2 dt),  K from eig(A - B K) = p

with the poles p of ``controllers.synthesis.pole_placement``.  Filter pack,
sampling and delay are not part of the design.
Source: Gordon 2010, equations 3.5 to 3.8.
"""

import numpy as np
from scipy import signal

from controllers.synthesis.linearise import linearise
from controllers.synthesis.pole_placement import closed_loop_poles
from fmus.model import FloatArray
from plants.ball_screw import two_mass as ball_screw

GAINS = ("K_x1", "K_x2", "K_v1", "K_v2", "K_i2")


def design(
    m_1: float,
    m_2: float,
    b_1: float,
    b_2: float,
    k: float,
    c: float,
    beta: float = 4.0,
    f2_hz: float = 50.0,
    zeta_2: float = 0.7,
) -> dict[str, float]:
    """Return the gains of the state feedback with integrator.

    Args:
        m_1, m_2: screw and table inertia (V s²/rad).
        b_1, b_2: viscous friction of screw and table (V s/rad).
        k, c: stiffness (V/rad) and damping (V s/rad) between them.
        beta: factor on the axial pair's decay rate.
        f2_hz, zeta_2: frequency (Hz) and damping ratio of the rigid modes.

    Returns:
        K_x1, K_x2 (V/rad), K_v1, K_v2 (V s/rad), K_i2 (V/(rad s)).

    Raises:
        ValueError: the drive has no oscillating axial mode to compensate.
    """
    A, B = augmented(m_1, m_2, b_1, b_2, k, c)
    open_loop = np.linalg.eigvals(A).astype(complex)
    wanted = closed_loop_poles(open_loop, beta, f2_hz, zeta_2)
    K = signal.place_poles(A, B, wanted).gain_matrix
    return dict(zip(GAINS, map(float, np.ravel(K)), strict=True))


def augmented(
    m_1: float, m_2: float, b_1: float, b_2: float, k: float, c: float
) -> tuple[FloatArray, FloatArray]:
    """Return A (5, 5) and B (5, 1) of z = (x_1, x_2, ẋ_1, ẋ_2, ∫x_2 dt)."""
    drive = ball_screw.Parameters(m_1=m_1, m_2=m_2, b_1=b_1, b_2=b_2, k=k, c=c)
    plant = linearise(
        ball_screw.model,
        parameters=drive,
        inputs=["u"],
        outputs=["x_1", "x_2", "v_1", "v_2"],
    )
    A, B = np.zeros((5, 5)), np.zeros((5, 1))
    # the four outputs are the states in the order of the source
    A[:4, :4] = plant.C @ plant.A @ np.linalg.inv(plant.C)
    B[:4] = plant.C @ plant.B
    A[4, 1] = 1.0
    return A, B
