"""An FMU that ends the run is an outcome: rows, figures and the reason."""

from fractions import Fraction
from pathlib import Path

import pytest
from outcomes import outcomes
from systems import part, trusted

from orchestrator.errors import SimulationError
from orchestrator.master.simulate import Choice, simulate
from orchestrator.result import Result
from orchestrator.scenario.reading import scenario_from
from orchestrator.session import run
from orchestrator.system import Component, Isolation, System

# how it ends (outcomes.c): at, the last row (both s), and why, for steps of 10 ms
WHOLE, WITHIN, EARLY, DISCARDED, TERMINATED, SILENT = 1, 2, 3, 4, 5, 6
ENDS = {
    (3, WHOLE): (0.03, 0.03, "it asked to end the simulation"),
    (3, WITHIN): (0.035, 0.03, "it asked to end the simulation"),
    (3, EARLY): (0.035, 0.03, "it returned early"),
    (3, DISCARDED): (0.035, 0.03, "it discarded a step of 0.01 s"),
    (3, TERMINATED): (0.035, 0.03, "it discarded a step and asked to end the"),
    (2, DISCARDED): (0.035, 0.03, "it discarded a step of 0.01 s"),
    (2, TERMINATED): (0.035, 0.03, "it discarded a step and said that it has"),
}


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    folder = tmp_path_factory.mktemp("outcomes")
    return {fmi: trusted(outcomes(fmi, folder)) for fmi in (2, 3)}


def simulated(
    fmu: Path, how: int, at: float, folder: Path, executor: Choice, apart: bool
) -> Result:
    step, isolation = Fraction("1/100"), Isolation(process=apart)
    values = {"how": float(how), "at": at}
    one = Component("one", fmu, step, parameters=values, isolation=isolation)
    here = Isolation(process=False)
    other = Component("other", fmu, step / 2, isolation=here)
    ours = part("ours", "counter", "1/200")
    record = {"one.t": (step,), "other.t": (step / 2,), "ours.k": (step / 2,)}
    parts = {"one": one, "other": other, "ours": ours}
    system = System("t", Fraction("1/20"), parts, {}, record)
    return simulate(system, folder, executor=executor)


@pytest.mark.parametrize(
    ("fmi", "how", "executor", "apart"),
    [
        *((*end, how, False) for end in ENDS for how in ("kernel", "python", "fused")),
        *((3, how, "kernel", True) for how in (WHOLE, DISCARDED)),
        *((3, WHOLE, executor, True) for executor in ("python", "fused")),
        (2, TERMINATED, "kernel", True),
    ],
)
def test_an_fmu_that_ends_the_run_leaves_rows_until_then_and_its_reason(
    fmus: dict[int, Path],
    fmi: int,
    how: int,
    executor: Choice,
    apart: bool,
    tmp_path: Path,
) -> None:
    at, last, reason = ENDS[fmi, how]
    result = simulated(fmus[fmi], how, at, tmp_path, executor, apart)
    assert result.ended is not None
    assert (result.ended.by, result.ended.at) == ("one", pytest.approx(at))
    assert result.ended.reason.startswith(reason)
    assert result["one.t"].time[-1] == pytest.approx(last)
    assert result["one.t"].values[-1] == pytest.approx(last)
    assert result["other.t"].time[-1] >= last
    assert len(result["ours.k"]) == len(result["other.t"])


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_discarded_step_of_which_nothing_is_said_is_a_failure(
    fmus: dict[int, Path], fmi: int, tmp_path: Path
) -> None:
    with pytest.raises(SimulationError, match="returned Discard"):
        simulated(fmus[fmi], SILENT, 0.035, tmp_path, "kernel", False)


def test_figures_count_until_the_end_and_windows_beyond_it_are_not_met(
    fmus: dict[int, Path], tmp_path: Path
) -> None:
    of = {"kind": "max", "of": "a.t"}
    raw = {
        "stop": "1/10",
        "components": {
            "a": {
                "fmu": str(fmus[2]),
                "step": "1/100",
                "parameters": {"how": TERMINATED, "at": 0.035},
            }
        },
        "record": {"a.t": True},
        "metrics": {
            "all": of,
            "reached": of | {"window": [0, 0.03]},
            "beyond": of | {"window": [0, 0.05]},
            "after": of | {"window": [0.06, 0.1]},
        },
        "expect": {f"{m}.max": {"below": 1} for m in ("all", "reached", "beyond")},
    }
    done = run(scenario_from(raw, tmp_path / "s.toml"), tmp_path / "run", report=True)
    assert done.metrics["all.max"].value == done.metrics["reached.max"].value == 0.03
    assert [check.met for check in done.checks] == [True, True, False]
    assert "was not reached: ended by a at t = 0.035 s" in str(
        done.metrics["after.max"]
    )
    told = done.summary()
    assert told["ended"]["by"] == "a"
    assert "ended by a" in (tmp_path / "run" / "report.html").read_text()
