"""A fault on a connection acts when its window says, on what the input receives."""

import re
import tomllib
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from systems import MODELS, part, system

from orchestrator.errors import ScenarioError, WiringError
from orchestrator.master.ages import describe_schedule
from orchestrator.master.simulate import simulate
from orchestrator.result import Result
from orchestrator.scenario.compose import compose
from orchestrator.scenario.lock import LOCK
from orchestrator.scenario.reading import load_scenario, read_scenario, scenario_from
from orchestrator.session import run, run_earlier
from orchestrator.system import Fault, Mapped, System

Simulate = Callable[..., Result]
MS = Fraction(1, 1000)


@pytest.fixture(params=["python", "kernel"])
def run_it(request: pytest.FixtureRequest, tmp_path: Path) -> Simulate:
    """Run a system with one of the executors."""
    return lambda system: simulate(system, tmp_path, executor=request.param)


def faulty(given: System, **faults: Fault | tuple[Fault, ...]) -> System:
    """Return a system with faults on ``component__input``."""
    chains = {
        name.replace("__", "."): fault if isinstance(fault, tuple) else (fault,)
        for name, fault in faults.items()
    }
    fields = {k: v for k, v in vars(given).items() if k != "faults"}
    return System(**fields, faults=chains)


def counters(latency: int = 0, period: str = "1/1000", **options: Any) -> System:
    """A counter at 1 kHz (0, 1, 2, ... at 0, 1, 2 ms) read by another."""
    parts = [
        part("a", "counter", "1/1000", latency=latency),
        part("b", "counter", period, **options),
    ]
    return system("1/50", parts, {"b.u": "a.k"}, {"b.seen": period, "b.u": period})


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        (Fault("bias", 0.5), lambda k: k + 0.5),
        (Fault("gain", -2.0), lambda k: -2.0 * k),
        (Fault("override", 7.0), lambda k: 7.0 + 0 * k),
        (Fault("quantisation", 4.0), lambda k: 4.0 * np.floor(k / 4 + 0.5)),
        (Fault("delay", samples=3), lambda k: np.maximum(k - 3, 0)),
        (Fault("stuck"), lambda k: 0.0 * k),
    ],
)
@pytest.mark.parametrize("latency", [0, 2])
def test_a_fault_changes_what_the_input_receives_and_only_in_its_window(
    run_it: Simulate, fault: Fault, expected: Callable[[Any], Any], latency: int
) -> None:
    published = np.maximum(np.arange(21.0) - latency, 0)
    always = run_it(faulty(counters(latency), b__u=fault))
    np.testing.assert_array_equal(always["b.seen"].values, expected(published))
    windowed = Fault(fault.kind, fault.value, fault.samples, 5 * MS, 9 * MS)
    result = run_it(faulty(counters(latency), b__u=windowed))
    inside = np.isin(np.arange(21), [5, 6, 7, 8])
    wrong = expected(published)
    if fault.kind == "stuck":
        wrong = published[4] + 0 * published  # the value before the window
    np.testing.assert_array_equal(
        result["b.seen"].values, np.where(inside, wrong, published)
    )
    np.testing.assert_array_equal(result["b.u"].values, result["b.seen"].values)


def test_a_window_between_all_ticks_splits_the_step_of_a_plant(
    run_it: Simulate,
) -> None:
    """u = 0, 1, 2, 3 /s in the milliseconds 0 to 3, and 10 /s from 1/3 to 4/3 ms."""
    parts = [part("source", "counter", "1/1000"), part("plant", "integrator", "1/250")]
    wired = system("1/250", parts, {"plant.u": "source.rate"}, {"plant.y": "1/250"})
    window = Fault("override", 10.0, start=MS / 3, end=4 * MS / 3)
    result = run_it(faulty(wired, plant__u=window))
    clean = (0 + 1 + 2 + 3) * 1e-3
    expected = clean + 10e-3 - (1 / 3) * 1e-3  # instead of 0 for 2/3, 1 for 1/3 ms
    assert result["plant.y"].values[-1] == pytest.approx(expected, rel=1e-13)


def test_a_window_between_the_ticks_of_a_reader_is_not_seen(run_it: Simulate) -> None:
    missed = Fault("override", 99.0, start=MS / 3, end=2 * MS / 3)
    caught = Fault("override", 99.0, start=MS / 3, end=MS + MS / 10**6)
    clean = run_it(counters())["b.seen"].values
    result = run_it(faulty(counters(), b__u=missed))
    np.testing.assert_array_equal(result["b.seen"].values[:21], clean)
    seen = run_it(faulty(counters(), b__u=caught))["b.seen"]
    assert seen.values.tolist() == [0, 99, *range(2, 21)]


