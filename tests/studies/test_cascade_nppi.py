"""The study's systems against an independent monolith and against theory.

The monolith knows none of our models: the table by matrix exponentials with the
fractional dead time of 2.4 samples, the cascade as printed (Anang et al. 2018,
eq. 1 to 9).
"""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import brentq
from simulated import Co

from orchestrator.evaluation.sine import sine_fit
from orchestrator.reproduction.reproduce import reproduce
from orchestrator.session import run

STUDY = "cascade_nppi"
k_p, k_i, k_v, TAU = 0.006607, 0.12075, 225.0, 1.2e-3
Array = NDArray[np.float64]


class Table:
    """Exact motion over T under a late, held voltage: x⁺ = Φ x + older, newer u."""

    def __init__(self, T: float) -> None:
        self.late = int(TAU / T + 1e-9)
        f = TAU - self.late * T

        def held(h: float) -> tuple[Array, Array]:
            M = np.zeros((3, 3))
            M[:2] = [[0, 1, 0], [-193.3, -163, 78020]]
            E = expm(M * h)
            return E[:2, :2], E[:2, 2]

        (older, gain), (newer, self.newer) = held(f), held(T - f)
        self.Phi = newer @ older
        self.older = newer @ gain

    def move(self, x: Array, u: Array) -> Array:
        """Return x after one sample; u = (u_k, u_{k-1}, ...)."""
        moved: Array = (
            self.Phi @ x + self.older * u[self.late + 1] + self.newer * u[self.late]
        )
        return moved


def monolith(n: int, f_hz: float, KO: float, T: float = 1 / 2000) -> tuple[Array, ...]:
    """Return position (mm) and voltage under a sine of 10 mm, each of shape (n,)."""
    table = Table(T)
    x, e_vi, y_old = np.zeros(2), 0.0, 0.0
    u = np.zeros(table.late + 2)
    position, voltage = np.empty(n), np.empty(n)
    for k in range(n):
        e = 10 * np.sin(2 * np.pi * f_hz * k * T) - x[0]
        e_v = k_v * np.cosh(KO * e) * e - (x[0] - y_old) / T
        e_vi, y_old = e_vi + T * e_v, x[0]
        u = np.append(k_p * e_v + k_i * e_vi, u[:-1])
        position[k], voltage[k] = x[0], u[0]
        x = table.move(x, u)
    return position, voltage


@pytest.mark.parametrize(
    ("scenario", "KO"), [("p_pi_0_7hz", 0.0), ("np_pi_0_7hz", 3.5)]
)
def test_the_fmus_are_the_monolith(co_simulated: Co, scenario: str, KO: float) -> None:
    found = co_simulated(scenario)
    y, u = found["plant.y"].values, found["controller.u"].values
    position, voltage = monolith(len(y), 0.7, KO)
    np.testing.assert_allclose(y, position, rtol=0, atol=1e-9 * 10)
    np.testing.assert_allclose(u, voltage, rtol=0, atol=1e-9 * np.abs(u).max())


def test_np_pi_without_variation_is_p_pi_to_the_last_bit(co_simulated: Co) -> None:
    plain = co_simulated("p_pi_0_7hz")
    nonlinear = co_simulated("np_pi_0_7hz", "controller.KO=0")
    for name in ("plant.y", "controller.u", "controller.e"):
        np.testing.assert_array_equal(nonlinear[name].values, plain[name].values)


def test_the_split_cascade_is_the_composite_to_the_last_bit(co_simulated: Co) -> None:
    whole, parts = co_simulated("np_pi_0_7hz"), co_simulated("np_pi_split_0_7hz")
    np.testing.assert_array_equal(parts["plant.y"].values, whole["plant.y"].values)
    np.testing.assert_array_equal(parts["velocity.u"].values, whole["controller.u"])


def test_every_figure_of_the_study_keeps_its_acceptance(tmp_path: Path) -> None:
    figures = reproduce(STUDY, processes=1, folder=tmp_path).figures
    assert [f.spec.id for f in figures if f.regression == "FAILED"] == []
    matched = {f.spec.id for f in figures if f.verdict == "agrees"}
    table_2 = {f"{c}.{f}.max_error" for c in ("p_pi", "np_pi") for f in FREQUENCIES}
    assert table_2 <= matched
    assert {f"np_pi.{f}.improvement" for f in FREQUENCIES} <= matched


FREQUENCIES = ("0.4hz", "0.7hz")


def printed(f_hz: float, N: float) -> tuple[complex, complex]:
    """Return |E/Z_ref| and E/D K_f of eq. 9."""
    s = 2j * np.pi * f_hz
    G = 78020 * np.exp(-TAU * s) / (s**2 + 163 * s + 193.3)
    speed = (k_p + k_i / s) * G * s
    below = 1 + speed + N * k_v * (k_p + k_i / s) * G
    return (1 + speed) / below, -G / below


