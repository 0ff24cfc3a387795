"""A foreign FMU of the same drive takes the plant's place."""

import json
import re
import zipfile
from pathlib import Path

import pytest
from systems import MODELS
from typer.testing import CliRunner

from fmus.archive import EXTRA
from fmus.build import build
from orchestrator.cli import app

PER_MM = 2 * 3.141592653589793 / 20
SCENARIO = "ball_screw_pole_placement/mc_ppc_track_500"
MAP = f"""\
u = {{ name = "motor_voltage", gain = -1 }}
d_2 = "table_force"
x_1 = {{ name = "screw", gain = {PER_MM!r}, unit = "rad" }}
x_2 = {{ name = "table", gain = {PER_MM!r}, unit = "rad" }}
"""
INLINE = ", ".join(MAP.splitlines())


@pytest.fixture
def supplied(tmp_path: Path) -> Path:
    """Our plant under other names, in mm, with the sign flipped and a fixed step."""
    theirs = tmp_path / "their.fmu"
    built = build(str(MODELS / "disguised.py"))
    with zipfile.ZipFile(built) as old, zipfile.ZipFile(theirs, "w") as new:
        for item in old.infolist():
            if item.filename == EXTRA:
                continue
            content = old.read(item)
            if item.filename == "modelDescription.xml":
                text = content.decode()
                step = 'canHandleVariableCommunicationStepSize="true"'
                assert step in text
                content = text.replace(step, step.replace("true", "false")).encode()
            new.writestr(item, content)
    return theirs


def figures(*arguments: str) -> dict[str, float]:
    result = CliRunner().invoke(app, ["run", SCENARIO, "--json", *arguments])
    assert result.exit_code == 0, result.output
    metrics = json.loads(result.stdout)["metrics"]
    return {name: figure["value"] for name, figure in metrics.items()}


@pytest.mark.parametrize("written", ["file", "inline", "lines"])
def test_a_disguised_plant_gives_the_same_figures(
    supplied: Path, tmp_path: Path, written: str
) -> None:
    table = tmp_path / "map.toml"
    table.write_text(MAP)
    chosen = {"file": str(table), "inline": INLINE, "lines": MAP}[written]
    ours = figures("-o", str(tmp_path / "ours"))
    theirs = figures(
        *("--swap", f"plant={supplied}", "--map", chosen),
        *("-o", str(tmp_path / "theirs")),
    )
    assert theirs["tracking.peak"] == pytest.approx(ours["tracking.peak"], abs=1e-6)
    assert theirs["u.peak"] == pytest.approx(ours["u.peak"], abs=1e-6)


def test_the_report_of_a_swap_shows_the_map_and_which_run_is_which(
    supplied: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "runs"
    chosen = ("--swap", f"plant={supplied}", "--map", INLINE, "-o", str(folder))
    figures(*chosen, "--set", "stop=0.1")
    page = (folder / "report.html").read_text()
    assert [f"{name}: {SCENARIO}" for name in ("original", "swapped")] == re.findall(
        r"<h2>How it was computed: (.*?)</h2>", page
    )
    before, _, after = page.partition("<h2>How it was computed: swapped")
    assert "<h3>Map of" not in before
    assert "<h3>Map of plant to" in after
    rows = re.findall("<tr>(.*?)</tr>", after.partition("<h3>Map of")[2])
    assert [re.findall("<td>(.*?)</td>", row) for row in rows[1:]] == [
        ["u", "V", "input", "motor_voltage", "V", "motor_voltage = -u"],
        ["d_2", "V", "input", "table_force", "V", "table_force = d_2"],
        ["x_1", "rad", "output", "screw", "mm", "x_1 = 0.314159265 screw"],
        ["x_2", "rad", "output", "table", "mm", "x_2 = 0.314159265 table"],
    ]


def test_units_that_do_not_fit_are_refused_with_the_remedy(supplied: Path) -> None:
    careless = INLINE.replace(', unit = "rad"', "")
    result = CliRunner().invoke(
        app, ["run", SCENARIO, "--swap", f"plant={supplied}", "--map", careless]
    )
    assert result.exit_code == 2
    assert "mm cannot become rad" in " ".join(result.output.split())


def test_a_fixed_step_and_a_stop_it_cannot_meet_are_refused(supplied: Path) -> None:
    result = CliRunner().invoke(
        app,
        [
            *("run", SCENARIO, "--swap", f"plant={supplied}", "--map", INLINE),
            *("--set", "stop=0.100025"),
        ],
    )
    assert result.exit_code == 2
    assert "nearest stops are 1/10 and 2001/20000 s" in " ".join(result.output.split())


@pytest.mark.parametrize(
    ("careless", "said"),
    [
        (INLINE.replace('"screw"', '"scrw"'), "map: x_1 is 'scrw' there.* 'screw'"),
        (
            INLINE.replace("x_1 = ", "x1 = "),
            "nothing feeds encoder.x_1 any more, which x_1 of the original fed",
        ),
        (INLINE.partition(", x_1")[0] + INLINE[INLINE.index(", x_2") :], "encoder.x_1"),
    ],
)
def test_a_map_that_would_open_the_loop_is_refused(
    supplied: Path, careless: str, said: str
) -> None:
    swap = ("--swap", f"plant={supplied}", "--map", careless)
    result = CliRunner().invoke(app, ["run", SCENARIO, *swap])
    assert result.exit_code == 2
    assert re.search(said, " ".join(result.output.split()))


def test_what_is_set_on_a_swapped_component_holds_for_the_original(
    supplied: Path, tmp_path: Path
) -> None:
    swap = ("--swap", f"plant={supplied}", "--map", INLINE, "-o", str(tmp_path / "x"))
    sets = ("--set", "plant.step=1/30000", "--set", "plant.drive.m_2=0.5e-3")
    result = CliRunner().invoke(app, ["run", SCENARIO, *swap, *sets])
    assert result.exit_code == 0, result.output
    assert "original: without --set plant.drive.m_2=0.5e-3" in result.output
    lock = (tmp_path / "x" / "original" / "scenario.lock.toml").read_text()
    assert "1/30000" in lock
