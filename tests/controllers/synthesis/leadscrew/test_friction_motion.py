"""Friction and braking from one run: of mechanisms whose parameters are known."""

import numpy as np
import pytest

from controllers.synthesis.leadscrew.friction_motion import braking, fit, friction
from controllers.synthesis.leadscrew.friction_table import (
    Tables,
    compare_and_update,
    updated,
)
from controllers.synthesis.leadscrew.warm_up import reached
from orchestrator.outcome import Run
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

T = 2e-4
J, LEAD = 1.81e-4, 2e-3
STUDY = "leadscrew_nctf"


def driven(a: float, c: float, f: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x (m) and i (A) of v̇ = a i - c v - f under 5 A for 0.2 s, exactly."""
    n = 5000
    i = np.where(np.arange(n) < 1000, 5.0, 0.0)
    x, v = np.zeros(n), 0.0
    decay = np.exp(-c * T)
    for k in range(1, n):
        end = (a * i[k - 1] - f) / c
        if v <= 0 and end <= 0:
            x[k] = x[k - 1]
            continue
        x[k] = x[k - 1] + end * T + (v - end) * (1 - decay) / c
        v = max(end + (v - end) * decay, 0.0)
    return x, np.append(0.0, i[:-1])  # of the interval that ends there


def test_the_law_of_a_rigid_mass_is_found_to_a_tenth_of_a_percent() -> None:
    x, i = driven(0.302, 5.35, 0.0807)
    found = fit(x, i, T)
    assert found[:3] == pytest.approx((0.302, 5.35, 0.0807), rel=1e-3)
    assert found.left < 1e-4


def test_a_run_that_cannot_tell_is_refused() -> None:
    with pytest.raises(ValueError, match="no 50 samples"):
        fit(np.zeros(500), np.zeros(500), T)
    coasting = np.linspace(0.0, 1.0, 500)
    with pytest.raises(ValueError, match="does not change"):
        fit(coasting, np.zeros(500), T)
    x, i = driven(0.302, 5.35, 0.0807)
    with pytest.raises(ValueError, match="does not move at"):
        braking(x, i, T, 0.9)
    x, i = driven(0.302, 5.35, -0.05)
    with pytest.raises(ValueError, match="no Coulomb friction"):
        braking(x, i, T, 0.2)


def test_friction_of_the_mechanism_is_found_and_the_table_updated() -> None:
    """T_c to 0.1 %, C_sd to 0.1 %; the model then follows within 5 um of 24 mm."""
    pulse = run(f"{STUDY}/friction_relubricated", report=False)
    for axis, M, T_c, C_sd in (("x", 17.5, 0.098, 6e-4), ("y", 3.57, 0.05, 7e-4)):
        x, i = (pulse[f"{axis}_axis.{of}"].values for of in ("x", "i"))
        found = friction(x, i, T, J, M, LEAD)
        assert found == pytest.approx({"T_c": T_c, "C_sd": C_sd}, rel=1e-3)
    before = run(f"{STUDY}/friction_compared", report=False)
    after = run(f"{STUDY}/friction_updated", report=False)
    assert before.metrics["x.peak"].to("mm").value > 0.4
    for axis in "xy":
        assert after.metrics[f"{axis}.peak"].to("mm").value < 0.005


def test_a_condition_measured_anew_replaces_those_near_it() -> None:
    tables = Tables(*map(np.array, ([17.0, 18.5, 18.7, 25.0], [3.0] * 4, [9.0] * 4)))
    found = updated(tables, 18.6, 1.0, 2.0)
    assert found.displacement.tolist() == [17.0, 18.6, 25.0]
    assert found.viscous.tolist() == [3.0, 1.0, 3.0]
    assert found.coulomb.tolist() == [9.0, 2.0, 9.0]
    # beyond the ends the tables grow
    assert updated(tables, 30.0, 1.0, 2.0).displacement.tolist()[-1] == 30.0


def test_a_model_that_matches_leaves_the_tables_alone() -> None:
    x, i = driven(0.302, 5.35, 0.0807)
    d = 1e3 * x[-1]
    tables = np.array([d - 5, d, d + 5]), np.full(3, 1e-3), np.array([0.1, 0.09, 0.08])
    same = (T, 0.9, *tables, J, 3.57, LEAD, 0.0, 0.0)
    assert compare_and_update(x, x, i, *same)["T_c"] == pytest.approx(0.09)
    apart = compare_and_update(x, x + 1e-3, i, *same)
    assert apart["T_c"] == pytest.approx(0.0460, rel=2e-3)
    still = compare_and_update(0 * x, x, i, T, 0.9, *tables, J, 3.57, LEAD, 1.0, 2.0)
    assert still == {"C_sd": 1.0, "T_c": 2.0}


def test_the_pulse_as_long_as_the_d_braked_run_says_stops_without_turning_back() -> (
    None
):
    """What is left is the spring of the friction, as after the D controller itself."""
    braked = run(f"{STUDY}/open_loop_d_braked", report=False)
    softly = braked.metrics["y_slowest.min"].to("mm/s").value
    designed = run(f"{STUDY}/open_loop_fast_designed", report=False)
    back = designed.metrics["y_slowest.min"].to("mm/s").value
    assert -0.1 < softly < 0
    assert -0.1 < back < 0
    t_b = designed.composition.designs["braking"].values["t_b"]
    assert _speed_at_the_end(designed, t_b) == pytest.approx(0.0, abs=0.1)
    # shorter, it coasts on; much longer, it turns back
    shorter, longer = (
        run(
            load_scenario(
                f"{STUDY}/open_loop_fast_designed", [f"pulse.t_b={factor * t_b}"]
            ),
            report=False,
        )
        for factor in (0.98, 1.25)
    )
    assert _speed_at_the_end(shorter, 0.98 * t_b) > 0.5
    assert longer.metrics["y_slowest.min"].to("mm/s").value < -0.5


def _speed_at_the_end(done: Run, t_b: float) -> float:
    """Return the speed (mm/s) when the braking ends."""
    return 1e3 * float(done["y_axis.v"].values[round((0.25 + t_b) / T)])


def test_the_warmth_is_that_of_the_end() -> None:
    assert reached(np.array([0.0, 0.5, 0.9]), T) == {"state.warmth": 0.9}