@pytest.mark.parametrize("period", ["1/400", "1/2500"])
def test_a_fault_counts_the_samples_of_the_source_at_mixed_rates(
    run_it: Simulate, period: str
) -> None:
    result = run_it(faulty(counters(period=period), b__u=Fault("delay", samples=2)))
    seen = result["b.seen"]
    ticks = np.arange(len(seen)) * Fraction(period)
    expected = [max(int(t / MS) - 2, 0) for t in ticks]
    assert seen.values[: len(ticks)].tolist() == expected


def test_a_delay_fault_on_a_plant_signal_counts_its_exchanges(
    run_it: Simulate,
) -> None:
    parts = [
        part("plant", "integrator", "1/1000", start={"u": 1000.0}),
        part("reader", "counter", "1/1000"),
    ]
    wired = system("1/100", parts, {"reader.u": "plant.y"}, {"reader.seen": "1/1000"})
    result = run_it(faulty(wired, reader__u=Fault("delay", samples=2)))
    expected = np.maximum(np.arange(11) - 2, 0)
    np.testing.assert_allclose(result["reader.seen"].values, expected, atol=1e-12)


def test_several_faults_of_one_input_act_in_order(run_it: Simulate) -> None:
    chain = (Fault("bias", 1.0), Fault("gain", 3.0), Fault("delay", samples=1))
    result = run_it(faulty(counters(), b__u=chain))
    assert result["b.seen"].values.tolist()[:4] == [3, 3, 6, 9]  # from 0 at first


def test_a_fault_is_told_in_our_units_where_the_input_is_mapped(
    run_it: Simulate,
) -> None:
    mapped = counters(map={"w": Mapped("u", gain=-1000.0, offset=2.0)})
    wired = System(
        **{**vars(mapped), "connections": {"b.w": "a.k"}, "record": {"b.seen": (MS,)}}
    )
    result = run_it(faulty(wired, b__w=Fault("bias", 0.5)))
    expected = -1000.0 * (np.arange(21) + 0.5) + 2.0
    np.testing.assert_allclose(result["b.seen"].values, expected, rtol=1e-12)


def test_other_inputs_of_the_same_source_stay_clean(run_it: Simulate) -> None:
    parts = [part(n, "counter", "1/1000") for n in "abc"]
    rows = {"b.seen": "1/1000", "c.seen": "1/1000"}
    wired = system("1/100", parts, {"b.u": "a.k", "c.u": "a.k"}, rows)
    result = run_it(faulty(wired, b__u=Fault("gain", 0.0)))
    assert result["b.seen"].values.tolist() == [0] * 11
    assert result["c.seen"].values.tolist() == list(range(11))


PERIODS = ["1/1000", "1/700", "3/1000", "1/1500"]
FAULTS = st.builds(
    lambda kind, value, samples, start, length: Fault(
        kind, value, samples, Fraction(start, 3000), Fraction(start + length, 3000)
    ),
    st.sampled_from(["stuck", "bias", "gain", "delay", "quantisation", "override"]),
    st.sampled_from([0.25, 1.5, 3.0]),
    st.integers(1, 4),
    st.integers(0, 60),
    st.integers(1, 40),
)


@settings(
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    periods=st.tuples(*[st.sampled_from(PERIODS)] * 3),
    latency=st.integers(0, 2),
    faults=st.lists(FAULTS, min_size=1, max_size=3),
)
def test_both_executors_give_the_same_bits(
    tmp_path: Path, periods: tuple[str, ...], latency: int, faults: list[Fault]
) -> None:
    parts = [
        part("a", "counter", periods[0], latency=latency),
        part("p", "integrator", periods[1]),
        part("b", "counter", periods[2]),
    ]
    wires = {"p.u": "a.rate", "b.u": "p.y"}
    wired = system("3/100", parts, wires, {n: "1/3000" for n in ("p.y", "b.seen")})
    changed = faulty(wired, p__u=tuple(faults), b__u=tuple(faults[:1]))
    results = [
        simulate(changed, tmp_path / executor, executor=executor)
        for executor in ("python", "kernel")
    ]
    for name in wired.record:
        one, other = (result[name] for result in results)
        np.testing.assert_array_equal(one.time, other.time)
        np.testing.assert_array_equal(one.values, other.values)


def test_the_schedule_lists_faults_with_their_windows() -> None:
    chain = (Fault("stuck", start=5 * MS, end=9 * MS), Fault("delay", samples=2))
    plan = describe_schedule(faulty(counters(), b__u=chain))
    (age,) = plan.ages
    assert "fault: stuck from 0.005 s to 0.009 s" in age.remark
    assert "fault: delay of 2 samples throughout" in age.remark
    assert plan.hyperperiod == MS


