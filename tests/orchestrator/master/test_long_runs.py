"""Long runs need little memory, and what a killed one recorded can be read."""

import signal
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from orchestrator.master.simulate import simulate
from orchestrator.profile import peak_memory
from orchestrator.result import Result
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier
from orchestrator.system import System

DRIVE = "ball_screw_pole_placement/mc_ppc_track_500"
SIGNALS = 20


def drive(stop: str) -> System:
    """Return the ball-screw drive with 20 signals recorded at 20 kHz."""
    composition = compose(load_scenario(DRIVE), run_earlier)
    names = [
        f"{component}.{name}"
        for component, fmu in composition.fmus.items()
        for name, v in fmu.variables.items()
        if v.causality == "output" or name.startswith("state.")
    ]
    assert len(names) >= SIGNALS
    record = dict.fromkeys(names[:SIGNALS], (Fraction(1, 20_000),))
    return replace(composition.system, stop=Fraction(stop), record=record)


def long_run(stop: str, folder: str) -> None:
    """Run in a process of its own; tell every time whose rows are on disk."""
    given = drive(stop)
    simulate(given, Path(folder), progress=lambda t: print(float(t), flush=True))
    print("peak", peak_memory(), flush=True)


def child(stop: str, folder: Path) -> subprocess.Popen[str]:
    command = [sys.executable, __file__, stop, str(folder)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGKILL")
def test_rows_told_before_a_kill_are_readable(tmp_path: Path) -> None:
    process = child("1000", tmp_path)
    assert process.stdout is not None
    told = [float(process.stdout.readline()) for _ in range(4)]
    process.send_signal(signal.SIGKILL)
    rest = process.communicate()[0].split()
    assert process.returncode == -signal.SIGKILL
    reached = max([*told, *map(float, rest[:-1])])
    result = Result(tmp_path)
    assert len(result) == SIGNALS
    time = next(iter(result.values())).time
    assert reached > 0
    assert time[-1] >= reached
    np.testing.assert_array_equal(time, np.arange(len(time)) / 20_000)


@pytest.mark.skipif(sys.platform == "win32", reason="memory is not known there")
def test_memory_does_not_grow_with_the_length_of_a_run(tmp_path: Path) -> None:
    peaks = []
    for stop in ("1", "60"):
        process = child(stop, tmp_path / stop)
        words = process.communicate()[0].split()
        assert words[-2] == "peak"
        peaks.append(int(words[-1]))
    assert peaks[1] < 300e6
    assert peaks[1] - peaks[0] < 64e6


if __name__ == "__main__":
    long_run(*sys.argv[1:])
