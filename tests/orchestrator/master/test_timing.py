"""FMUs tick when the contract says, see exact times and the right inputs."""

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from systems import part, system

from orchestrator.errors import ScheduleError, WiringError
from orchestrator.master.ages import describe_schedule
from orchestrator.result import Result
from orchestrator.system import System

Run = Callable[[System], Result]


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    "periods", [("1/8000", "1/5000"), ("1/20000", "1/15000", "1/3000")]
)
def test_components_without_a_common_rate_tick_exactly(
    run: Run, fmi: int, periods: tuple[str, ...]
) -> None:
    names = [f"c{i}" for i in range(len(periods))]
    parts = [
        part(n, "counter", p, fmi=fmi) for n, p in zip(names, periods, strict=True)
    ]
    rows = {f"{n}.{v}": p for n, p in zip(names, periods, strict=True) for v in "kt"}
    result = run(system("1", parts, record=rows))
    for name, period in zip(names, periods, strict=True):
        ticks = result[f"{name}.k"]
        count = 1 // Fraction(period) + 1
        np.testing.assert_array_equal(ticks.values[:count], np.arange(count))
        exact = [float(k * Fraction(period)) for k in range(count)]
        np.testing.assert_array_equal(ticks.time[:count], exact)
        np.testing.assert_allclose(result[f"{name}.t"].values, ticks.time, rtol=3e-16)


def test_rows_cover_the_closed_interval_and_end_at_the_stop(run: Run) -> None:
    result = run(
        system("0.00125", [part("c", "counter", "1/1000")], record={"c.k": "1/2000"})
    )
    assert result["c.k"].time.tolist() == [0, 0.0005, 0.001, 0.00125]
    assert result["c.k"].values.tolist() == [0, 0, 1, 1]


def test_an_offset_shifts_the_first_tick(run: Run) -> None:
    c = part("c", "counter", "1/1000", offset="1/4000")
    result = run(system("3/1000", [c], record={"c.k": "1/4000"}))
    expected = [0, *([0] * 4), *([1] * 4), *([2] * 4)]
    assert result["c.k"].values.tolist() == expected


@pytest.mark.parametrize("latency", [0, 1, 3])
def test_latency_publishes_what_was_computed_so_many_ticks_before(
    run: Run, latency: int
) -> None:
    parts = [
        part("source", "counter", "1/1000", latency=latency),
        part("reader", "counter", "1/1000"),
    ]
    result = run(
        system(
            "1/100",
            parts,
            {"reader.u": "source.k"},
            {"source.k": "1/1000", "reader.seen": "1/1000"},
        )
    )
    expected = [max(k - latency, 0) for k in range(11)]
    assert result["source.k"].values.tolist() == expected
    assert result["reader.seen"].values.tolist() == expected


def test_a_chain_acts_within_one_instant_whatever_the_order_of_writing(
    run: Run,
) -> None:
    parts = [part(n, "counter", "1/1000") for n in ("last", "middle", "first")]
    wires = {"middle.u": "first.k", "last.u": "middle.seen"}
    result = run(system("1/100", parts, wires, {"last.seen": "1/1000"}))
    assert result["last.seen"].values.tolist() == list(range(11))


def test_a_slow_reader_takes_the_newest_value_and_holds_it(run: Run) -> None:
    parts = [part("fast", "counter", "1/1000"), part("slow", "counter", "1/400")]
    result = run(system("1/100", parts, {"slow.u": "fast.k"}, {"slow.seen": "1/2000"}))
    seen = dict(zip(result["slow.seen"].time, result["slow.seen"].values, strict=True))
    assert seen[0.0025] == 2
    assert seen[0.0045] == 2
    assert seen[0.005] == 5


def test_a_continuous_step_is_split_where_its_source_publishes(run: Run) -> None:
    parts = [part("source", "counter", "1/1000"), part("plant", "integrator", "1/250")]
    result = run(
        system("1/125", parts, {"plant.u": "source.rate"}, {"plant.y": "1/250"})
    )
    whole = [sum(range(n)) * 1e-3 for n in (0, 4, 8)]
    np.testing.assert_allclose(result["plant.y"].values, whole, rtol=1e-14)


def test_coupled_continuous_components_exchange_held_values(run: Run) -> None:
    parts = [
        part("a", "integrator", "1/10", start={"state.x": 1.0}),
        part("b", "integrator", "1/10", start={"state.x": 1.0}),
    ]
    wires = {"a.u": "b.z", "b.u": "a.z"}
    result = run(system("3/10", parts, wires, {"a.y": "1/10", "b.y": "1/10"}))
    np.testing.assert_allclose(result["a.y"].values, 1.1 ** np.arange(4), rtol=1e-14)


def test_a_circle_at_initialisation_is_solved(run: Run) -> None:
    """z_a = 1 + g z_b and z_b = 1 + g z_a: with g = 2 only Newton finds z = -1."""
    parts = [
        part(n, "integrator", "1/10", start={"state.x": 1.0}, parameters={"g": 2.0})
        for n in "ab"
    ]
    wires = {"a.u": "b.z", "b.u": "a.z"}
    result = run(system("0", parts, wires, {"a.z": "1/10"}))
    np.testing.assert_allclose(result["a.z"].values, -1.0, rtol=1e-12)


def test_a_feed_through_circle_of_sampled_components_is_refused(run: Run) -> None:
    parts = [part(n, "counter", "1/1000") for n in "ab"]
    wires = {"a.u": "b.seen", "b.u": "a.seen"}
    with pytest.raises(WiringError, match=r"circle.*latency = 1"):
        run(system("1/100", parts, wires))
    delayed = [parts[0], part("b", "counter", "1/1000", latency=1)]
    run(system("1/100", delayed, wires, {"a.seen": "1/1000"}))


def test_an_input_that_feeds_nothing_through_opens_a_circle_and_is_listed(
    run: Run,
) -> None:
    parts = [part("a", "counter", "1/1000"), part("b", "memory", "1/1000")]
    circle = system("1/100", parts, {"a.u": "b.y", "b.u": "a.k"}, {"a.seen": "1/1000"})
    ages = {age.sink: age for age in describe_schedule(circle).ages}
    assert ages["a.u"].oldest == 0
    assert ages["b.u"].youngest == ages["b.u"].oldest == Fraction(1, 1000)
    assert "waits" in ages["b.u"].remark
    seen = run(circle)["a.seen"].values
    assert seen.tolist() == [0, 0, *range(0, 9)]


def test_the_schedule_lists_latency_and_the_ages_of_a_rate_change() -> None:
    parts = [
        part("fast", "counter", "1/3000", latency=1),
        part("slow", "counter", "1/2000"),
    ]
    plan = describe_schedule(system("1", parts, {"slow.u": "fast.k"}))
    (age,) = plan.ages
    assert plan.tick == Fraction(1, 6000)
    assert plan.hyperperiod == Fraction(1, 1000)
    assert (age.youngest, age.oldest) == (Fraction(1, 3000), Fraction(3, 6000))
    assert [turn.steps for turn in plan.turns] == [3001, 2001]


def test_a_sample_time_other_than_the_built_one_is_refused(run: Run) -> None:
    fitting = part("c", "counter", "1/1000")
    other = type(fitting)("c", fitting.fmu, Fraction(1, 500))
    with pytest.raises(ScheduleError, match="--period 1/500"):
        run(system("1", [other]))
