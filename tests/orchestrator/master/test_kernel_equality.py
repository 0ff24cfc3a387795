"""Both executors record the same bits and fail with the same words."""

from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st
from systems import part

from orchestrator.errors import SimulationError, WiringError
from orchestrator.master.simulate import Choice, plan, simulate
from orchestrator.result import Result
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import compose, run_earlier
from orchestrator.system import Component, Mapped, System

PERIODS = ["1/1000", "1/1500", "1/400"]
TICK = Fraction(1, 6000)
OUTPUTS = {
    "counter": {"1": ["k", "seen"], "1/s": ["rate"]},
    "memory": {"1": ["y"], "1/s": []},
    "integrator": {"1": ["y"], "1/s": ["z"]},
}
UNIT = {"counter": "1", "memory": "1", "integrator": "1/s"}


@cache
def fmu(model: str, period: str, fmi: int) -> Path:
    return part("c", model, period, fmi=fmi).fmu


gains = st.sampled_from([1.0, -1.0, 0.3, 1e-3])
offsets = st.sampled_from([0.0, 0.1])


@st.composite
def components(draw: st.DrawFn, name: str) -> tuple[str, Component]:
    model = draw(st.sampled_from(list(OUTPUTS)))
    period = draw(st.sampled_from(PERIODS))
    file = fmu(model, period, draw(st.sampled_from([2, 3])))
    mapped = Mapped("u", draw(gains), draw(offsets))
    later = draw(st.integers(0, 3)) * TICK
    latency = 0 if model == "integrator" else draw(st.integers(0, 2))
    component = Component(
        name, file, Fraction(period), later, latency, map={"u": mapped}
    )
    return model, component


@st.composite
def systems(draw: st.DrawFn) -> System:
    made = [draw(components(name)) for name in "abcde"[: draw(st.integers(1, 5))]]
    connections, record = {}, {}
    for model, component in made:
        sources = [
            f"{source.name}.{output}"
            for other, source in made
            for output in OUTPUTS[other][UNIT[model]]
        ]
        if sources and draw(st.booleans()):
            connections[f"{component.name}.u"] = draw(st.sampled_from(sources))
        for outputs in OUTPUTS[model].values():
            for output in outputs:
                row = Fraction(draw(st.sampled_from([*PERIODS, "1/6000"])))
                record[f"{component.name}.{output}"] = row
    stop = draw(st.integers(0, 400)) * TICK
    return System("random", stop, {c.name: c for _, c in made}, connections, record)


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
    max_examples=200,
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


STUDIES = Path(__file__).parents[3] / "orchestrator" / "studies"
SCENARIOS = sorted(
    f"{file.parent.name}/{file.stem}"
    for file in STUDIES.glob("*/*.toml")
    if file.stem != "reference" and not file.stem.startswith("_")
)


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


def row(system: System) -> Fraction:
    """Return a period after which every component can stop."""
    return max(c.period for c in system.components.values())
