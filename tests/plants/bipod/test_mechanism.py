"""The bipod's mechanism is that of its masses (Hanifzadegan 2014, sec. 7.2.1)."""

import numpy as np
import pytest
from numpy.typing import NDArray

from plants.bipod import one_slider, two_sliders
from plants.bipod._mechanism import Links, convective, damping, inertia, weight

Array = NDArray[np.float64]
TABLE = {  # degrees: H_1 (kg), C_m (kg/m), C_d (N s/m), G (N)
    "10": ("33.6303", "-0.52567", "55.2607", "14.53"),
    "30": ("34.8351", "-2.5310", "56.8027", "47.58"),
    "45": ("37.4927", "-8.0536", "60.2041", "82.40"),
    "60": ("45.4653", "-39.4544", "70.4082", "142.73"),
    "70": ("63.5976", "-195.535", "93.6155", "226.40"),
    "75.4": ("92.2583", "-682.511", "130.298", "316.35"),
    "80": ("161.720", "-3084.01", "219.201", "467.34"),
}
ANGLES = [np.deg2rad(float(angle)) for angle in TABLE]
L_S, A_S, G = 0.7, 0.125, 9.81
M_1, M_2, M_3, M_S, J_S = 25.36, 22.67, 10.56, 4.16, 0.37
MASSES = np.array([M_1, M_2, M_3, M_3, *[M_S] * 6, 3 * J_S])
HEIGHTS = np.array([0, 0, 0, 1, 0, 1, 0, 1, 0, 1, 0])  # which of them are heights


def places(x_1: complex, x_2: complex) -> NDArray[np.complex128]:
    """Sliders, tool table, centres of three rods (x, y each), angle of the rods."""
    sine = (x_2 - x_1 - A_S) / (2 * L_S)
    y = L_S * np.sqrt(1 - sine * sine)
    first, last = ((3 * x_1 + x_2) / 4, y / 2), ((x_1 + 3 * x_2) / 4, y / 2)
    tool = ((x_1 + x_2) / 2, y)
    return np.array([x_1, x_2, *tool, *first, *first, *last, np.arcsin(sine)])


def moving(x: Array) -> Array:
    """How fast places move per slider's speed, by complex step, (11, 2)."""
    h = 1e-30
    columns = [places(*(x + 1j * h * unit)).imag / h for unit in np.eye(2)]
    return np.array(columns).T


def masses(x: Array) -> Array:
    """The matrix of the kinetic energy, (2, 2)."""
    J = moving(x)
    return np.asarray(J.T @ (MASSES[:, None] * J))


def pull(x: Array) -> Array:
    """What gravity, which pulls the tool table away from the rail, does to x."""
    return np.asarray(moving(x).T @ (MASSES * HEIGHTS * G))


@pytest.mark.parametrize("angle", TABLE)
def test_the_mechanism_has_the_figures_of_the_dossier_to_their_last_digit(
    angle: str,
) -> None:
    """H_1, C_m, C_d are told to 1e-5; G to 0.01 N, 14.53 alone is 3e-4 wide."""
    t, p = np.tan(np.deg2rad(float(angle))), Links()
    ours = inertia(t, p), convective(t, p), damping(t, p), weight(t, p, G)
    for value, told in zip(ours, TABLE[angle], strict=True):
        digits = len(told.split(".")[1])
        assert abs(value - float(told)) <= 0.5001 * 10.0**-digits
    for value, told in zip(ours[:3], TABLE[angle][:3], strict=True):
        assert value == pytest.approx(float(told), rel=1e-5)


@pytest.mark.parametrize("phi", ANGLES)
def test_both_sliders_accelerate_as_energy_demands(phi: float) -> None:
    """Masses, what their change takes, and weight, from the places of all masses.

    M ẍ = f - ½ Σ (∂M_ij/∂x_k + ∂M_ik/∂x_j - ∂M_jk/∂x_i) ẋ_j ẋ_k + pull - losses
    """
    p = two_sliders.Parameters(g=G)
    x, v = np.array([0.1, 0.1 + A_S + 2 * L_S * np.sin(phi)]), np.array([0.4, -0.7])
    h = 1e-6
    slope = [(masses(x + h * e) - masses(x - h * e)) / (2 * h) for e in np.eye(2)]
    dM = np.array(slope)  # k, i, j
    taken = np.einsum("kij,j,k->i", dM, v, v) - np.einsum("ijk,j,k->i", dM, v, v) / 2
    turning = 1 / (2 * L_S * np.cos(phi)) ** 2 * (v[1] - v[0])
    lost = p.links.b_x * v + p.links.b_phi * turning * np.array([-1, 1])
    f, f_d = np.array([700.0, -300.0]), 150.0
    f_y = moving(x)[3] * f_d
    expected = np.linalg.solve(masses(x), f + f_y - taken + pull(x) - lost)
    state = two_sliders.State(x[0], v[0], x[1], v[1])
    got = two_sliders.derivative(state, two_sliders.Input(*f, f_d), p)
    assert [got.v_1, got.v_2] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("phi", ANGLES)
def test_weight_and_inertia_of_one_slider_are_the_energys_to_1e_9(phi: float) -> None:
    """G with x_2 fixed is what the tool table and rods pull, and H_1 their masses."""
    t, p = np.tan(phi), Links()
    x_2 = one_slider.Parameters().x_2
    x = np.array([x_2 - A_S - 2 * L_S * np.sin(phi), x_2])
    assert weight(t, p, G) == pytest.approx(pull(x)[0], rel=1e-9)
    assert inertia(t, p) == pytest.approx(masses(x)[0, 0], rel=1e-9)
    resting = one_slider.State(x[0])
    got = one_slider.derivative(resting, one_slider.Input(), one_slider.Parameters(g=G))
    assert got.v_1 == pytest.approx(pull(x)[0] / masses(x)[0, 0], rel=1e-9)
