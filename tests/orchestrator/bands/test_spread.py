"""Bands: a sweep over what is not known, the published value inside or not."""

from pathlib import Path

import pytest
from rope_study import SCENARIO

from orchestrator.bands.spread import bands, read_bands
from orchestrator.errors import ScenarioError
from orchestrator.reproduction.reference import read_reference
from orchestrator.scenario.reading import find_study, studies

ROW = """
[[figure]]
id = "{id}"
where = "Table 1"
published = {published}
unit = "V"
class = "derived"
scenario = "snap"
metric = "pull.peak"
"""
BAND = """
[snap]
scenario = "snap"
members = 4
rows = { low = "pull.peak", high = "pull.peak", bound = "pull.peak" }
unknown = [{ keys = ["rope.d_0"], between = [1, 2], why = "the pull" }]
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    (tmp_path / "snap.toml").write_text(SCENARIO)
    rows = [("low", "1.5"), ("high", "3.0"), ("bound", "{ below = 1.1 }")]
    text = "".join(ROW.format(id=i, published=p) for i, p in rows)
    (tmp_path / "reference.toml").write_text(text)
    (tmp_path / "bands.toml").write_text(BAND)
    return tmp_path


def test_a_band_goes_from_the_least_to_the_largest_of_the_members(study: Path) -> None:
    low, high, bound = bands(study)
    assert 1 <= low.low < 1.2 < 1.8 < low.high <= 2
    assert (low.inside, high.inside) == (True, False)
    assert bound.inside == (bound.low < 1.1)
    assert low.members == 4
    assert low.failed == 0
    assert bands(study)[0].low == low.low


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("low = ", "lwo = "), "lwo"),
        (('low = "pull.peak"', 'low = "pull.peek"'), "pull.peek"),
        (("why", "because"), "because"),
    ],
)
def test_what_is_written_wrongly_is_named(
    study: Path, change: tuple[str, str], said: str
) -> None:
    (study / "bands.toml").write_text(BAND.replace(*change))
    with pytest.raises(ScenarioError) as refused:
        bands(study)
    assert said in str(refused.value)


@pytest.mark.parametrize("folder", studies(), ids=lambda f: f.name)
def test_bands_of_a_study_are_of_its_own_rows_and_scenarios(folder: Path) -> None:
    rows = read_reference(folder / "reference.toml").figures
    for spread in read_bands(folder).values():
        assert spread.rows.keys() <= rows.keys()
        assert (folder / f"{spread.scenario}.toml").exists()


def test_the_three_that_were_asked_for_have_bands() -> None:
    found = {
        row
        for study in ("ball_screw_pole_placement", "leadscrew_nctf", "gantry")
        for spread in read_bands(find_study(study)).values()
        for row in spread.rows
    }
    assert {
        "mc_ppc.track_500_prefilter.peak",
        "circle.nctf.5mm_1hz.x@guide",
        "circle_200.contour_max",
    } <= found


def test_a_row_that_is_compared_with_another_has_no_band(study: Path) -> None:
    """Whatever came out, it was inside."""
    file = study / "reference.toml"
    text = file.read_text().replace("{ below = 1.1 }", '{ less_than = "high" }')
    file.write_text(text)
    with pytest.raises(ScenarioError, match="bound is compared with high"):
        bands(study)
