"""Kept runs are told apart by what was resolved, and drawn over each other."""

import json
from pathlib import Path

import numpy as np
import pytest
from command import refused

from orchestrator.report.overlaid import write_overlaid
from orchestrator.result import Recorded, Result, Signal


@pytest.fixture
def two(drive: Path, feeddrive) -> None:
    stiff = ["--set", "plant.k=300", "--set", "record.plant.x_2=10 kHz"]
    for name, sets in {"a": [], "b": stiff}.items():
        done = feeddrive("run", drive, *sets, "-o", name)
        assert done.exit_code == 0, done.output


def test_what_differs_figures_and_the_page(two: None, feeddrive) -> None:
    told = json.loads(feeddrive("compare", "a", "b", "--json").stdout)
    found = {d["key"]: d["values"] for d in told["differences"]}
    assert found["components.plant.parameters.k"] == ["–", "300"]
    assert found["record.plant.x_2"] == ["1/20000", "1/10000"]
    assert not any(d["part"] in ("FMUs", "versions") for d in told["differences"])
    a, b = (told["figures"][run]["x.peak"]["value"] for run in "ab")
    assert a != b
    page = Path(told["page"]).read_text()
    assert "plant.x_2: difference to a" in page
    printed = feeddrive("compare", "a", "b").stdout
    assert "x.peak" in printed
    assert "runs/compare.html" in printed


def test_locks_alone_are_compared_too(two: None, feeddrive) -> None:
    done = feeddrive("compare", "a/scenario.lock.toml", "b/scenario.lock.toml")
    assert "components.plant.parameters.k" in done.stdout
    assert "compare.html" not in done.stdout
    same = feeddrive("compare", "a", "a/scenario.lock.toml")
    assert "the locks are equal" in same.stdout


def overlaid(runs: dict, folder: Path) -> dict:
    """Return the panels of runs over each other by their titles."""
    seen = {}

    def keep(panels, overlaid):
        seen.update({p.title: p for p in panels})
        raise InterruptedError

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("orchestrator.report.overlaid.drawn", keep)
        with pytest.raises(InterruptedError):
            write_overlaid("x", runs, [], folder / "x.html")
    return seen


def test_a_difference_is_taken_at_common_instants_and_in_one_unit(
    tmp_path: Path,
) -> None:
    slow, fast = np.arange(5) / 1000, np.arange(9) / 2000
    runs = {
        "slow": Recorded({1: {"x": Signal("x", slow, 1e3 * slow, "mm")}}),
        "fast": Recorded({1: {"x": Signal("x", fast, fast + 0.5, "m")}}),
    }
    seen = overlaid(runs, tmp_path)
    (curve,) = seen["x: difference to slow, at 5 common instants"].curves
    assert curve.time.tolist() == slow.tolist()
    np.testing.assert_allclose(curve.values, 500)


WHOLE = np.arange(9) / 2000
ALIKE = {  # times and unit of a second run, and what is said; a third is the first
    "all rows": (WHOLE, "m", "x: all equal"),
    "half as long": (WHOLE[:5], "m", "x: equal at 5 common instants, no others"),
    "the start alone": (
        np.arange(9) / 2300,
        "m",
        "x: equal at 1 common instant, no others",
    ),
    "no instant": (
        WHOLE + 1e-5,
        "m",
        "x (b has no instant in common with the first): equal",
    ),
    "another unit": (WHOLE, "V", None),
}


@pytest.mark.parametrize("case", ALIKE)
def test_all_are_equal_only_where_all_rows_of_all_were_compared(
    tmp_path: Path, case: str
) -> None:
    time, unit, title = ALIKE[case]
    runs = {
        "a": Recorded({1: {"x": Signal("x", WHOLE, np.ones(9), "m")}}),
        "b": Recorded({1: {"x": Signal("x", time, np.ones(len(time)), unit)}}),
        "c": Recorded({1: {"x": Signal("x", WHOLE, np.ones(9), "m")}}),
    }
    (found,) = overlaid(runs, tmp_path)
    assert found == title if title else "all equal" not in found


def test_runs_that_cannot_be_compared_are_refused(two: None, feeddrive) -> None:
    refused(feeddrive("compare", "a"), "name two")
    refused(feeddrive("compare", "a", "a"), "named twice")
    refused(feeddrive("compare", "a", "nowhere"), "there is no run 'nowhere'")
    refused(feeddrive("compare", "a", "b", "--signal", "plant.x"), "plant.x_2")
    Path("empty").mkdir()
    refused(feeddrive("compare", "a", "empty"), "holds no run")


def test_plot_draws_signals_of_a_run(two: None, feeddrive, monkeypatch) -> None:
    done = feeddrive("plot", "a", "plant.x_2", "-o", "x.html")
    assert "written to x.html" in done.stdout
    assert "plant.x_2" in Path("x.html").read_text()
    refused(feeddrive("plot", "a", "plant.x"), "did you mean 'plant.x_2'")
    refused(feeddrive("plot", "a", "plant.x_2", "-o", "x.pdf"), "x.pdf", "HTML")
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda page: opened.append(page) or True)
    feeddrive("plot", "a", "plant.x_2")
    assert opened == [(Path("a") / "plot.html").resolve().as_uri()]
    assert len(Result(Path("a"))["plant.x_2"]) == 201
