"""The figures of the sources: every number is known, each can be drawn or says why.

The numbers are those of the sources' own lists: figures of a thesis are counted
within a chapter, letters belong to one figure.
"""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from effort import EFFORT
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.drawings.making import Maker
from orchestrator.drawings.page import write_figure
from orchestrator.drawings.registry import Registry, read_registry
from orchestrator.drawings.spectra import density, rate, spectrum
from orchestrator.errors import ScenarioError
from orchestrator.scenario.reading import find_study

NUMBERS: dict[str, dict[str, Sequence[int]]] = {
    "ball_screw_pole_placement": {"3_": range(1, 16)},
    "gantry": {"4_": range(1, 23)},
    "leadscrew_nctf": {
        "2_": range(1, 5),
        "3_": range(1, 15),
        "4_": range(1, 15),
        "5_": range(1, 10),
        "6_": range(1, 20),
        "7_": range(1, 6),
        "A_": range(1, 4),
    },
    # the source's numbers leave out 5 and 6
    "cascade_nppi": {"": [1, 2, 3, 4, 7, 8, 9, 10, 11]},
}
SAMPLE = {
    ("ball_screw_pole_placement", "fig_3_12"),
    ("ball_screw_pole_placement", "fig_3_14"),
    ("gantry", "fig_4_5"),
    ("cascade_nppi", "fig_8"),
    ("leadscrew_nctf", "fig_3_7"),
}


def registry(study: str) -> Registry:
    return read_registry(find_study(study))


DRAWN = [(study, number) for study in NUMBERS for number in registry(study).figures]


@pytest.mark.parametrize("study", NUMBERS)
def test_every_figure_of_the_source_is_drawn_or_says_why_not(study: str) -> None:
    found = registry(study)
    there = {f"fig_{chapter}{n}" for chapter, ns in NUMBERS[study].items() for n in ns}
    assert found.figures.keys() | found.not_drawn.keys() == there
    assert not found.figures.keys() & found.not_drawn.keys()
    assert all(found.not_drawn.values())


@pytest.mark.parametrize(("study", "number"), DRAWN)
def test_a_figure_is_drawn(study: str, number: str, tmp_path: Path) -> None:
    if not EFFORT.every and (study, number) not in SAMPLE:
        pytest.skip("--every-form draws all of them")
    file = write_figure(registry(study), number, tmp_path / "figure.svg")
    assert file.read_text().count("<path") > 10


def test_what_the_source_prints_is_marked_in_the_unit_of_the_axis(
    tmp_path: Path,
) -> None:
    found = registry("ball_screw_pole_placement")
    panel = found.figures["fig_3_12"].panels[2]
    shown = Maker(found.folder, tmp_path).shown(panel.marks[0], panel)
    assert shown.x == (145, 145)
    assert shown.y == (-0.0083, -0.0083)


def test_a_curve_of_the_traced_model_has_the_figure_of_the_table(
    tmp_path: Path,
) -> None:
    found = registry("ball_screw_pole_placement")
    panel = found.figures["fig_3_12"].panels[2]
    (curve,) = Maker(found.folder, tmp_path).curves(panel)
    lowest = np.argmin(curve.y)
    assert curve.y[lowest] == pytest.approx(-0.00989, rel=1e-3)
    assert curve.x[lowest] == pytest.approx(143.3, abs=0.2)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["gantri", "fig_4_9"], "gantry"),
        (["ball_screw_pole_placement", "fig_3_99"], "fig_3_9"),
        (["ball_screw_pole_placement", "fig_3_2"], "photograph"),
        (["ball_screw_pole_placement", "fig_3_6", "-o", "a.pdf"], ".svg"),
    ],
)
def test_what_cannot_be_drawn_is_refused(arguments: list[str], said: str) -> None:
    done = CliRunner().invoke(app, ["figure", *arguments])
    assert done.exit_code != 0
    assert said in done.output


def test_figures_are_listed_with_the_reasons_of_those_that_are_not_drawn() -> None:
    done = CliRunner().invoke(app, ["figure", "ball_screw_pole_placement", "--json"])
    told = json.loads(done.stdout)
    assert told["drawn"]["fig_3_11"]
    assert told["not_drawn"]["fig_3_2"] == "photograph"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("colums = 2", "columns"),
        ('panels = [{ y = {}, curves = [{ of = "a" }] }]', "scenario, vary"),
        ('panels = [{ y = {}, curves = [{ scenario = "a" }] }]', "of is missing"),
        ('base = "fig_9_9"', "fig_9_9"),
    ],
)
def test_a_wrong_key_names_file_and_figure(
    change: str, said: str, tmp_path: Path
) -> None:
    text = f'[fig_1_1]\ntitle = "a"\nobtained = "computed"\n{change}\n'
    (tmp_path / "figures.toml").write_text(text)
    with pytest.raises(ScenarioError) as refused:
        read_registry(tmp_path)
    assert said in str(refused.value)
    assert "fig_1_1" in str(refused.value)


def test_spectra_have_the_amplitude_and_the_variance_of_the_record() -> None:
    time = np.arange(2000) / 1000
    sine = 1.5 * np.sin(2 * np.pi * 50 * time) + 7
    hz, amplitude = spectrum(time, sine)
    assert amplitude[np.argmin(np.abs(hz - 50))] == pytest.approx(1.5)
    hz, root = density(time, sine)
    assert np.sum(root**2) * hz[0] == pytest.approx(np.var(sine))
    assert rate(time, 3 * time) == pytest.approx(3.0)