@pytest.mark.parametrize("N", [0.8, 1.5, 2.2])
def test_with_the_gain_held_the_error_is_that_of_equation_9(
    co_simulated: Co, N: float
) -> None:
    found = co_simulated("p_pi_0_7hz", f"controller.k_v={k_v * N}")
    expected = 10 * abs(printed(0.7, N)[0])
    assert found.metrics["tracking.peak"].value == pytest.approx(expected, rel=2e-3)


def test_a_disturbance_meets_the_loop_of_equation_8(
    co_simulated: Co, tmp_path: Path
) -> None:
    file = tmp_path / "disturbed.toml"
    file.write_text(
        (Path(co_simulated("p_pi_0_7hz").scenario.file).parent / "p_pi_0_4hz.toml")
        .read_text()
        .replace('stop = "15/2"', "stop = 2")
        .replace("amplitude = 10e-3", "amplitude = 0")
        .replace("[connections]", '[connections]\n"plant.d" = "force.d"')
        .partition("[metrics]")[0]
        + '[components.force]\nfmu = "plants.disturbances.sine"\nstep = "40 kHz"\n'
        "parameters = { A = 0.1, f_hz = 5 }\n"
    )
    found = run(file, tmp_path / "run", report=False)
    late = found["controller.e"].time >= 1
    e = sine_fit(
        found["controller.e"].time[late], found["controller.e"].values[late], 5.0
    )
    # the sampled loop differs from the continuous one by half a sample or so
    assert e / 0.1 == pytest.approx(printed(5.0, 1.0)[1], rel=0.02)


def test_two_equal_linear_axes_draw_a_circle_of_the_loops_gain(
    co_simulated: Co,
) -> None:
    found = co_simulated("p_pi_circle").metrics
    y, _ = monolith(15_001, 0.4, 0.0)
    late = np.arange(5000, 15_001)
    radius = abs(sine_fit(late / 2000, y[late], 0.4))
    for figure in ("radial.min", "radial.max"):
        assert found[figure].value == pytest.approx(1e3 * (radius - 10), abs=1e-6)


def test_a_gain_that_follows_the_error_draws_no_circle(co_simulated: Co) -> None:
    plain, nonlinear = (co_simulated(f"{c}_circle").metrics for c in ("p_pi", "np_pi"))
    assert nonlinear["x.peak"].value < plain["x.peak"].value
    assert nonlinear["radial.peak"].value > plain["radial.peak"].value


def growth(N: float, T: float, measured: bool) -> float:
    """Return how much the sampled loop with the gain k_v N grows per sample."""
    table = Table(T)
    n = table.late + 2

    def step(state: Array) -> Array:
        x, u, y_old, e_vi = state[:2], state[2 : 2 + n], state[-2], state[-1]
        v = x[1] if measured else (x[0] - y_old) / T
        e_v = -k_v * N * x[0] - v
        e_vi = e_vi + T * e_v
        u = np.append(k_p * e_v + k_i * e_vi, u[:-1])
        return np.concatenate([table.move(x, u), u, [x[0], e_vi]])

    A = np.array([step(unit) for unit in np.eye(4 + n)]).T
    return float(np.max(np.abs(np.linalg.eigvals(A))))


def limit(T: float, measured: bool) -> float:
    return float(brentq(lambda N: growth(N, T, measured) - 1, 1, 8))


@pytest.mark.parametrize("step", ["1/2000", "1/4000", "1/10000", "1/50000"])
def test_the_gain_ramp_finds_the_limit_whatever_the_plants_step(
    co_simulated: Co, step: str
) -> None:
    found = co_simulated("p_pi_gain_ramp", f"plant.step={step}")
    expected = limit(1 / 2000, measured=False)
    assert expected == pytest.approx(2.4294, abs=1e-4)
    assert found.metrics["gain.limit"].value == pytest.approx(expected, rel=1e-3)


def test_a_plant_out_of_step_with_the_controller_costs_gain(co_simulated: Co) -> None:
    # every other sample is then 167 us old, as the schedule lists
    found = co_simulated("p_pi_gain_ramp", "plant.step=1/3000")
    lost = 1 - found.metrics["gain.limit"].value / limit(1 / 2000, measured=False)
    assert lost == pytest.approx(0.076, abs=0.005)


def test_the_limit_tends_to_the_continuous_one(co_simulated: Co) -> None:
    fast = co_simulated("p_pi_gain_ramp_10khz").metrics["gain.limit"].value
    assert fast == pytest.approx(limit(1e-4, measured=True), rel=1e-3)
    gaps = [3.81277 - limit(T, measured=True) for T in (1e-4, 5e-5, 2.5e-5)]
    assert gaps[0] / gaps[1] == pytest.approx(2, rel=0.05)
    assert gaps[1] / gaps[2] == pytest.approx(2, rel=0.05)


@pytest.mark.parametrize("step", ["1/20000", "1/40000"])
def test_a_finer_micro_step_changes_no_figure(co_simulated: Co, step: str) -> None:
    coarse = co_simulated("np_pi_0_7hz").metrics
    fine = co_simulated("np_pi_0_7hz", f"plant.step={step}").metrics
    for name, figure in coarse.items():
        assert fine[name].value == pytest.approx(figure.value, rel=1e-6), name
