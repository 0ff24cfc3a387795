"""The verb ``design``: made anew, compared, written only when asked."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchestrator.analysis import redesign
from orchestrator.analysis.redesign import Shipped, compare
from orchestrator.cli import app

OLD = {"A": [[2.0, 1.0]], "design": {"gamma": 4.0, "weights": {"W": 1}}}
NEW = {"A": [[2.0, 1.5]], "design": {"gamma": 5.0, "weights": {"W": 2}}}


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Shipped:
    (tmp_path / "k.json").write_text(json.dumps(OLD))
    design = Shipped("drive.k", tmp_path, lambda: {"k.json": json.dumps(NEW)})
    monkeypatch.setattr(redesign, "shipped_designs", lambda: {"drive.k": design})
    return design


def told(*arguments: str) -> tuple[int, dict[str, object]]:
    result = CliRunner().invoke(app, ["design", *arguments, "--json"])
    return result.exit_code, json.loads(result.stdout)


def test_changes_are_told_by_size_and_nothing_is_written(shipped: Shipped) -> None:
    code, content = told("drive.k")
    assert code == 0
    assert content["changes"] == [
        {
            "file": "k.json",
            "quantity": "gamma",
            "before": 4.0,
            "after": 5.0,
            "difference": 0.25,
        },
        {
            "file": "k.json",
            "quantity": "A (1, 2)",
            "before": None,
            "after": None,
            "difference": 0.25,
        },
    ]
    assert json.loads((shipped.folder / "k.json").read_text()) == OLD


def test_writing_replaces_the_shipped_file(shipped: Shipped) -> None:
    told("drive.k", "--write")
    assert json.loads((shipped.folder / "k.json").read_text()) == NEW


@pytest.mark.usefixtures("shipped")
def test_an_unknown_design_is_refused_with_its_neighbours() -> None:
    code, content = told("drive.q")
    assert code == 2
    assert "did you mean 'drive.k'?" in str(content["error"])


def test_a_missing_solver_is_one_sentence(
    shipped: Shipped, monkeypatch: pytest.MonkeyPatch
) -> None:
    def make() -> dict[str, str]:
        raise ImportError('pip install "feeddrive-cosim[synthesis]"')

    broken = Shipped("drive.k", shipped.folder, make)
    monkeypatch.setattr(redesign, "shipped_designs", lambda: {"drive.k": broken})
    code, content = told("drive.k")
    assert code == 2
    assert "feeddrive-cosim[synthesis]" in str(content["error"])


def test_a_file_that_was_not_there_is_new(tmp_path: Path) -> None:
    design = Shipped("drive.k", tmp_path, lambda: {})
    changes = list(compare(design, {"k.json": json.dumps(NEW)}))
    assert [(c.before, c.difference) for c in changes] == [(None, None)] * 2


def test_all_drives_with_shipped_designs_are_found() -> None:
    found = redesign.shipped_designs()
    assert {"ball_screw_lpv.k_track", "ball_screw_lpv.k_vib"} <= set(found)
    for design in found.values():
        assert design.folder.is_dir()


@pytest.mark.parametrize("gamma", [float("inf"), float("nan")])
def test_a_design_that_keeps_no_bound_is_refused_and_not_written(
    gamma: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At an optimum a solver's rounding may leave matrices that certify nothing."""
    made = {"k.json": json.dumps({**NEW, "design": {"gamma": gamma}})}
    design = Shipped("drive.k", tmp_path, lambda: made)
    monkeypatch.setattr(redesign, "shipped_designs", lambda: {"drive.k": design})
    result = CliRunner().invoke(app, ["design", "drive.k", "--write"])
    assert result.exit_code != 0
    assert "keeps no bound" in result.output
    assert not (tmp_path / "k.json").exists()
