"""Groups that are iterated, against loops solved by hand."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest
from coupled import coupled
from systems import part, system

from orchestrator.errors import (
    FeedDriveError,
    ScenarioError,
    SimulationError,
    WiringError,
)
from orchestrator.master.ages import describe_schedule
from orchestrator.master.simulate import plan, simulate
from orchestrator.pictures.passing import passing
from orchestrator.scenario.compose import compose
from orchestrator.scenario.lock import locked
from orchestrator.scenario.reading import load_scenario
from orchestrator.system import Component, Fault, Isolation, Iterated, Kind, System

STEP, N = Fraction(1, 1000), 10
GAINS = {"a": (0.5, 1.0), "b": (-0.25, 2.0)}  # a loop that substitution solves
STEEP = {"a": (3.0, 1.0), "b": (-2.0, 2.0)}  # one that needs Newton

Files: TypeAlias = dict[int, Path]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    """The FMUs, by the version of FMI."""
    folder = tmp_path_factory.mktemp("coupled")
    return {fmi: coupled(fmi, folder / str(fmi)) for fmi in (2, 3)}


def loop(
    file: Path,
    gains: dict[str, tuple[float, float]] = GAINS,
    kind: Kind = "continuous",
    process: bool = False,
    **options: Any,
) -> System:
    """Two FMUs, each of which takes the output of the other."""
    parts = [
        Component(
            name,
            file,
            STEP,
            kind=kind,
            parameters={"a": a, "b": b},
            isolation=Isolation(process=process),
            **options,
        )
        for name, (a, b) in gains.items()
    ]
    rows = {f"{name}.{v}": str(STEP) for name in "ab" for v in "yn"}
    given = system(str(N * STEP), parts, {"a.u": "b.y", "b.u": "a.y"}, rows)
    return replace(given, groups={"both": Iterated(("a", "b"), 1e-12)})


def by_hand(gains: dict[str, tuple[float, float]], kind: str) -> np.ndarray:
    """Return y (2, N + 1) at all instants: y_i = a_i y_j + b_i + s_i, s_i' = h y_j."""
    (a, b), (c, d) = gains["a"], gains["b"]
    h, s, rows = float(STEP), np.zeros(2), []
    for k in range(N + 1):
        w = h if k or kind == "sampled" else 0.0  # of the step that ends here
        y = np.linalg.solve([[1.0, -(a + w)], [-(c + w), 1.0]], [b + s[0], d + s[1]])
        s += w * y[::-1]
        rows.append(y)
    return np.array(rows).T


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("kind", ["continuous", "sampled"])
@pytest.mark.parametrize("gains", [GAINS, STEEP])
def test_a_loop_has_at_every_instant_the_values_that_solve_it(
    fmi: int,
    kind: Kind,
    gains: dict[str, tuple[float, float]],
    files: Files,
    tmp_path: Path,
) -> None:
    found = simulate(loop(files[fmi], gains, kind), tmp_path / "run")
    assert found.timing.executor == "python"
    expected = by_hand(gains, kind)
    for name, row in zip("ab", expected, strict=True):
        np.testing.assert_allclose(found[f"{name}.y"].values, row, rtol=1e-9)
        begun = 1 if kind == "sampled" else 0
        counted = np.arange(N + 1) + begun  # as if no step had been repeated
        np.testing.assert_array_equal(found[f"{name}.n"].values, counted)


def test_a_group_in_processes_of_their_own_gives_the_same_bits(
    files: Files, tmp_path: Path
) -> None:
    file = files[3]
    here = simulate(loop(file, STEEP), tmp_path / "here")
    there = simulate(loop(file, STEEP, process=True), tmp_path / "there")
    for name, signal in here.items():
        np.testing.assert_array_equal(there[name].values, signal.values)


def test_our_own_fmus_are_iterated_too(tmp_path: Path) -> None:
    """y = x + g u of two integrators: an implicit step is a linear equation."""
    given = integrators(0.3)
    grouped = replace(given, groups={"both": Iterated(("a", "b"), 1e-13)})
    found = simulate(grouped, tmp_path / "run")
    again = simulate(given, tmp_path / "without")
    assert not np.array_equal(found["a.z"].values, again["a.z"].values)
    z = [found[f"{n}.z"].values for n in "ab"]
    x = [found[f"{n}.state.x"].values for n in "ab"]
    for one, other, state in ((0, 1, 0), (1, 0, 1)):
        np.testing.assert_allclose(
            np.diff(x[state]), 0.1 * z[other][1:], rtol=1e-9, atol=1e-12
        )
        assert one != other


def integrators(g: float) -> System:
    parts = [
        part(n, "integrator", "1/10", start={"state.x": 1.0}, parameters={"g": g})
        for n in "ab"
    ]
    rows = {f"{n}.{v}": "1/10" for n in "ab" for v in ("z", "state.x")}
    return system("1", parts, {"a.u": "b.z", "b.u": "a.z"}, rows)


