"""Instants are exact, complete and the same whichever way they are produced."""

from collections import Counter
from fractions import Fraction

import pytest
from effort import EFFORT
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.errors import ScheduleError
from orchestrator.master.schedule import Clock, Schedule, rational_gcd

small = st.fractions(min_value=Fraction(1, 9), max_value=9, max_denominator=9)
times = st.one_of(
    st.just(Fraction(0)), st.fractions(min_value=0, max_value=5, max_denominator=9)
)
clocks = st.dictionaries(
    st.sampled_from("abcd"), st.builds(Clock, small, times), max_size=4
)


def counted(schedule: Schedule) -> list[tuple[int, int]]:
    """Return the instants by trying every tick."""
    found = []
    for k in range(schedule.stop + 1):
        due = [
            k >= first and (k - first) % every == 0
            for every, first in zip(schedule.every, schedule.first, strict=True)
        ]
        mask = sum(1 << i for i, is_due in enumerate(due) if is_due)
        if mask or k in (0, schedule.stop):
            found.append((k, mask))
    return found


@given(clocks, times)
def test_stored_and_lazy_instants_are_those_of_the_definition(
    clocks: dict[str, Clock], stop: Fraction
) -> None:
    schedule = Schedule.of(clocks, stop)
    expected = counted(schedule)
    assert list(schedule.merged(0, schedule.stop)) == expected
    assert list(schedule.instants()) == expected


@given(clocks, times, st.integers(0, 100))
def test_instants_before_one_are_as_many_as_are_counted(
    clocks: dict[str, Clock], stop: Fraction, k: int
) -> None:
    schedule = Schedule.of(clocks, stop)
    stretches = list(schedule.stretches())
    before = sum(stretch.before(k) for stretch in stretches)
    assert before == sum(at < k for stretch in stretches for at, _ in stretch)


@given(st.lists(small, min_size=1, max_size=6))
def test_the_common_tick_divides_every_period_and_is_the_largest(
    periods: list[Fraction],
) -> None:
    tick = rational_gcd(*periods)
    counts = [period / tick for period in periods]
    assert all(c.denominator == 1 for c in counts)
    assert rational_gcd(*counts) == 1


@pytest.mark.parametrize(
    "periods",
    [("1/8000", "1/5000"), ("1/20000", "1/15000", "1/3000")],
)
def test_each_clock_is_due_exactly_so_often_over_many_seconds(
    periods: list[str],
) -> None:
    """Over 100 s, the pattern a hundred thousand times; 1000 s with --every-form."""
    seconds = EFFORT.sample(1000, 100)
    clocks = {p: Clock(Fraction(p)) for p in periods}
    schedule = Schedule.of(clocks, Fraction(seconds))
    masks = Counter(mask for _, mask in schedule.instants())
    due = [
        sum(count for mask, count in masks.items() if mask >> i & 1)
        for i in range(len(periods))
    ]
    assert due == [seconds // Fraction(p) + 1 for p in periods]
    assert due == [schedule.ticks(p) for p in periods]
    lazy = sum(1 for _ in schedule.merged(0, schedule.stop // 100))
    assert masks.total() == (lazy - 1) * 100 + 1


def test_seconds_are_the_nearest_float_of_the_exact_time() -> None:
    schedule = Schedule.of({"a": Clock(Fraction(1, 3000))}, Fraction(100))
    for k in (1, 2, 7, 299_999, 300_000):
        assert schedule.seconds(k) == float(Fraction(k, 3000))


def test_a_stop_too_many_ticks_away_is_refused() -> None:
    clocks = {"a": Clock(Fraction(1, 10**9 + 7)), "b": Clock(Fraction(1, 10**9 + 9))}
    with pytest.raises(ScheduleError, match="larger common divisor"):
        Schedule.of(clocks, Fraction(10))


def test_periods_and_offsets_out_of_range_are_refused_by_name() -> None:
    with pytest.raises(ScheduleError, match="loop: period 0"):
        Schedule.of({"loop": Clock(Fraction(0))}, Fraction(1))
    with pytest.raises(ScheduleError, match="loop: offset -1"):
        Schedule.of({"loop": Clock(Fraction(1), Fraction(-1))}, Fraction(1))
