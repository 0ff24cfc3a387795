"""Both executors record the same bits and fail with the same words."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from effort import EFFORT
from hypothesis import HealthCheck, assume, event, given, settings
from random_systems import SCENARIOS, row, systems

from orchestrator.errors import SimulationError, WiringError
from orchestrator.master.simulate import Choice, plan, simulate
from orchestrator.result import Result
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import compose, run_earlier
from orchestrator.system import System


def outcome(
    system: System, executor: Choice, folder: Path
) -> tuple[Result, str | None]:
    try:
        return simulate(system, folder / executor, executor=executor), None
    except SimulationError as error:
        return Result(folder / executor), str(error)


def assert_equal(system: System, folder: Path) -> None:
    python, error = outcome(system, "python", folder)
    native, same_error = outcome(system, "kernel", folder)
    assert error == same_error
    assert list(python) == list(native)
    for name in python:
        for first, second in (
            (python[name].time, native[name].time),
            (python[name].values, native[name].values),
        ):
            np.testing.assert_array_equal(first.view(np.int64), second.view(np.int64))


@settings(
    max_examples=EFFORT.sample(200, 60),
    deadline=None,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
)
@given(systems())
def test_random_systems_give_the_same_bits(
    tmp_path_factory: pytest.TempPathFactory, system: System
) -> None:
    try:
        timetable = plan(system)
    except WiringError:
        assume(False)
    event(f"repeats: {timetable.schedule.is_stored()}")
    event(f"latencies: {any(c.latency for c in system.components.values())}")
    event(f"connections: {len(system.connections)}")
    assert_equal(system, tmp_path_factory.mktemp("random"))


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_gives_the_same_bits(
    name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """Its first moves in one form; with --every-form both forms to the end."""
    whole = request.config.getoption("--every-form")
    for fmi in (2, 3) if whole else (2 + SCENARIOS.index(name) % 2,):
        system = compose(load_scenario(name, [f"fmi={fmi}"]), run_earlier).system
        if not whole:
            system = replace(system, stop=min(system.stop, 500 * row(system)))
        assert_equal(system, tmp_path)
