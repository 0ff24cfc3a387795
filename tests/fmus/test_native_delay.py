"""Dead time is exact for any step, and part of the FMU state."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

START = [0.7, -0.4]


def integrals(
    changes: Sequence[tuple[float, float]], first: float, end: float
) -> tuple[float, float]:
    """Integrate a piecewise-constant signal once and twice from 0 to end, exactly."""
    edges = [t for t, _ in changes if t < end]
    values = [first, *(value for t, value in changes if t < end)]
    x = w = 0.0
    for t, until, value in zip([0.0, *edges], [*edges, end], values, strict=True):
        span = until - t
        w += x * span + value * span**2 / 2
        x += value * span
    return x, w


@settings(max_examples=40, deadline=None)
@given(
    steps=st.lists(st.integers(1, 40), min_size=1, max_size=30),
    tau=st.sampled_from([0.0, 1e-5, 3e-4, 3.3e-4, 1.23456789e-3]),
    seed=st.integers(0, 1000),
)
def test_delay_is_exact_whatever_the_steps(
    compiled: Callable, steps: list[int], tau: float, seed: int
) -> None:
    levels = np.random.default_rng(seed).integers(-2, 3, size=(len(steps), 2))
    it = compiled("late").new()
    it.set("u", START)
    it.set("tau", tau)
    it.begin()
    t = 0.0
    changes: list[list[tuple[float, float]]] = [[], []]
    for step, level in zip(steps, levels, strict=True):
        h = step * 1.7e-5
        it.set("u", level)
        for line, value in zip(changes, level, strict=True):
            line.append((t + tau, float(value)))
        it.step(t, h)
        t = t + h
        for i in range(2):
            x, w = integrals(changes[i], START[i], t)
            assert it.get("state.x")[i] == pytest.approx(x, rel=1e-12, abs=1e-16)
            if i == 0:
                assert it.get("state.w") == pytest.approx(w, rel=1e-11, abs=1e-18)
            arrived = [v for at, v in changes[i] if at < t - 1e-9 * h]
            assert it.get("y")[i] == [START[i], *arrived][-1]
    it.fmu.freeInstance()


def test_before_the_first_change_arrives_the_start_value_holds(
    compiled: Callable, version: int
) -> None:
    it = compiled("late").new(version)
    it.enter()
    it.set("u", START)
    np.testing.assert_array_equal(it.get("y"), START)
    it.fmu.exitInitializationMode()
    it.set("u", [5.0, 6.0])
    it.step(0.0, 3.2e-4)
    np.testing.assert_array_equal(it.get("y"), START)
    np.testing.assert_allclose(
        it.get("state.x"), np.multiply(START, 3.2e-4), rtol=1e-12
    )


def test_a_change_that_arrives_at_the_end_of_a_step_acts_in_the_next(
    compiled: Callable, version: int
) -> None:
    it = compiled("late").new(version)
    it.set("tau", 3e-4)
    it.begin()
    it.set("u", [1.0, 1.0])
    h = 1e-4
    seen = []
    for k in range(5):
        it.step(k * h, h)
        seen.append(float(it.get("y")[0]))
    assert seen == [0, 0, 0, 1, 1]


def test_late_steps_at_large_times_go_on(compiled: Callable, version: int) -> None:
    it = compiled("late").new(version).begin(start=1e6)
    t, h = 1e6, 5e-5
    for k in range(200):
        it.set("u", [k % 3, k % 2])
        it.step(t, h)
        t += h
    assert np.isfinite(it.get("state.x")).all()


def test_changes_under_way_are_saved(compiled: Callable, version: int) -> None:
    built = compiled("late")
    it = built.new(version).begin()
    h = 5e-5
    for k in range(37):
        it.set("u", [np.sin(k), k % 2])
        it.step(k * h, h)
    blob = it.saved()
    assert it.saved() == blob

    first = onwards(it)
    it.restore(blob)
    assert it.saved() == blob
    assert onwards(it) == first
    other = built.new(version, "another")
    other.restore(blob)
    assert onwards(other) == first


def onwards(it: Any) -> list[bytes]:
    """Step from tick 37 on; return the whole state after each step."""
    blobs = []
    for k in range(37, 60):
        it.set("u", [np.cos(k), 1.0])
        it.step(k * 5e-5, 5e-5)
        blobs.append(it.saved())
    return blobs


def test_a_damaged_line_is_refused(compiled: Callable, version: int) -> None:
    it = compiled("late").new(version).begin()
    it.set("u", [1.0, 2.0])
    it.step(0.0, 1e-5)
    blob = bytearray(it.saved())
    count = len(blob) - 16 - 8  # of the second line: one change of 16 bytes follows
    assert int.from_bytes(blob[count : count + 8], "little") == 1
    blob[count : count + 8] = (2**60).to_bytes(8, "little")
    before = it.all()
    assert "no state of Late" in it.refused(lambda: it.restore(bytes(blob)))
    for name, value in it.all().items():
        np.testing.assert_array_equal(value, before[name])


def test_negative_dead_time_is_refused(compiled: Callable, version: int) -> None:
    it = compiled("late").new(version).begin()
    it.set("tau", -1e-3)
    message = it.refused(lambda: it.step(0.0, 1e-4))
    assert "tau is -0.001 s" in message
    it.set("tau", 1e-3)
    it.step(0.0, 1e-4)