def scenario(**faults: Any) -> Any:
    counter = {"fmu": str(MODELS / "counter.py"), "step": "1/1000"}
    tables = {
        "stop": "1/100",
        "components": {"a": dict(counter), "b": dict(counter)},
        "connections": {"b.u": "a.k"},
        "record": {"b.seen": True},
        "faults": faults.get("faults", faults),
    }
    return scenario_from(tables, Path("faulty.toml"))


def test_a_scenario_says_its_faults() -> None:
    bias = {"kind": "bias", "value": 0.5, "window": ["2 ms", "1/250"]}
    spec = scenario(faults={"b.u": [bias, {"kind": "stuck"}]})
    assert compose(spec, run_earlier).system.faults == {
        "b.u": (
            Fault("bias", 0.5, start=2 * MS, end=4 * MS),
            Fault("stuck"),
        )
    }


@pytest.mark.parametrize(
    ("fault", "complaint"),
    [
        ({"kind": "bias"}, "needs its value"),
        ({"kind": "delay", "value": 2.0, "samples": 1}, "takes no value"),
        ({"kind": "delay"}, "needs its samples"),
        ({"kind": "quantisation", "value": 0.0}, "greater than zero"),
        ({"kind": "bias", "value": 1.0, "window": ["-1", "1"]}, "before the start"),
        ({"kind": "noise"}, "kind"),
        ({"kind": "stuck", "windw": ["0", "1"]}, "did you mean 'window'"),
    ],
)
def test_a_fault_that_says_nothing_clear_is_refused(
    fault: dict[str, Any], complaint: str
) -> None:
    with pytest.raises(ScenarioError, match=complaint):
        scenario(faults={"b.u": fault})


def test_a_fault_where_no_connection_leads_is_refused() -> None:
    with pytest.raises(WiringError, match=r"no connection leads to b\.k.*'b\.u'"):
        describe_schedule(faulty(counters(), b__k=Fault("stuck")))


def test_a_stuck_encoder_is_told_from_the_command_line_of_a_base(
    tmp_path: Path,
) -> None:
    file = tmp_path / "stuck.toml"
    file.write_text(
        f'stop = "1/100"\n[components.a]\nfmu = "{MODELS / "counter.py"}"\n'
        f'[components.b]\nfmu = "{MODELS / "counter.py"}"\n'
        '[connections]\n"b.u" = "a.k"\n[record]\n"b.seen" = true\n'
        '[faults]\n"b.u" = { kind = "bias", value = 1.0 }\n'
    )
    (tmp_path / "clean.toml").write_text('base = "stuck.toml"\nfaults."b.u" = false\n')
    assert load_scenario(tmp_path / "clean.toml").spec.faults == {}
    changed = load_scenario(file, ["faults.b.u.value=2.5"]).spec.faults["b.u"]
    assert [fault.value for fault in changed] == [2.5]
    assert load_scenario(file, ["faults.b.u=false"]).spec.faults == {}
    with pytest.raises(ScenarioError, match="there is no fault"):
        load_scenario(file, ["faults.b.w.value=2.5"])


def test_the_faults_of_the_docs_can_be_run(tmp_path: Path) -> None:
    docs = (Path(__file__).parents[3] / "docs" / "scenarios.md").read_text()
    (written,) = re.findall(r"```toml\n(\[faults\]\n.*?)```", docs, re.DOTALL)
    file = load_scenario("ball_screw_pole_placement/mc_ppc_track_500").file
    raw = read_scenario(file) | tomllib.loads(written)
    faults = compose(scenario_from(raw, file), run_earlier).system.faults
    assert [len(chain) for chain in faults.values()] == [1, 2]


def test_a_lock_file_repeats_the_faults(tmp_path: Path) -> None:
    """An encoder that sticks for half a millisecond, and the same run again."""
    name = "ball_screw_pole_placement/mc_ppc_track_500"
    sticks = {"encoder.x_2": {"kind": "stuck", "window": ["0.03", "0.0305"]}}
    file = load_scenario(name).file
    raw = read_scenario(file) | {"stop": "1/20", "faults": sticks}
    first = run(scenario_from(raw, file), tmp_path / "first")
    again = run(load_scenario(first.folder / LOCK), tmp_path / "again")
    assert again.metrics == first.metrics
    np.testing.assert_array_equal(again["plant.x_2"], first["plant.x_2"])
    clean = run(load_scenario(name, ["stop=1/20"]), tmp_path / "clean")["encoder.y_2"]
    wrong = clean.time[first["encoder.y_2"].values != clean.values]
    assert wrong[0] == 0.03
    assert wrong[-1] > 0.0305  # the controller was led astray
    assert "stuck from 0.03 s" in (first.folder / "report.html").read_text()
