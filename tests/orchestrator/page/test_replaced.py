"""What a design is told stays as it was when an FMU of others is put in place."""

from types import SimpleNamespace

from orchestrator.page.document import Editor
from orchestrator.page.edits import EDITS
from orchestrator.page.project import Project
from orchestrator.page.views import told_as_numbers
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

DEMO = "ball_screw_pole_placement/mc_ppc_track_500"


def test_a_design_is_told_the_same_numbers_behind_a_replacement(
    site: SimpleNamespace,
) -> None:
    kept = compose(load_scenario(DEMO), run_earlier)
    numbers = told_as_numbers(kept, "plant")
    told = {one["argument"]: one["value"] for one in numbers}
    assert sorted(told) == ["b_1", "b_2", "c", "k", "m_1", "m_2"]
    assert told["m_2"] == kept.parameter("plant.m_2").value
    folder = site.folder / "replaced"
    folder.mkdir(exist_ok=True)
    (folder / "their.fmu").write_bytes(b"")
    file = folder / "mine.toml"
    file.write_text(f'base = "{DEMO}"\n')
    said = {"name": "plant", "fmu": "replaced/their.fmu", "numbers": numbers}
    with Editor().changing(file) as document:
        EDITS["replace"](Project(site.folder), document, said)
    spec = load_scenario(file).spec
    assert {n: spec.design["gains"].arguments[n] for n in told} == told
    assert spec.design["gains"].arguments["beta"] == 4
