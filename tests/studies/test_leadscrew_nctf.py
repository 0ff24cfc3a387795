"""The leadscrew's systems against an independent monolith, and what the study shows.

The monolith knows none of our models: one loop over plain numbers, written from
Maeda 2007 and from the integration rule that the plant states (Runge-Kutta 4, in
two parts where the equations have a kink).
"""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from simulated import Co

from orchestrator.reproduction.reproduce import reproduce

STUDY = "leadscrew_nctf"
T = 2e-4
Array = NDArray[np.float64]
HALF_STEP = Path(__file__).parent.parent / "support" / "leadscrew_half_step.py"


def mechanism(
    M: float, T_c: float, C_sd: float, K_n: float, C_n: float, R: float
) -> Callable[[list[float], float], float]:
    """Return a function that moves [θ, x, ω, v, z] over T at a command (A), in place.

    It returns |ω| at the end, by which sticking is told.
    """
    J, K_m, r, sigma_0, sigma_1 = 1.81e-4, 0.172, 2e-3 / (2 * np.pi), 107.0, 0.03
    h, exp = 1e-5, np.exp

    def rate(s: list[float], u: float) -> tuple[float, float, float, float]:
        theta, x, w, y, z = s
        i = max(-6, (-45 - 0.086 * w) / R, min(6, (45 - 0.086 * w) / R, u))
        F = K_n * (r * theta - x) + C_n * (r * w - y)
        z_dot = w - sigma_0 * abs(w) * z / T_c
        torque = K_m * i - sigma_0 * z - sigma_1 * z_dot - C_sd * w - r * F
        return w, y, torque / J, F / M

    def ahead(s: list[float], by: float, k: Sequence[float]) -> list[float]:
        turned = by * k[0]
        end = T_c / sigma_0 * ((turned > 0) - (turned < 0))
        z = end + (s[4] - end) * float(exp(-sigma_0 * abs(turned) / T_c))
        return [s[n] + by * k[n] for n in range(4)] + [z]

    def step(s: list[float], u: float, by: float) -> list[float]:
        k_1 = rate(s, u)
        k_2 = rate(ahead(s, by / 2, k_1), u)
        k_3 = rate(ahead(s, by / 2, k_2), u)
        k_4 = rate(ahead(s, by, k_3), u)
        mean = [(k_1[n] + 2 * (k_2[n] + k_3[n]) + k_4[n]) / 6 for n in range(4)]
        return ahead(s, by, mean)

    def move(s: list[float], u: float) -> float:
        drop = R * max(-6, min(6, u))
        for _ in range(20):
            slope = rate(s, u)[2]
            kinks = 0.0, (45 - drop) / 0.086, (-45 - drop) / 0.086
            times = [(kink - s[2]) / slope for kink in kinks if slope]
            part = min([h, *(t for t in times if t > 0)])
            s[:] = step(s, u, part)
            if part < h:
                s[:] = step(s, u, h - part)
        return abs(s[2])

    return move


class Law:
    """The NCTF law with freeze and conditional notch, numbers in mm, s and A."""

    def __init__(self, table: tuple[Array, Array], K: tuple[float, float], notch: bool):
        self.e, self.edot = table
        self.K_p, self.K_i = K
        self.notch = notch
        self.before: float | None = None
        self.u_i, self.w = 0.0, (0.0, 0.0)
        c = np.tan(np.pi * 215 * T)
        a = 1 + 6 * c + c * c
        self.b = np.array([1 + c * c, 2 * c * c - 2, 1 + c * c]) / a
        self.a = np.array([2 * c * c - 2, 1 - 6 * c + c * c]) / a

    def __call__(self, x_r: float, x: float) -> float:
        e = x_r - x
        rate = 0.0 if self.before is None else (x - self.before) / T
        self.before = x
        u_p = np.sign(e) * np.interp(abs(e), self.e, self.edot) - rate
        u_o = self.K_p * u_p
        if abs(u_o + self.u_i) <= 6 or u_p * self.u_i < 0:
            self.u_i += T * self.K_i * u_p
        u = u_o + self.u_i
        if not self.notch:
            return float(u)
        (w_1, w_2), (b_0, b_1, b_2), (a_1, a_2) = self.w, self.b, self.a
        if abs(e) > 290e-6:
            self.w = (1 - b_0) * u, (b_2 - a_2) * u
            return float(u)
        y = b_0 * u + w_1
        self.w = b_1 * u - a_1 * y + w_2, b_2 * u - a_2 * y
        return float(y)


TAB = {
    "x": (17.5, 0.090, 1e-3, 3.34e7, 9200.0, 4.05),
    "y": (3.57, 0.046, 9.7e-4, 8.3e7, 1700.0, 4.05),
}


