"""What a failed run says is its failure, whatever it was to be judged by."""

import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from broken import MISBEHAVES, MODES, pack
from every_metric import METRICS
from systems import part, system, trusted

from orchestrator.errors import SimulationError
from orchestrator.history.listing import entries
from orchestrator.master.simulate import simulate
from orchestrator.scenario.reading import scenario_from
from orchestrator.session import run
from orchestrator.system import Component, Isolation

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="signals and limits of Linux"
)


@pytest.fixture(scope="module")
def misbehaves(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pack("misbehaves", MISBEHAVES, tmp_path_factory.mktemp("broken"))


def failure(fmu: Path, mode: str, at: float, metrics: dict[str, Any], **more: Any):
    """Return the error of a run whose FMU misbehaves at ``at``, or whose stop is."""
    stop = more.pop("stop", 0.1)
    parameters = {"mode": MODES.index(mode), "at": at}
    bad = {"fmu": str(fmu), "step": "1/1000", "parameters": parameters, **more}
    scenario = scenario_from(
        {
            "stop": stop,
            "components": {"bad": bad},
            "record": {"bad.y": "1/1000", "bad.u": "1/1000"},
            "metrics": metrics,
        },
        fmu.with_suffix(".toml"),
    )
    with pytest.raises(SimulationError) as error:
        run(scenario)
    return error.value


FAILURES = [
    ("error", "doStep of 0.001 s at t = {} s returned Error."),
    ("fatal", "doStep of 0.001 s at t = {} s returned Fatal."),
    ("discard", "doStep of 0.001 s at t = {} s returned Discard."),
    ("nan", "y is nan at t = {next} s"),
]


@pytest.mark.parametrize("kind", METRICS)
@pytest.mark.parametrize(("mode", "said"), FAILURES)
def test_no_metric_masks_what_an_fmu_reports(
    misbehaves: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    mode: str,
    said: str,
    kind: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    for at, then in (("0", "0.001"), ("0.05", "0.051")):
        error = failure(
            trusted(misbehaves), mode, float(at), {"m": METRICS[kind]}, isolation="none"
        )
        told = said.replace("{next}", then).format(at)
        assert f"bad (misbehaves.fmu): {told}" in str(error)
        assert error.folder is not None
        assert entries(Path("runs"))[-1].why in str(error)


@pytest.mark.parametrize(
    ("mode", "more", "said"),
    [
        ("segfault", {}, "its process ended with signal 11 (SIGSEGV) during doStep"),
        ("exit", {}, "its process ended with exit code 7 during doStep"),
        ("hang", {"answer_within": "1/2"}, "no answer within 0.5 s"),
        ("memory", {"memory_limit": "200 MB"}, "ended with signal 6 (SIGABRT)"),
        ("well", {"stop": 1e12}, "rows need about"),
    ],
)
def test_no_metric_masks_the_end_of_a_process_or_of_the_disk(
    misbehaves: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    mode: str,
    more: dict[str, Any],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    for at in (0.0, 0.05):
        error = failure(
            misbehaves, mode, at, METRICS, **{"isolation": "process", **more}
        )
        assert said in str(error)


@pytest.mark.parametrize("isolation", ["none", "process"])
@pytest.mark.parametrize("executor", ["kernel", "python"])
@pytest.mark.parametrize(
    ("mode", "said"),
    [
        ("negative", "doStep of 0.001 s at t = 0.05 s returned -1, which is no status"),
        ("seven", "doStep of 0.001 s at t = 0.05 s returned 7, which is no status"),
        ("negative_get", "get Real (y, ...) at t = 0.05 s returned -1, which is no"),
        ("negative_set", "set Real (u, ...) at t = 0.05 s returned -1, which is no"),
        ("negative_start", "failed with status -1 (illegal return code)"),
    ],
)
def test_a_status_that_fmi_does_not_know_is_no_success(
    misbehaves: Path,
    tmp_path: Path,
    mode: str,
    said: str,
    executor: Any,
    isolation: str,
) -> None:
    parameters = {"mode": MODES.index(mode), "at": 0.05}
    bad = part_of(misbehaves, parameters, process=isolation == "process")
    fed = [part("ramp", "counter", "1/1000"), bad]
    given = system("0.1", fed, {"bad.u": "ramp.k"}, {"bad.y": "1/1000"})
    with pytest.raises(SimulationError) as error:
        simulate(given, tmp_path, executor=executor)
    assert "bad (misbehaves.fmu)" in str(error.value)
    assert said in str(error.value)


def part_of(fmu: Path, parameters: dict[str, float], *, process: bool) -> Component:
    return Component(
        "bad",
        fmu,
        Fraction(1, 1000),
        parameters=parameters,
        isolation=Isolation(process=process),
    )