def test_without_the_group_a_sampled_loop_is_refused(
    files: Files, tmp_path: Path
) -> None:
    given = replace(loop(files[2], kind="sampled"), groups={})
    with pytest.raises(WiringError, match=r"in a circle.*latency = 1, or put them"):
        simulate(given, tmp_path / "run")


def test_a_loop_without_a_solution_is_refused(files: Files, tmp_path: Path) -> None:
    one = 1 - float(STEP), 1.0  # y = a u + b at first, and (a + h) u + b in a step
    with pytest.raises(SimulationError) as refused:
        simulate(loop(files[2], {"a": one, "b": one}, "sampled"), tmp_path / "run")
    told = str(refused.value)
    assert "groups.both at t = 0 s: the loop of a.y -> b.u, b.y -> a.u has no" in told
    assert "give one of its sampled members latency = 1" in told


def test_the_schedule_says_what_is_iterated(files: Files, tmp_path: Path) -> None:
    told = describe_schedule(loop(files[2]))
    assert {age.remark for age in told.ages} == {
        "iterated until both ends agree (groups.both)"
    }
    assert [turn.steps for turn in told.turns] == [N, N]


def test_the_picture_shows_that_both_take_what_is_of_the_instant(files: Files) -> None:
    shown = passing(plan(loop(files[2], kind="sampled")))
    pairs = {(one.source, one.sink) for one in shown.taken}
    assert pairs == {("a", "b"), ("b", "a")}
    assert all(one.at == one.stems for one in shown.taken)
    assert {step.component for step in shown.steps} == {"a", "b"}


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"latency": 1, "kind": "sampled"}, "b has a latency, which cuts the loop"),
        ({"period": 2 * STEP}, "a and b differ|b and a differ"),
        ({"split": False}, "differ in split"),
    ],
)
def test_what_cannot_be_iterated_is_refused(
    changed: dict[str, Any], told: str, files: Files, tmp_path: Path
) -> None:
    kind = changed.get("kind", "continuous")
    given = loop(files[2], kind=kind)
    parts = {**given.components, "b": replace(given.components["b"], **changed)}
    with pytest.raises(FeedDriveError, match=told):
        simulate(replace(given, components=parts), tmp_path / "run")


@pytest.mark.parametrize(
    ("groups", "told"),
    [
        ({"x": Iterated(("a", "c"))}, "no component 'c'"),
        ({"x": Iterated(("a",))}, "there is nothing to iterate"),
        ({"x": Iterated(("a", "b")), "y": Iterated(("b",))}, "b is in groups.x"),
    ],
)
def test_a_group_names_components_that_form_a_loop(
    groups: dict[str, Iterated], told: str, files: Files, tmp_path: Path
) -> None:
    given = replace(loop(files[2]), groups=groups)
    with pytest.raises(WiringError, match=told):
        simulate(given, tmp_path / "run")


def test_members_need_states_and_no_faults_between_them(
    files: Files, tmp_path: Path
) -> None:
    without = loop(coupled(2, tmp_path / "without", states=False))
    with pytest.raises(WiringError, match=r"canGetAndSetFMUState is false"):
        simulate(without, tmp_path / "run")
    given = loop(files[2])
    faults = {"a.u": (Fault("bias", 1.0),)}
    with pytest.raises(WiringError, match="a fault or an injection acts"):
        simulate(replace(given, faults=faults), tmp_path / "run")


def test_a_scenario_says_its_groups_and_its_lock_repeats_them(
    files: Files, tmp_path: Path
) -> None:
    said = f"""
stop = "2/1000"
[components.a]
fmu = "{files[2]}"
step = "1/1000"
kind = "sampled"
parameters = {{ a = 0.5, b = 1.0 }}
[components.b]
fmu = "{files[2]}"
step = "1/1000"
kind = "sampled"
[connections]
"a.u" = "b.y"
"b.u" = "a.y"
[groups.both]
components = ["a", "b"]
iterate = true
tolerance = 1e-6
[record]
"a.y" = "1/1000"
"""
    (tmp_path / "s.toml").write_text(said)
    composition = compose(load_scenario(tmp_path / "s.toml"), None)
    assert composition.system.groups == {"both": Iterated(("a", "b"), 1e-6)}
    assert locked(composition)["groups"] == {
        "both": {"components": ["a", "b"], "iterate": True, "tolerance": 1e-6}
    }
    off = load_scenario(tmp_path / "s.toml", ["groups.both.iterate=false"])
    assert not compose(off, None).system.groups
    with pytest.raises(ScenarioError, match="did you mean 'both'"):
        load_scenario(tmp_path / "s.toml", ["groups.bath.iterate=false"])
