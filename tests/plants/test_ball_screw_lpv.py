"""Physics of the ball screw with varying dynamics (Hanifzadegan 2014, ch. 3)."""

import json

import numpy as np
import pytest
from scipy.linalg import eigh

from controllers.synthesis.ball_screw_lpv import waves
from controllers.synthesis.linearise import linearise
from fmus.data import read_data
from plants.ball_screw_lpv import two_modes
from plants.ball_screw_lpv._mode import (
    R_G,
    Mode,
    OverPosition,
    OverPositionAndMass,
    Rigid,
    force_on_table,
    inertia,
    over_position,
    over_position_and_mass,
)
from plants.ball_screw_lpv._screw import Matrices, Screw, matrices

POSITIONS = np.linspace(0.2, 0.6, 9)


def poles(m: Matrices, p: Screw) -> np.ndarray:
    M = np.array([[m.m_11, m.m_12], [m.m_12, m.m_22]])
    spring = np.array([[1.0, -1.0], [-1.0, 1.0]])
    C = np.diag([p.c_m / p.r_g**2, p.c_c]) + m.c_hys * spring
    zero, one = np.zeros((2, 2)), np.eye(2)
    A = np.block(
        [[zero, one], [-np.linalg.solve(M, m.k_e * spring), -np.linalg.solve(M, C)]]
    )
    return np.linalg.eigvals(A)


@pytest.mark.parametrize(("eta", "zeta"), [(0.0, 0.00459), (0.0475, 0.0199)])
def test_the_screw_has_the_published_matrices_and_mode(eta: float, zeta: float) -> None:
    """(3.15): M_s, k_e, and the mode of 1305 rad/s with 0.46 and 1.99 % damping."""
    p = Screw(eta=eta)
    m = matrices(0.59, 0.0, p)
    assert [m.m_11, m.m_12, m.m_22] == pytest.approx([45.52, 0.73, 23.45], abs=0.01)
    assert m.k_e == pytest.approx(2.579e7, rel=1e-3)
    mode = max(poles(m, p), key=lambda pole: pole.imag)
    assert abs(mode) == pytest.approx(1304.9, rel=1e-3)
    assert -mode.real / abs(mode) == pytest.approx(zeta, abs=1e-4)


@pytest.mark.parametrize("m_wor", [0.0, 9.07, 100.0])
@pytest.mark.parametrize("x_c", POSITIONS)
def test_a_screw_that_moves_as_a_body_has_its_whole_mass(
    x_c: float, m_wor: float
) -> None:
    """Identities of the kinetic energy, which the printed (A.14) misses."""
    p = Screw()
    m = matrices(x_c, m_wor, p)
    screw = p.rho_s * np.pi * p.d_s**4 / 32 * p.l_s
    whole = (p.J_m + screw) / p.r_g**2 + p.m_tab + m_wor
    assert m.m_11 + 2 * m.m_12 + m.m_22 == pytest.approx(whole, rel=1e-12)


def test_structural_damping_rises_with_the_workpiece() -> None:
    """The text of 3.3.3 says it falls; its own formula says 600 to 1500 kg/s."""
    light, heavy = (matrices(0.1, m, Screw()).c_hys for m in (0.0, 100.0))
    assert heavy > light
    assert matrices(0.59, 0.0, Screw()).c_hys == pytest.approx(605, abs=1.5)


@pytest.mark.parametrize(
    ("x_c", "omega", "peak"),
    [(0.2, 1478.8, -131.97), (0.4, 1401.2, -130.99), (0.6, 1337.2, -130.91)],
)
def test_the_identified_mode_peaks_as_published(
    x_c: float, omega: float, peak: float
) -> None:
    mode = over_position(x_c, OverPosition(), R_G)
    assert mode.omega == pytest.approx(omega, rel=1e-12)
    assert 20 * np.log10(g_22_peak(x_c, run_out=0.0)) == pytest.approx(peak, abs=0.05)


