"""FMUs for model exchange only run like those for co-simulation, events included."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from broken import ball, pack, without_co_simulation
from numpy.typing import NDArray
from systems import part, system

from orchestrator.master.simulate import Choice, simulate
from orchestrator.master.stepper import Stepper
from orchestrator.system import Component, Isolation, Mapped

G, E = 9.81, 0.7


def flight(
    times: NDArray[np.float64], kick: float, t_kick: float
) -> NDArray[np.float64]:
    """Return height, speed and bounces, by solving for each event."""
    t, h, v, bounces, kicked = 0.0, 1.0, 0.0, 0, False
    rows = []
    for end in times:
        while True:
            floor = t + (v + np.sqrt(v * v + 2 * G * h)) / G
            event = min(floor, np.inf if kicked else t_kick)
            dt = min(end, event) - t
            h, v = h + v * dt - G * dt * dt / 2, v - G * dt
            t += dt
            if event > end:
                break
            if event == floor:
                h, v, bounces = 0.0, -E * v, bounces + 1
            else:
                v, kicked = v + kick, True
        rows.append((h, v, bounces))
    return np.array(rows).T


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("executor", ["kernel", "python"])
@pytest.mark.parametrize("apart", [False, True])
def test_state_and_time_events_happen_when_they_are_due(
    tmp_path: Path, fmi: int, executor: Choice, apart: bool
) -> None:
    fmu = pack("ball", ball(fmi), tmp_path, fmi)
    component = Component(
        "ball",
        fmu,
        Fraction("1/100"),
        parameters={"kick": 2.0, "t_kick": 0.3337},
        isolation=Isolation(process=apart),
    )
    rows = {f"ball.{name}": "1/100" for name in ("h", "v", "bounces")}
    result = simulate(system("3/2", [component], {}, rows), tmp_path, executor=executor)
    expected = flight(result["ball.h"].time, 2.0, 0.3337)
    assert expected[2, -1] == 3
    found = np.array([result[name].values for name in rows])
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_a_time_event_at_a_communication_point_is_in_its_row(tmp_path: Path) -> None:
    with Stepper(pack("ball", ball(2), tmp_path), {"kick": 2.0, "t_kick": 0.25}) as fmu:
        for _ in range(2):
            fmu.step("1/8")
        assert fmu["v"] == pytest.approx(2 - G * 0.25, abs=1e-9)


@pytest.mark.parametrize("fmi", [2, 3])
def test_model_exchange_gives_the_trajectory_of_co_simulation(
    tmp_path: Path, fmi: int
) -> None:
    plant = part("plant", "plants.ball_screw.two_mass", "1/2000", fmi=fmi)
    exchanged = replace(
        plant, name="theirs", fmu=without_co_simulation(plant.fmu, tmp_path)
    )
    volt = {"volt": Mapped("k", 0.01, unit="V")}
    source = part("source", "counter", "1/1000", map=volt)
    wires = {f"{name}.u": "source.volt" for name in ("plant", "theirs")}
    rows = {f"{n}.{x}": "1/2000" for n in ("plant", "theirs") for x in ("x_1", "x_2")}
    parts = [plant, exchanged, source]
    result = simulate(system("1/10", parts, wires, rows), tmp_path)
    for x in ("x_1", "x_2"):
        ours, theirs = (np.array(result[f"{n}.{x}"]) for n in ("plant", "theirs"))
        assert np.max(np.abs(ours)) > 1e-3
        np.testing.assert_allclose(theirs, ours, atol=1e-6 * np.max(np.abs(ours)))
