"""A scenario's file is changed in place: what was not meant stays as it was written."""

from pathlib import Path

import pytest

from orchestrator.errors import FeedDriveError, ScenarioError
from orchestrator.page.document import Editor
from orchestrator.page.edits import EDITS
from orchestrator.page.project import Project

BASE = """stop = "0.1"   # seconds

[components.controller]
fmu = "../models/speed_pi.py"         # mine
step = "1/4000"
parameters = { K_p = 0.5 }            # from the bench

[components.motor]
fmu = "../models/motor.py"
step = "1/4000"

[connections]
"controller.omega_r" = 100.0
"controller.omega" = "motor.omega"    # the encoder is ideal
"""
HEIR = 'base = "own.toml"\n\n[components.motor]\nparameters = { J = 2e-3 }\n'


@pytest.fixture
def own(site) -> Path:
    folder = site.folder / "edited"
    folder.mkdir(exist_ok=True)
    (folder / "own.toml").write_text(BASE)
    (folder / "heir.toml").write_text(HEIR)
    return folder / "own.toml"


def edited(file: Path, do: str, **said) -> list[str]:
    """Return the lines that an edit took out (-) and put in (+)."""
    before = file.read_text().splitlines()
    with Editor().changing(file) as document:
        EDITS[do](Project(file.parents[1]), document, said)
    after = file.read_text().splitlines()
    gone = [f"-{line}" for line in before if line not in after]
    return gone + [f"+{line}" for line in after if line not in before]


def test_an_edit_changes_its_line_alone(own: Path) -> None:
    edit = {"source": "controller.i", "sink": "motor.i"}
    assert edited(own, "connect", **edit) == ['+"motor.i" = "controller.i"']
    gone = '-"controller.omega" = "motor.omega"    # the encoder is ideal'
    assert edited(own, "disconnect", sink="controller.omega") == [gone]
    kept = "parameters = { K_p = {} }            # from the bench"
    assert edited(own, "values", settings={"controller.K_p": 0.75}) == [
        "-" + kept.replace("{}", "0.5"),
        "+" + kept.replace("{}", "0.75"),
    ]
    assert edited(own, "times", name="motor", key="step", value="1/8000") == [
        '+step = "1/8000"'
    ]
    assert edited(own, "record", signal="motor.omega", on=True) == [
        "+[record]",
        '+"motor.omega" = true',
    ]


def test_what_is_inherited_is_written_as_removed(own: Path) -> None:
    heir = own.with_name("heir.toml")
    assert edited(heir, "disconnect", sink="controller.omega") == [
        "+[connections]",
        '+"controller.omega" = false',
    ]
    with pytest.raises(ScenarioError, match="is inherited from a base; change it ther"):
        edited(heir, "times", name="motor", key="step", value="")


@pytest.mark.parametrize(
    ("do", "said", "why"),
    [
        ("connect", {"source": "motor.omega", "sink": "motor.i"}, "A"),
        ("connect", {"source": "motor.omega", "sink": "motor.x"}, "has no variable"),
        ("connect", {"source": "x.y", "sink": "motor.i"}, "no component 'x'"),
        ("connect", {"source": "controller.i"}, "sink is missing"),
        ("disconnect", {"sink": "motor.tau_L"}, "with a star"),
        ("times", {"name": "motor", "key": "step", "value": "soon"}, "not written"),
        ("times", {"name": "motor", "key": "fmu", "value": "x"}, "none of step"),
        ("add", {"name": "a b", "fmu": "plants.x"}, "is no name"),
        ("add", {"name": "a", "fmu": "../../../etc/x.fmu"}, "lies outside"),
        ("add", {"name": "motor", "fmu": "x"}, "already"),
        ("remap", {"name": "motor", "map": "a ="}, "not valid TOML"),
        ("values", {"settings": {"x.y": 1.0}}, "no component 'x'"),
    ],
)
def test_what_does_not_fit_is_refused_and_nothing_is_written(
    own: Path, do: str, said: dict, why: str
) -> None:
    with pytest.raises(FeedDriveError, match=why):
        edited(own, do, **said)
    assert own.read_text() == BASE
    assert sorted(p.name for p in own.parent.iterdir()) == ["heir.toml", "own.toml"]


def test_changes_are_taken_back_one_by_one_and_those_of_others_stay(own: Path) -> None:
    editor = Editor()
    for value in (1.0, 2.0):
        with editor.changing(own) as document:
            said = {"settings": {"motor.J": value}}
            EDITS["values"](Project(own.parents[1]), document, said)
    editor.undo(own)
    assert "J = 1.0" in own.read_text()
    editor.undo(own)
    assert own.read_text() == BASE
    with pytest.raises(ScenarioError, match="nothing was changed here"):
        editor.undo(own)


def test_a_component_is_removed_with_all_that_names_it(own: Path) -> None:
    edited(own, "connect", source="controller.i", sink="motor.i")
    edited(own, "remove", name="motor")
    assert "motor" not in own.read_text()
