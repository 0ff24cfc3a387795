"""What a scenario alone cannot say: one FMU in the hand, and runs compared."""

from pathlib import Path

import pytest

from orchestrator.pytest_plugin import assert_fmu_conforms

MODELS = Path(__file__).parents[1] / "models"


def test_the_controller_fmu_keeps_to_the_standard(build_fmu):
    assert_fmu_conforms(build_fmu(MODELS / "speed_pi.py"))


def test_the_integral_part_grows_with_the_error(build_fmu, load_fmu):
    controller = load_fmu(build_fmu(MODELS / "speed_pi.py"), values={"K_i": 40.0})
    controller["omega_r"] = 10.0
    controller.step()
    assert controller["i"] == pytest.approx(15.0)
    controller.step()
    assert controller["i"] == pytest.approx(15.0 + 40 * 10 / 4000)


def test_a_second_sample_of_delay_raises_the_overshoot(run_scenario):
    one = run_scenario("speed_step.toml")
    two = run_scenario("speed_step.toml", "controller.latency=2")
    assert two.metrics["speed.overshoot"].value > one.metrics["speed.overshoot"].value


def test_the_speed_signal_reaches_the_controller_in_its_own_unit(compose_scenario):
    system = compose_scenario("speed_step.toml").system
    assert system.connections["controller.omega"] == "motor.omega"
