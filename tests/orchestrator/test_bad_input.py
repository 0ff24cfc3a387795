"""Hostile files are refused in one sentence, before they take time or memory."""

import os
import subprocess
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path

import pytest
from systems import part, system
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import FeedDriveError, FmuError, ScenarioError, shown
from orchestrator.fmu.archive import MAX_TEXT
from orchestrator.fmu.description import read_fmu
from orchestrator.master.simulate import plan
from orchestrator.scenario.reading import load_scenario, read_scenario
from orchestrator.scenario.toml import toml

pytest_plugins = ["pytester"]
FMU = "plants.ball_screw.two_mass"
SOUND = f'stop = "1/100"\n[components.a]\nfmu = "{FMU}"\nstep = "1/1000"\n'
HOSTILE = {
    "arrays in arrays": "a = " + "[" * 5000 + "]" * 5000,
    "tables in tables": "a = " + "{a=" * 400 + "1" + "}" * 400,
    "a key of many parts": ".".join(["a"] * 50_000) + " = 1",
    "quoted parts": ".".join(['"a"'] * 5_000) + " = 1",
    "digits of a whole number": "stop = " + "1" * 10_000,
    "digits behind the point": "stop = 0." + "3" * 100_000,
    "a NUL": 'base = "a\\u0000b"',
    "no TOML": "stop = = 1",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_toml_is_refused_by_its_name(name: str, tmp_path: Path) -> None:
    file = tmp_path / "hostile.toml"
    file.write_text(HOSTILE[name] + "\n" + SOUND, encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"hostile\.toml: not valid TOML: "):
        load_scenario(file)


def test_sound_toml_is_within_the_bounds() -> None:
    text = SOUND + '[components.a.parameters]\n"m.1.2" = 0.12345678901234567890\n'
    assert toml(text)["components"]["a"]["parameters"] == {"m.1.2": 0.12345678901234568}


@pytest.mark.parametrize(
    ("unit", "said"),
    [
        ("(" * 3000 + "kg" + ")" * 3000, "longer than 200 characters"),
        ("kg^99999999", "an exponent beyond 99"),
        (".".join(["km99"] * 20), "a factor beyond all numbers"),
    ],
)
def test_deep_units_are_refused(unit: str, said: str) -> None:
    from fmus.units import UnitError, base_unit

    with pytest.raises(UnitError, match=said):
        base_unit(unit)


def test_a_diamond_of_bases_is_read_once_each(tmp_path: Path) -> None:
    """20 levels of two are 2^20 ways to the lowest."""
    (tmp_path / "a0.toml").write_text(SOUND)
    for level in range(1, 21):
        (tmp_path / f"b{level}.toml").write_text(f'base = "a{level - 1}.toml"\n')
        bases = f'["b{level}.toml", "a{level - 1}.toml"]'
        (tmp_path / f"a{level}.toml").write_text(f"base = {bases}\nfmi = 3\n")
    tables = read_scenario(tmp_path / "a20.toml")
    assert (tables["stop"], tables["fmi"]) == ("1/100", 3)


def test_an_endless_row_of_heirs_is_refused(tmp_path: Path) -> None:
    (tmp_path / "0.toml").write_text(SOUND)
    for level in range(1, 60):
        (tmp_path / f"{level}.toml").write_text(f'base = "{level - 1}.toml"\n')
    with pytest.raises(ScenarioError, match="more than 50 files inherit in a row"):
        load_scenario(tmp_path / "59.toml")


def test_a_latency_without_room_is_refused_before_it_is_taken() -> None:
    slow = part("slow", "counter", "1/1000", latency=10**13)
    with pytest.raises(FeedDriveError, match=r"slow\.latency: 10000000000000 samples"):
        plan(system("1/100", [slow], record={"slow.k": "1/1000"}))


VARIABLE = (
    '<Float64 name="y" valueReference="1" causality="output" variability="continuous"'
    " {}>{}</Float64>"
)
DESCRIPTION = (
    '<?xml version="1.0"?>{}<fmiModelDescription fmiVersion="3.0" '
    'instantiationToken="x" modelName="m"><CoSimulation modelIdentifier="m" {}/>'
    "<ModelVariables>{}</ModelVariables><ModelStructure>"
    '<Output valueReference="1"/></ModelStructure></fmiModelDescription>'
)


def described(
    folder: Path,
    attributes: str = "",
    variable: str = "",
    inside: str = "",
    head: str = "",
) -> Path:
    text = DESCRIPTION.format(head, attributes, VARIABLE.format(variable, inside))
    fmu = folder / "m.fmu"
    with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", text)
    return fmu


BOMB = (
    "<!DOCTYPE x ["
    + "".join(
        f'<!ENTITY e{n} "{f"&e{n - 1};" * 10 if n else "bomb" * 10}">'
        for n in range(12)
    )
    + "]>"
)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"attributes": 'fixedInternalStepSize="soon"'}, "cannot be understood"),
        ({"attributes": 'fixedInternalStepSize="1e999999999"'}, "cannot be understood"),
        ({"inside": '<Dimension start="4000000000"/>'}, "4000000000 numbers; at most"),
        ({"inside": '<Dimension start="many"/>'}, "dimension of many"),
        ({"variable": 'declaredType="none"'}, "cannot be understood"),
        ({"head": BOMB, "variable": 'description="&e11;"'}, "cannot be understood"),
    ],
)
def test_descriptions_that_lie_are_refused(
    wrong: Mapping[str, str], said: str, tmp_path: Path
) -> None:
    with pytest.raises(FmuError, match=rf"m\.fmu.*{said}"):
        read_fmu(described(tmp_path, **wrong))


