"""What a failed run says is its failure, whatever it was to be judged by."""

import sys
from pathlib import Path
from typing import Any, get_args

import pytest
from broken import MISBEHAVES, MODES, pack
from pydantic import BaseModel

from orchestrator.errors import SimulationError
from orchestrator.evaluation.schema import MetricSpec
from orchestrator.history.listing import entries
from orchestrator.scenario.reading import scenario_from
from orchestrator.session import run

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="signals and limits of Linux"
)
MORE: dict[str, dict[str, Any]] = {
    "error": {"against": "bad.u"},
    "settling": {},
    "sine": {"frequency_hz": 20, "against": "bad.u"},
    "spectrum": {"frequency_hz": 20},
    "onset": {"ramp": "bad.u", "piece": 0.01},
    "step": {"height": 1.0, "band": 0.1},
    "contour": {"across": "bad.u", "shape": "circle", "size": 1.0},
    "sustained": {"level": "bad.u", "dwell": "1/50", "tail": "1/100", "span": 0.1},
}


def kinds() -> list[str]:
    """Return every kind of metric there is."""
    union: Any = get_args(MetricSpec)[0]
    models: list[type[BaseModel]] = list(get_args(union))
    fields = [get_args(model.model_fields["kind"].annotation) for model in models]
    return [kind for literals in fields for kind in literals]


METRICS = {
    kind: {"kind": kind, "of": "bad.y", **MORE.get(kind, {})} for kind in kinds()
}


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
            misbehaves, mode, float(at), {"m": METRICS[kind]}, isolation="none"
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
