"""Signals are compared at the instants at which both are published, or not at all."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from orchestrator.errors import ScenarioError
from orchestrator.report.panels import panels
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

SINES = """
stop = "0.1"
[rates]
slow = "1 kHz"
[components.fast]
fmu = "controllers.references.sine"
step = "20 kHz"
[components.command]
fmu = "controllers.references.sine"
step = "slow"
[record]
"fast.x_r" = ["20 kHz", "slow"]
"command.x_r" = "20 kHz"
[metrics]
error = { kind = "error", of = "fast.x_r", against = "command.x_r" }
at_slow = { kind = "rms", of = "fast.x_r", at = "slow" }
"""


@pytest.fixture
def sines(tmp_path: Path) -> Path:
    file = tmp_path / "sines.toml"
    file.write_text(SINES)
    return file


def test_a_command_that_is_held_counts_at_its_own_ticks(sines: Path) -> None:
    done = run(sines, sines.parent / "out")
    assert done.metrics["error.peak"].value < 1e-17
    fast, command = done["fast.x_r"], done["command.x_r"]
    assert len(fast) == len(command) == 2001
    assert np.max(np.abs(command.values - fast.values)) > 1e-6  # between ticks
    assert (fast.published.period, command.published.period) == (
        Fraction(1, 20_000),
        Fraction(1, 1000),
    )
    drawn = [c for p in panels([done]) if p.title == "error: error" for c in p.curves]
    assert [len(curve.values) for curve in drawn] == [101]


def test_one_signal_is_recorded_at_several_rates_and_taken_at_one(sines: Path) -> None:
    done = run(sines, sines.parent / "out", report=False)
    slow = done.at(Fraction(1, 1000))["fast.x_r"]
    assert len(slow) == 101
    assert np.array_equal(slow.values, done["fast.x_r"].values[::20])
    rms = np.sqrt(np.mean(slow.values**2))
    assert done.metrics["at_slow.rms"].value == pytest.approx(rms, rel=1e-15)
    again = run(
        sines.parent / "out/scenario.lock.toml", sines.parent / "again", report=False
    )
    assert again.metrics == done.metrics
    assert set(done.to_pandas()) == {"every_1_1000_s", "every_1_20000_s"}


def test_at_takes_all_rows_of_a_rate_also_where_a_value_is_held(sines: Path) -> None:
    changed = 'against = "command.x_r", at = "20 kHz"'
    sines.write_text(SINES.replace('against = "command.x_r"', changed))
    done = run(sines, sines.parent / "out", report=False)
    held = np.max(np.abs(done["command.x_r"].values - done["fast.x_r"].values))
    assert done.metrics["error.peak"].value == held > 0


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"slow"\n[record]', '"slow"\noffset = "10 us"\n[record]',
         "metrics.error: there is no instant up to 0.1 s at which all are published"),
        ('at = "slow"', 'at = "3 kHz"', "at: fast.x_r is not recorded at 333.333 us"),
        ('at = "slow"', 'at = "slwo"', "there is no rate 'slwo'"),
        ('at = "slow"', 'window = ["0.01 ms", "0.02 ms"]', "no row lies in"),
        ('at = "slow"', "window = [0.2, 0.3]", "no row lies in [0.2, 0.3] s"),
        ('["20 kHz", "slow"]', "[]", "give a rate, a list of rates, or true"),
    ],
)  # fmt: skip
def test_what_cannot_be_compared_is_refused_before_the_run(
    sines: Path, old: str, new: str, said: str
) -> None:
    assert old in SINES
    sines.write_text(SINES.replace(old, new))
    with pytest.raises(ScenarioError) as refusal:
        run(load_scenario(sines), sines.parent / "out")
    assert said in str(refusal.value)
    assert not (sines.parent / "out").exists()


def test_the_instants_stand_in_the_files(sines: Path) -> None:
    import pyarrow.parquet

    done = run(sines, sines.parent / "out", report=False)
    schema = pyarrow.parquet.read_schema(done.folder / "result/every_1_20000_s.parquet")
    assert schema.field("command.x_r").metadata[b"published"] == b"0 1/1000"
    assert json.loads((done.folder / "metrics.json").read_text())["metrics"]