def test_a_description_of_gigabytes_is_not_unpacked(tmp_path: Path) -> None:
    fmu = described(tmp_path, inside="<!--" + " " * MAX_TEXT + "-->")
    assert fmu.stat().st_size < 100_000
    with pytest.raises(FmuError, match=r"modelDescription\.xml has 34 MB unpacked"):
        read_fmu(fmu)
    told = CliRunner().invoke(app, ["check", "--static", str(fmu)])
    assert told.exit_code == 1
    assert "has 34 MB unpacked" in told.output


def test_one_hostile_file_does_not_hinder_the_collection_of_others(
    pytester: pytest.Pytester,
) -> None:
    for number, text in enumerate(HOSTILE.values()):
        pytester.path.joinpath(f"h{number}.toml").write_text(text + "\n" + SOUND)
    pytester.path.joinpath("loop.toml").write_text('base = "loop.toml"\n')
    pytester.path.joinpath("fifo.toml").write_text('base = "pipe"\n')
    if hasattr(os, "mkfifo"):
        os.mkfifo(pytester.path / "pipe")
    expects = (
        '[record]\n"a.x_1" = true\n[metrics]\nx = { kind = "max", of = "a.x_1" }\n'
    )
    expects += '[expect]\n"x.max" = { below = 1.0 }\n'
    pytester.path.joinpath("sound.toml").write_text(SOUND + expects)
    pytester.path.joinpath("wrong.toml").write_text(HOSTILE["no TOML"] + expects)
    done = pytester.runpytest_subprocess("-q", "--collect-only")
    assert done.ret == 0
    listed = {line for line in done.outlines if "::" in line}
    assert listed == {"sound.toml::expect", "wrong.toml::expect"}


EVIL = "a\x1b[2J\x9b1m\u202eb\x07\r\udcff"


def test_what_steers_a_terminal_is_shown() -> None:
    assert shown(EVIL) == "a\\x1b[2J\\x9b1m\\u202eb\\x07\\r\\udcff"
    assert shown("50 µs\n\t– ẋ\u00a0\u2009°") == "50 µs\n\t– ẋ\u00a0\u2009°"


@pytest.mark.parametrize("command", [["info"], ["check", "--static"]])
def test_texts_of_an_fmu_do_not_steer_the_terminal(
    command: list[str], tmp_path: Path
) -> None:
    evil = 'description="go &#x9b;1m &#x202e; ok"'
    fmu = described(tmp_path, variable=evil)
    told = CliRunner().invoke(app, [*command, str(fmu)]).output
    assert "\x9b" not in told
    assert "\u202e" not in told


def test_a_command_without_home_and_streams_says_or_does_what_it_should(
    tmp_path: Path,
) -> None:
    without = {
        k: v for k, v in os.environ.items() if k not in ("HOME", "XDG_CACHE_HOME")
    }
    command = [sys.executable, "-m", "orchestrator", "scenarios", "gantry"]
    closed = f"exec {' '.join(command)} >&- 2>&- <&-"
    done = subprocess.run(["sh", "-c", closed], env=without, check=False)
    assert done.returncode == 0


def test_a_name_that_is_no_utf_8_is_refused(tmp_path: Path) -> None:
    told = CliRunner().invoke(app, ["run", os.fsdecode(b"latin\xff.toml")])
    assert told.exit_code == 2
    assert "latin\\udcff.toml: this name is no UTF-8" in told.output


def test_without_a_home_the_cache_asks_for_a_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    import platformdirs

    from fmus.cache import cache_folder

    def none(name: str) -> Path:
        raise RuntimeError("no home")

    monkeypatch.delenv("FEEDDRIVE_CACHE")
    monkeypatch.setattr(platformdirs, "user_cache_path", none)
    told = CliRunner().invoke(app, ["info", FMU])
    assert told.exit_code == 1
    assert "FEEDDRIVE_CACHE: this user has no home folder" in told.output
    with pytest.raises(OSError, match="no home folder"):
        cache_folder()
