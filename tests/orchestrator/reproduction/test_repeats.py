"""Rows over many runs: seeds apart, mean and spread of the runs, faults in words."""

import numpy as np
import pytest

from orchestrator.errors import ScenarioError
from orchestrator.quantities.quantity import NoValue, Quantity
from orchestrator.reproduction.reference import read_reference
from orchestrator.reproduction.repeats import Repeats
from orchestrator.reproduction.reproduce import reproduce

SCENARIO = """
stop = "1/20"
[components.noise]
fmu = "plants.disturbances.noise"
step = "20 kHz"
parameters = { sigma = 2.0 }
[record]
"noise.d" = true
[metrics]
d = { kind = "mean", of = "noise.d" }
"""
REFERENCE = """
[[table]]
title = "Mean of a noise"
where = "Table 1"
id = "mean.{take}"
unit = "V"
class = "derived"
scenario = "noise"
metric = "d.mean"
why = "-"
rows = [{ name = "over six", published = [0, 0.0632] }]
[[table.columns]]
name = "mean"
take = "mean"
repeats = { seeds = ["noise.seed"], count = 6, take = "mean" }
[[table.columns]]
name = "spread"
take = "std"
repeats = { seeds = ["noise.seed"], count = 6, take = "std" }
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    folder = tmp_path / "noisy"
    folder.mkdir()
    (folder / "noise.toml").write_text(SCENARIO)
    (folder / "reference.toml").write_text(REFERENCE)
    monkeypatch.chdir(tmp_path)
    return folder


def test_mean_and_spread_are_those_of_the_runs_and_the_same_every_time(study, tmp_path):
    told: list[str] = []
    first = reproduce(study, processes=1, told=told.append)
    assert len(told) == 6  # both rows share their runs
    mean, spread = (figure.value for figure in first.figures)
    # of 1001 values of sigma 2: 2 / sqrt(1001), and six of them
    assert abs(mean) < 3 * 0.0632 / np.sqrt(6)
    assert 0.02 < spread < 0.13
    again = reproduce(study, processes=1)
    assert [f.value for f in again.figures] == [mean, spread]


def test_no_two_noises_of_any_two_runs_are_alike():
    repeats = Repeats(seeds=("a.seed", "b.seed"), count=50, take="mean")
    given = [one.partition("=")[2] for told in repeats.sets() for one in told]
    assert len(set(given)) == 100


def test_a_run_without_the_figure_leaves_none():
    repeats = Repeats(seeds=("a.seed",), count=2, take="std")
    lost = repeats.of([Quantity(1.0, "s"), NoValue("s", why="not settled")])
    assert isinstance(lost, NoValue)
    assert lost.why == "repeat 2: not settled"
    assert repeats.of([Quantity(1.0, "s"), Quantity(3.0, "s")]).value == np.sqrt(2)


def test_repeats_of_what_is_no_scenario_are_refused(study):
    file = study / "reference.toml"
    file.write_text(
        REFERENCE.replace('scenario = "noise"\nmetric = "d.mean"', 'formula = "1"')
    )
    with pytest.raises(ScenarioError, match="repeats belong to a scenario"):
        read_reference(file)
