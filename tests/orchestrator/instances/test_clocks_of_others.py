"""FMUs of others that a clock ticks: by it, to exact values, or refused in words."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from clocked import PERIODIC, clocked
from systems import part, system

from orchestrator.errors import FeedDriveError, WiringError
from orchestrator.master.simulate import plan, simulate
from orchestrator.system import Component, Isolation, System
from orchestrator.warned import collecting

MS = Fraction(1, 1000)
N = 20


def ticked(file: Path, process: bool = False, **options: object) -> System:
    """The FMU, given the number of each tick."""
    one = Component("c", file, MS, isolation=Isolation(process=process))
    one = replace(one, **options)
    rows = {f"c.{name}": str(MS) for name in "nywz"}
    return system(
        str(N * MS), [part("a", "counter", str(MS)), one], {"c.u": "a.k"}, rows
    )


@pytest.mark.parametrize("process", [False, True])
@pytest.mark.parametrize("executor", ["python", "kernel", "fused"])
def test_its_clock_ticks_it_at_the_instant(
    executor: str, process: bool, tmp_path: Path
) -> None:
    done = simulate(
        ticked(clocked(tmp_path), process),
        tmp_path / "run",
        executor=executor,  # type: ignore[arg-type]
    )
    integral = np.cumsum([0.0, *(1e-3 * k for k in range(N))])
    expected = {
        "n": [k + 1 for k in range(N + 1)],
        "y": [k * (k + 1) / 2 for k in range(N + 1)],
        "w": integral,
        "z": integral,
    }
    for name, values in expected.items():
        np.testing.assert_array_equal(np.array(done[f"c.{name}"]), values)


@pytest.mark.parametrize(
    ("clock", "why"),
    [
        ('intervalVariability="triggered"', "clock c, triggered, and only"),
        ('intervalVariability="countdown"', "clock c, countdown, and only"),
        ('intervalVariability="changing"', "clock c, changing, and only"),
        (f'{PERIODIC} shiftDecimal="0.0005"', "clock c, shifted by 1/2000 s"),
    ],
)
def test_what_would_never_tick_is_refused(clock: str, why: str, tmp_path: Path) -> None:
    with pytest.raises(WiringError, match=why) as refused:
        plan(ticked(clocked(tmp_path, clock)))
    assert "would never be computed" in str(refused.value)


def test_without_event_mode_a_clock_is_left_to_the_fmu_and_warned_of(
    tmp_path: Path,
) -> None:
    with collecting() as said:
        plan(ticked(clocked(tmp_path, events=False)))
    assert "nothing ticks it" in " ".join(said)
    with collecting() as said:
        plan(ticked(clocked(tmp_path / "ticked")))
    assert said == []


def test_a_clock_beside_its_period_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FeedDriveError, match="built for a sample time of 1/1000 s"):
        plan(ticked(clocked(tmp_path), period=Fraction(1, 2000)))
    with pytest.raises(WiringError, match="is sampled by its clock, not continuous"):
        plan(ticked(clocked(tmp_path), kind="continuous"))
