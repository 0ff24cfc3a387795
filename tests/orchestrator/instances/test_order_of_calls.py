"""Experiment, start values, logging: in what order an FMU is told what."""

import logging
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from outcomes import outcomes

from orchestrator.errors import SimulationError
from orchestrator.master.simulate import simulate
from orchestrator.result import Result
from orchestrator.system import Component, Experiment, Isolation, System
from orchestrator.warned import collecting


def simulated(fmu: Path, folder: Path, stop: str = "1/10", **options: object) -> Result:
    component = Component("a", fmu, Fraction("1/100"), **options)  # type: ignore[arg-type]
    record = {name: (Fraction("1/100"),) for name in ("a.seen", "a.t")}
    return simulate(System("t", Fraction(stop), {"a": component}, {}, record), folder)


def test_values_survive_an_fmu_that_resets_everything_when_its_experiment_is_set_up(
    tmp_path: Path,
) -> None:
    fmu = outcomes(2, tmp_path, loses=1)
    found = simulated(fmu, tmp_path, parameters={"k": 7.0})
    np.testing.assert_array_equal(found["a.seen"].values, 7.0)


@pytest.mark.parametrize(
    ("fmi", "stage", "apart"),
    [(2, 2, False), (3, 2, False), (2, 3, True), (3, 3, False)],
)
def test_values_that_an_fmu_overwrites_later_are_refused(
    tmp_path: Path, fmi: int, stage: int, apart: bool
) -> None:
    fmu = outcomes(fmi, tmp_path, loses=stage)
    said = r"a\.k was given 7\.0, but the FMU \(outcomes\d\.fmu\) holds 1\.0 after its"
    isolation = Isolation(process=apart)
    with pytest.raises(SimulationError, match=said):
        simulated(fmu, tmp_path, parameters={"k": 7.0}, isolation=isolation)


@pytest.mark.parametrize(("fmi", "apart"), [(2, True), (3, False)])
def test_an_fmu_that_needs_a_stop_time_is_made_anew_with_it_and_that_is_said(
    tmp_path: Path, fmi: int, apart: bool
) -> None:
    fmu = outcomes(fmi, tmp_path, needs_stop=1)
    isolation = Isolation(process=apart)
    with collecting() as warned:
        found = simulated(fmu, tmp_path, parameters={"k": 7.0}, isolation=isolation)
    assert found["a.t"].values[-1] == pytest.approx(0.1)
    assert [text for text in warned if "it was handed the stop, 0.1 s" in text]
    with collecting() as warned:
        asked = Experiment(stop=True, tolerance=1e-6)
        simulated(fmu, tmp_path, experiment=asked, isolation=isolation)
    assert not warned


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_fmu_that_talks_is_heard_until_it_is_initialised_and_with_v_always(
    tmp_path: Path,
    fmi: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fmu = outcomes(fmi, tmp_path, talks=30)
    log = logging.getLogger("feeddrive")
    heard: list[str] = []
    handler = logging.Handler()
    handler.emit = lambda record: heard.append(record.getMessage())  # type: ignore[method-assign]
    monkeypatch.setattr(log, "handlers", [handler])
    monkeypatch.setattr(log, "propagate", False)
    for level in (logging.WARNING, logging.INFO):
        monkeypatch.setattr(log, "level", level)
        log.manager._clear_cache()  # type: ignore[attr-defined]
        heard.clear()
        simulated(fmu, tmp_path, stop="1")
        talked = sum("which is fine" in text for text in heard)
        assert talked == (3_000 if level == logging.INFO else 0)
