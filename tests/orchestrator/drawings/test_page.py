"""The page of a study: all figures, what is not drawn, the tables beside ours."""

from pathlib import Path

import numpy as np
import pytest
from rope_study import SCENARIO

from orchestrator.drawings.making import Maker
from orchestrator.drawings.page import write_figures
from orchestrator.drawings.registry import read_registry
from orchestrator.errors import FeedDriveError
from orchestrator.reproduction.reproduce import reproduce
from orchestrator.session import run

REFERENCE = """
title = "A small study"
source = "Nobody, 2026"
[[table]]
title = "Pulls"
where = "Table 1"
id = "pull.{row}"
scenario = "snap"
metric = "pull.peak"
unit = "V"
class = "derived"
columns = [{ name = "pull" }]
rows = [{ name = "one", published = [1.0] }]
"""
FIGURES = """
[not_drawn]
fig_1 = "photograph & sketch"
[fig_2]
title = "The table moves"
obtained = "measured"
scenario = "snap"
columns = 2
[[fig_2.panels]]
y = { label = "displacement", unit = "mrad" }
curves = [{ name = "x", of = "plant.x_2" }]
marks = [{ x = 0.005, text = "half" }]
[[fig_2.panels]]
x = { label = "pull", unit = "V" }
y = { label = "largest", unit = "V" }
curves = [
  { vary = "rope.d_0", values = [1, 2], of = "pull.peak", style = "points" },
  { rows = ["pull.one"], at = [1] },
  { x_data = [1, 2], y_data = [1, 2], style = "dashed" },
]
marks = [{ x = 1, y = "pull.one" }]
[[fig_2.panels]]
y = { label = "rate", unit = "mrad/s" }
curves = [{ of = "plant.x_2", show = "rate" }]
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    (tmp_path / "snap.toml").write_text(SCENARIO)
    (tmp_path / "reference.toml").write_text(REFERENCE)
    (tmp_path / "figures.toml").write_text(FIGURES)
    return tmp_path


def test_the_page_has_every_figure_reason_and_table(study: Path) -> None:
    done = reproduce(study, folder=study / "runs")
    drawn: list[str] = []
    file = write_figures(
        read_registry(study), done, study / "page.html", told=drawn.append
    )
    page = file.read_text()
    assert drawn == ["fig_2"]
    assert page.count("<svg") == 1
    assert "photograph &amp; sketch" in page
    assert "Table 1: Pulls (V)" in page
    assert "<td>1.0<td class='agrees'>1</tr>" in page


def test_curves_of_every_source_are_in_the_units_of_the_axes(study: Path) -> None:
    registry = read_registry(study)
    maker = Maker(study, study / "made", {"pull.one": 1.5})
    (moved,) = maker.curves(registry.figures["fig_2"].panels[0])
    swept, row, printed = maker.curves(registry.figures["fig_2"].panels[1])
    recorded = run(study / "snap.toml", study / "run", report=False)["plant.x_2"]
    np.testing.assert_allclose(moved.y, 1e3 * recorded.values, rtol=1e-12)
    assert (swept.x.tolist(), swept.y.tolist()) == ([1, 2], [1, 2])
    assert (row.x.tolist(), row.y.tolist()) == ([1], [1.5])
    assert printed.y.tolist() == [1, 2]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('of = "plant.x_2" }', 'of = "plant.x_3" }'), "plant.x_3"),
        (('["pull.one"]', '["pull.two"]'), "pull.two"),
        (('of = "pull.peak"', 'of = "pull.peek"'), "pull.peek"),
        (('unit = "mrad"', 'unit = "V"'), "different quantities"),
    ],
)
def test_what_a_curve_lacks_is_named(
    study: Path, change: tuple[str, str], said: str
) -> None:
    (study / "figures.toml").write_text(FIGURES.replace(*change))
    done = reproduce(study, folder=study / "runs")
    with pytest.raises((FeedDriveError, ValueError), match=said):
        write_figures(read_registry(study), done, study / "page.html")
