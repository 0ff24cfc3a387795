"""A run held to the clock: blocks, overruns and jitter, by a clock of the test."""

from pathlib import Path

import pytest
from systems import part, system

from orchestrator.errors import SimulationError
from orchestrator.master import pace
from orchestrator.master.pace import Pacer
from orchestrator.master.simulate import plan, simulate


class Clock:
    """Goes on by what a block takes, and by what is slept."""

    def __init__(self, takes: list[float]) -> None:
        self.now, self.takes, self.slept = 100.0, takes, []

    def read(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds


@pytest.mark.parametrize("factor", [1.0, 0.5])
def test_blocks_end_when_the_clock_comes_to_them_and_late_ones_are_counted(
    monkeypatch: pytest.MonkeyPatch, factor: float
) -> None:
    takes = [0.0, 0.25e-3, 2.5e-3, 0.25e-3]  # the third block takes too long
    clock = Clock(takes)
    monkeypatch.setattr(pace, "perf_counter", clock.read)
    monkeypatch.setattr(pace, "sleep", clock.sleep)
    given = system("1/100", [part("a", "counter", "1/4000")], {}, {"a.k": "1/4000"})
    pacer = Pacer(factor, plan(given))
    k = pacer.first()
    for block in takes:
        clock.now += block
        k = pacer.reached(k)
    told = pacer.told()
    per_block = round(4 * factor)  # instants in 1 ms of the clock
    assert k == 4 * per_block
    assert (told.blocks, told.overruns) == (4, 2)
    assert told.worst_s == pytest.approx(1.5e-3)
    assert told.rms_s == pytest.approx(1e-3 * ((1.5**2 + 0.75**2) / 4) ** 0.5)
    assert clock.slept == pytest.approx([0.0, 0.75e-3])


def test_a_run_takes_as_long_as_the_clock(tmp_path: Path) -> None:
    given = system("1/20", [part("a", "counter", "1/4000")], {}, {"a.k": "1/4000"})
    timing = simulate(given, tmp_path, pace=1.0).timing
    assert timing
    assert timing.paced
    assert timing.wall_s >= 0.05
    assert 50 <= timing.paced.blocks <= 201
    assert 0 <= timing.paced.overruns <= timing.paced.blocks


def test_what_is_no_pace_is_refused(tmp_path: Path) -> None:
    given = system("1/100", [part("a", "counter", "1/1000")], {}, {"a.k": "1/1000"})
    with pytest.raises(SimulationError, match=r"from 0\.001 to 1000; 1 is as fast"):
        simulate(given, tmp_path, pace=0.0)
