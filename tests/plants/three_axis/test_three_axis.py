"""The machining centre is the one of Tables 8.1 and 8.2."""

import numpy as np
import pytest
from scipy.linalg import expm

from controllers.synthesis.contouring_lpv import figures
from controllers.synthesis.linearise import linearise
from plants.three_axis import _axes, _axis, _values, planar, spatial

AXES = [(_axes.X, _values.X), (_axes.Y, _values.Y), (_axes.Z, _values.Z)]
PRINTED_Z = (
    *("1", "584.9", "1e7", "4.8e9", "3.5e13", "1.3e16", "4.9e19", "1.5e22"),
    *("2.5e25", "5.4e27", "2.4e30", "3.6e32"),
)


def printed(axis: _axes.Axis, s: complex) -> complex:
    """The transfer function of an axis as Tables 8.1 and 8.2 give it."""
    rigid = axis.p_t / (2 * np.pi) * axis.k_t * axis.k_a
    flexible = np.polyval(axis.numerator, s) / np.polyval(axis.denominator, s)
    return rigid / (axis.J_e * s * s + axis.B_e * s) * flexible


@pytest.mark.parametrize("name", ["x", "y", "z"])
def test_an_axis_answers_as_its_printed_polynomials(name: str) -> None:
    """Command and force on the table, which enters at the motor."""
    source, _ = AXES["xyz".index(name)]
    machine = linearise(
        spatial.model,
        inputs=[f"v_m{name}", f"f_c{name}"],
        outputs=[f"u_c{name}"],
    )
    per_newton = source.p_t / (2 * np.pi) / (source.k_t * source.k_a)
    for omega in (0.3, 1.0, 50.0, 340.0, 1450.0, 3000.0):
        s = 1j * omega
        A = s * np.eye(len(machine.A)) - machine.A
        got = (machine.C @ np.linalg.solve(A, machine.B))[0]
        expected = printed(source, s)
        assert got[0] == pytest.approx(expected, rel=1e-11)
        assert got[1] == pytest.approx(expected * per_newton, rel=1e-11)


@pytest.mark.parametrize(
    ("name", "gains", "modes", "slowest"),
    [
        (
            "x",
            (0.0598905, 2.30689e-4, 1.13405e-5),
            (338.03, 0.2295, 2018.5, 0.0361),
            -72.876,
        ),
        (
            "y",
            (0.262082, 2.79697e-4, 1.74438e-5),
            (341.36, 0.0442, 2034.1, 0.0145),
            -15.076,
        ),
        (
            "z",
            (0.2028819, 8.40307e-5, 2.6894e-6),
            (338.17, 0.0775, 943.4, 0.0678),
            -14.711,
        ),
    ],
)
def test_gains_and_modes_are_those_of_the_dossier(
    name: str,
    gains: tuple[float, ...],
    modes: tuple[float, ...],
    slowest: float,
) -> None:
    """Gains (m/V) at 1, 50, 340 rad/s; two modes (rad/s, damping ratio)."""
    found = figures.axis(name)
    ours = [found[f"gain_{omega}"] for omega in (1, 50, 340)]
    assert ours == pytest.approx(gains, rel=1e-5)
    keys = ("omega_1", "zeta_1", "omega_2", "zeta_2")
    assert [found[key] for key in keys] == pytest.approx(modes, rel=2e-3)
    assert found["slowest"] == pytest.approx(slowest, abs=1e-3)


def test_the_planar_machine_is_the_spatial_one_without_z() -> None:
    assert planar.Parameters() == spatial.Parameters()[:2]


@pytest.mark.parametrize(("source", "values"), AXES)
def test_the_modes_have_the_static_gain_of_the_flexible_factor(
    source: _axes.Axis, values: _axis.Axis
) -> None:
    beside = np.diag(values.omega, 1) - np.diag(values.omega, -1)
    A = np.diag(values.sigma) + beside
    assert np.max(np.linalg.eigvals(A).real) < -14
    gain = -values.c @ np.linalg.solve(A, values.b)
    assert gain == pytest.approx(source.numerator[-1] / source.denominator[-1], 1e-12)


def test_the_repaired_denominator_of_z_rounds_to_the_printed_one_and_is_stable() -> (
    None
):
    for text, coefficient in zip(PRINTED_Z, _axes.Z.denominator, strict=True):
        digits = len(text.split("e")[0].replace(".", "")) - 1
        digits = max(digits, 1) if "e" in text else digits
        assert float(f"{coefficient:.{digits}e}") == float(text)
    unstable = _axes.polished(_axes._scaled(tuple(map(float, PRINTED_Z))))
    assert np.max(unstable.real) * 1000 == pytest.approx(117.9, abs=0.1)
    assert np.max(_axes.modes(_axes.Z).poles[1:].real) < -0.3


def test_coulomb_friction_holds_the_screw_below_its_torque() -> None:
    """Held only as far as a steep line at zero speed holds: it creeps within v_0."""
    rubbing = _values.X.friction._replace(on=True)
    axis = _values.X._replace(friction=rubbing)
    volts = rubbing.T_c / (axis.k_t * axis.k_a)
    for share, moves in ((0.5, False), (1.5, True)):
        x = _axis.at_rest(axis)
        for _ in range(4000):
            slope = _axis.derivative(x, share * volts, 0.0, axis)
            x = x._replace(v=x.v + 1e-4 * slope.v)
        assert (x.v > rubbing.v_0) == moves
        assert _axis.derivative(x, 0.0, 0.0, axis).v < 0


def test_a_free_axis_comes_to_rest_as_its_matrices_say() -> None:
    """The state equations of y are the exponential of their matrix, step by step."""
    machine = linearise(planar.model, inputs=["v_my"], outputs=["u_cy"])
    n, T_s = len(machine.A), 1e-3
    held = np.zeros((n + 1, n + 1))
    held[:n, :n], held[:n, n:] = machine.A, machine.B
    held = expm(held * T_s)
    x = np.zeros(n)
    for k in range(400):
        x = held[:n, :n] @ x + held[:n, n] * (1.0 if k < 20 else 0.0)
    pulse = 0.020 * printed_static(_axes.Y)
    settled = pulse * (1 - np.exp(_axes.Y.pole * 0.39))
    assert (machine.C @ x)[0] == pytest.approx(settled, rel=0.02)


def printed_static(axis: _axes.Axis) -> float:
    """Distance (m) that an axis travels in the end per volt and second."""
    flexible = axis.numerator[-1] / axis.denominator[-1]
    return axis.p_t / (2 * np.pi) * axis.k_t * axis.k_a / axis.B_e * flexible
