"""The fused loop and every lane of it record the bits of the other executors."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from random_systems import SCENARIOS, row, systems

from fmus.build import build
from orchestrator.errors import SimulationError, WiringError
from orchestrator.master.fused.lanes import Lanes
from orchestrator.master.simulate import plan, simulate
from orchestrator.result import Result, Signal
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier
from orchestrator.system import Component, System

LATE = Path(__file__).parents[2] / "fmus" / "small_models" / "late.py"
MAIN = {  # a scenario of each study, what its members differ in, by how much
    "ball_screw_pole_placement/mc_ppc_track_500": ("plant", "m_2", 0.379e-3),
    "cascade_nppi/np_pi_0_7hz": ("controller", "k_p", 0.006607),
    "gantry/mimo_line_200": ("y_plant", "m", 2.722),
    "leadscrew_nctf/step": ("x_axis", "M", 17.5),
}


def assert_same(one: Result, other: Result) -> None:
    assert list(one) == list(other)
    for name in one:
        assert_same_signal(one[name], other[name])


def assert_same_signal(one: Signal, other: Signal) -> None:
    for a, b in ((one.time, other.time), (one.values, other.values)):
        np.testing.assert_array_equal(a.view(np.int64), b.view(np.int64))


def assert_fused_equals_kernel(system: System, folder: Path) -> None:
    results = []
    for executor in ("kernel", "fused"):
        place = folder / executor
        try:
            results.append(simulate(system, place, executor=executor))
        except SimulationError:
            results.append(Result(place))
    assert_same(*results)


def shortened(name: str, rows: int, fmi: int = 2) -> System:
    scenario = load_scenario(name, [f"fmi={fmi}"])
    system = compose(scenario, run_earlier).system
    return replace(system, stop=min(system.stop, rows * row(system)))


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_is_the_same_fused(
    name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """One of each study at once; all of them in both forms with --every-form."""
    whole = request.config.getoption("--every-form")
    if not whole and name not in MAIN:
        pytest.skip("--every-form fuses every scenario")
    for fmi in (2, 3) if whole else (2,):
        assert_fused_equals_kernel(
            shortened(name, 10**9 if whole else 500, fmi), tmp_path / str(fmi)
        )


@given(systems())
def _random(folders: pytest.TempPathFactory, system: System) -> None:
    try:
        plan(system)
    except WiringError:
        assume(False)
    assert_fused_equals_kernel(system, folders.mktemp("random"))


def test_random_systems_are_the_same_fused(
    tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> None:
    every = request.config.getoption("--every-form")
    settings(
        max_examples=200 if every else 12,
        deadline=None,
        derandomize=True,
        suppress_health_check=list(HealthCheck),
    )(_random)(tmp_path_factory)


@pytest.mark.parametrize("name", MAIN)
def test_every_lane_is_a_run_of_its_own(
    name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    component, parameter, nominal = MAIN[name]
    whole = request.config.getoption("--every-form")
    count = 100 if whole else 5
    system = shortened(name, 10**9 if whole else 400)
    random = np.random.default_rng(7)
    values = [nominal * f for f in random.uniform(0.8, 1.2, count)]
    signals = frozenset(system.record)
    lanes = Lanes(plan(system), signals, 8)
    members = list(lanes.run([{component: {parameter: v}} for v in values]))
    assert len(members) == count
    for value, member in zip(values, members, strict=True):
        assert member.failure is None
        part = system.components[component]
        given = {**part.parameters, parameter: value}
        changed = {**system.components, component: replace(part, parameters=given)}
        alone = simulate(replace(system, components=changed), tmp_path / repr(value))
        assert set(member.signals) == set(alone)
        for signal in alone:
            assert_same_signal(member.signals[signal], alone[signal])


def test_a_lane_that_fails_is_named_and_the_others_go_on(tmp_path: Path) -> None:
    name = "ball_screw_pole_placement/mc_ppc_track_500"
    system = replace(shortened(name, 3000), stop=Fraction(1, 5))
    signals = frozenset(["plant.x_2"])
    gains = [210.02, 1e9, 210.02]  # at the second RK4 is not stable
    lanes = Lanes(plan(system), signals, 8)
    first, second, third = lanes.run([{"plant": {"k": k}} for k in gains])
    assert "plant" in str(second.failure)
    assert "finite values were expected" in str(second.failure)
    alone = simulate(system, tmp_path)
    for member in (first, third):
        assert_same_signal(member.signals["plant.x_2"], alone["plant.x_2"])


def test_members_out_of_bounds_are_named_without_touching_others() -> None:
    system = shortened("ball_screw_pole_placement/mc_ppc_track_500", 50)
    lanes = Lanes(plan(system), frozenset(["plant.x_2"]), 8)
    good, bad, last = lanes.run([{"plant": {"m_2": m}} for m in (3e-4, -1.0, 4e-4)])
    assert "the FMU allows at least" in str(bad.failure)
    assert good.failure is None
    assert last.failure is None


def test_a_negative_dead_time_without_a_bound_is_refused_in_a_lane(
    tmp_path: Path,
) -> None:
    unbounded = LATE.read_text().replace('"dead time", min=0', '"dead time"')
    (tmp_path / "unbounded.py").write_text(unbounded)
    file = build(str(tmp_path / "unbounded.py"))
    late = Component("late", file, Fraction(1, 1000), start={"u": 1.0})
    rows = {"late.y": (Fraction(1, 1000),)}
    lanes = Lanes(
        plan(System("t", Fraction(1, 100), {"late": late}, {}, rows)),
        frozenset(rows),
        4,
    )
    good, bad = lanes.run([{"late": {"tau": tau}} for tau in (1e-3, -1e-3)])
    assert good.failure is None
    assert "cannot be negative" in str(bad.failure)