def g_22_peak(x_c: float, run_out: float) -> float:
    rigid = Rigid()
    mode = over_position(x_c, OverPosition(), R_G, run_out)
    b_0, b_1 = force_on_table(mode)
    s = 1j * np.linspace(1200, 1700, 5001)
    den = s * s + 2 * mode.zeta * mode.omega * s + mode.omega**2
    q = (b_1 + (s + 2 * mode.zeta * mode.omega) * b_0) / den
    v = s * q - b_0
    flexible = mode.alpha_12 * q + mode.beta_12 * v
    whole = rigid.r_g**2 / (s * (rigid.J_e * s + rigid.B_e)) + flexible
    return float(np.max(np.abs(whole)))


MODES: list[Mode] = [over_position(x, OverPosition(), R_G) for x in POSITIONS] + [
    over_position_and_mass(x, m, OverPositionAndMass())
    for x in POSITIONS
    for m in (0.0, 10.0)
]


@pytest.mark.parametrize("mode", MODES)
def test_the_mode_answers_alike_from_either_end(mode: Mode) -> None:
    """G_12 = G_21, and G_22 completes a mode of rank one (3.26)."""
    b_0, b_1 = force_on_table(mode)
    damping, stiffness = 2 * mode.zeta * mode.omega, mode.omega**2
    A = np.array([[0.0, 1.0], [-stiffness, -damping]])
    B = np.array([[0.0, b_0], [1.0, b_1]])
    C = np.array([[mode.alpha_11, mode.beta_11], [mode.alpha_12, mode.beta_12]])
    s = 1j * mode.omega
    G = C @ np.linalg.solve(s * np.eye(2) - A, B)
    assert G[0, 1] == pytest.approx(G[1, 0], rel=1e-12)
    assert G[1, 1] == pytest.approx(G[1, 0] ** 2 / G[0, 0], rel=5e-4)


def test_inertia_grows_with_the_workpiece() -> None:
    assert inertia(10.0, Rigid()) == pytest.approx(7.1432e-4 + 10 * R_G**2, rel=1e-12)


def test_the_shipped_modes_are_the_solutions_of_the_wave_equations() -> None:
    file = json.loads(read_data(two_modes.__file__, "two_modes.json"))
    for i, j in ((0, 0), (4, 3), (10, 7)):
        first, second = waves.modes(file["x_c"][i], file["m_wor"][j])[:2]
        assert file["modes"][i][j] == pytest.approx([*first, *second], rel=1e-9)
    assert two_modes.model.parameters.waves.modes.shape == (11 * 8, 6)


@pytest.mark.parametrize(("x_c", "m_wor"), [(0.2, 0.0), (0.59, 0.0), (0.4, 10.0)])
def test_the_wave_equations_have_the_mode_of_the_hybrid_model(
    x_c: float, m_wor: float
) -> None:
    """The quasi-static shapes of (A.12) and (A.13) cost 0.25 % of frequency."""
    m = matrices(x_c, m_wor, Screw(eta=0.0))
    M = np.array([[m.m_11, m.m_12], [m.m_12, m.m_22]])
    values, shapes = eigh(m.k_e * np.array([[1, -1], [-1, 1]]), M)
    first = waves.modes(x_c, m_wor)[0]
    assert first.omega == pytest.approx(np.sqrt(values[1]), rel=2.5e-3)
    shape = shapes[:, 1] * np.sign(shapes[1, 1])
    assert [first.phi_m, first.phi_c] == pytest.approx(shape, rel=2e-2)


def test_the_plant_of_two_modes_has_these_poles_between_table_points() -> None:
    system = linearise(
        two_modes.model, input=two_modes.Input(x_c=0.333, m_wor=4.0), inputs=["f_c"]
    )
    found = sorted(set(np.round(np.abs(np.linalg.eigvals(system.A)), 6)))[-2:]
    exact = [mode.omega for mode in waves.modes(0.333, 4.0)[:2]]
    assert found == pytest.approx(exact, rel=1e-3)