@pytest.mark.parametrize(("axis", "height"), [("y", 20e-3), ("x", 1e-3)])
def test_the_composition_of_fmus_equals_a_monolithic_simulation(
    co_simulated: Co, axis: str, height: float
) -> None:
    done = co_simulated("step", f"reference.height={height}")
    x = done[f"{axis}_axis.x"].values
    u = done[f"{axis}_controller.u"].values
    found = {
        name: value
        for step in done.composition.designs.values()
        for name, value in step.values.items()
    }
    table = np.array(found["e_nct"]), np.array(found["edot_nct"])
    law = Law(table, (found["K_p"], found["K_i"]), notch=axis == "x")
    move = mechanism(*TAB[axis])
    s = [0.0] * 5
    q = 1.24e-9
    stuck = False
    for k in range(len(x)):
        y = 1e3 * q * np.floor(s[1] / q + 0.5)
        command = law(1e3 * height, y)
        assert abs(s[1] - x[k]) <= 1e-9 * height, f"x at {k * T:.4f} s"
        assert abs(command - u[k]) <= 1e-9 * 6, f"u at {k * T:.4f} s"
        speed = move(s, command)
        stuck |= k > 100 and speed < 1e-6
    assert stuck  # the agreement holds beyond the first sticking


def test_a_pulse_travels_as_far_as_published_and_its_trajectory_is_that_of_the_dossier(
    co_simulated: Co,
) -> None:
    assert co_simulated("open_loop").metrics["y.final"].value == (
        pytest.approx(48.49, abs=0.1)
    )
    v = co_simulated("nct_element").metrics["v.final"].value
    assert v == pytest.approx(16.50, rel=0.01)


def test_wind_up_overshoots_and_the_freeze_prevents_it(co_simulated: Co) -> None:
    without = co_simulated("windup").metrics
    frozen = co_simulated("step", "reference.height=0.02").metrics
    assert without["y.overshoot"].value == pytest.approx(9.2, abs=0.4)
    assert frozen["y.overshoot"].value < 0.01


def test_controller_1_makes_20_mm_in_the_published_time(co_simulated: Co) -> None:
    y = co_simulated("step_cal", "reference.height=0.02").metrics
    assert y["y.rise"].value == pytest.approx(0.2834, abs=0.003)
    assert y["y.settling"].value == pytest.approx(0.530, abs=0.008)


def test_point_to_point_control_of_a_circle_has_the_dossiers_errors(
    co_simulated: Co,
) -> None:
    errors = co_simulated("circle_5mm_slow_ptp").metrics
    found = [errors[f"{name}.peak"].to("um").value for name in ("x", "y", "radial")]
    assert found == pytest.approx([872, 872, 202], rel=0.01)


def test_a_sample_of_latency_raises_the_ultimate_gain(co_simulated: Co) -> None:
    at_once = co_simulated("ultimate_gain", "stop=9")
    late = co_simulated(
        "ultimate_gain", "y_controller.K_p1=4.9", "stop=6", "y_controller.latency=1"
    )
    assert at_once.metrics["u.level"].value == pytest.approx(2.12, rel=0.05)
    assert late.metrics["u.level"].value == pytest.approx(5.10, rel=0.05)


@pytest.mark.parametrize("C_n", [6900, 9200, 10500])
def test_the_notch_ends_residual_vibration_whatever_the_damping(
    co_simulated: Co, C_n: float
) -> None:
    changed = f"x_axis.C_n={C_n}"
    with_notch = co_simulated(
        "residual_vibration", changed, "x_controller.notch.on=true"
    )
    assert with_notch.metrics["x_residual.span"].value < 2 * 1.24
    if C_n < 9300:
        vibrating = co_simulated("residual_vibration", changed).metrics
        assert vibrating["x_residual.span"].value > 100


def test_point_to_point_and_continuous_control_are_the_same_law_for_steps(
    co_simulated: Co,
) -> None:
    ptp = co_simulated("step")
    continuous = co_simulated("step", "y_controller.continuous=true")
    assert np.array_equal(ptp["y_axis.x"].values, continuous["y_axis.x"].values)


@pytest.mark.parametrize(
    ("scenario", "set_", "figures", "within"),
    [
        ("open_loop", "", ("x.final", "y.final"), 1e-3),
        ("step_cal", "reference.height=0.01", ("y.rise", "x.rise"), 1e-3),
        ("step_cal", "reference.height=0.01", ("y.settling", "x.settling"), T),
        ("circle_5mm", "", ("y.peak",), 1e-3),
        ("circle_1um", "", ("x.peak", "y.peak", "radial.peak"), 1e-3),
        ("circle_100nm", "", ("x.peak", "y.peak", "radial.peak"), 1e-3),
        # the heavy axis moves at the edge of stability: docs/studies
        ("circle_5mm", "", ("x.peak", "radial.peak"), 0.05),
    ],
)
def test_halving_the_micro_step_changes_no_figure(
    co_simulated: Co, scenario: str, set_: str, figures: tuple[str, ...], within: float
) -> None:
    overrides = [set_] if set_ else []
    halved = [f"{axis}_axis.fmu={HALF_STEP}" for axis in "xy"]
    full = co_simulated(scenario, *overrides).metrics
    half = co_simulated(scenario, *overrides, *halved).metrics
    for figure in figures:
        tolerance = {"abs": T} if "settling" in figure else {"rel": within}
        assert half[figure].value == pytest.approx(full[figure].value, **tolerance)


def test_the_quick_figures_of_the_study_are_accepted(tmp_path: Path) -> None:
    figures = reproduce(STUDY, "jury.*", processes=1, folder=tmp_path).figures
    assert len(figures) >= 8
    assert [f.spec.id for f in figures if f.regression == "FAILED"] == []
