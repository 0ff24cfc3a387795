"""A new project runs at once, and a doctor says whether it can."""

import json
import re
import shlex
from pathlib import Path

from command import refused

from fmus.compile import CompileError
from orchestrator.cli import app
from orchestrator.supplied import PROJECT


def test_a_new_project_does_what_its_readme_says(feeddrive, monkeypatch) -> None:
    made = json.loads(feeddrive("new", "mine", "--json").stdout)
    assert "models/motor.py" in made["files"]
    assert not any("__pycache__" in name for name in made["files"])
    monkeypatch.chdir("mine")
    lines = re.findall(
        r"^feeddrive (.*?)(?:  +#.*)?$", Path("README.md").read_text(), re.M
    )
    assert len(lines) == 5
    for line in lines:
        done = feeddrive(*shlex.split(line))
        assert done.exit_code == 0, (line, done.output)
    assert len(list(Path("runs").rglob("metrics.json"))) == 2
    assert Path("wiring.svg").is_file()
    assert [f.suffix for f in Path("fmus").rglob("*") if f.is_file()] == [".fmu"]


def test_what_is_there_is_not_written_over(feeddrive) -> None:
    Path("mine").mkdir()
    Path("mine/x").write_text("mine")
    refused(feeddrive("new", "mine"), "mine", "not empty")
    Path("empty").mkdir()
    assert "next: cd empty" in feeddrive("new", "empty").stdout
    assert (PROJECT / "README.md").read_text() == Path("empty/README.md").read_text()


def test_the_doctor_finds_this_machine_healthy(feeddrive) -> None:
    done = feeddrive("doctor", "--json")
    told = json.loads(done.stdout)
    assert told["healthy"], told
    assert done.exit_code == 0
    states = {f["what"]: f["state"] for f in told["findings"]}
    assert states["compiler"] == states["kernel"] == states["cache"] == "ok"
    assert "peer fmpy" in states


def test_the_doctor_says_what_fails_and_goes_on(feeddrive, monkeypatch) -> None:
    def broken(*_: object) -> None:
        raise CompileError("ziglang is not installed")

    monkeypatch.setattr("fmus.compile.compile_alone", broken)
    done = feeddrive("doctor")
    assert done.exit_code == 1
    assert re.search(r"compiler +FAILS +CompileError: ziglang", done.stdout)
    assert re.search(r"cache +ok", done.stdout)


def test_every_verb_has_its_line_of_help(feeddrive) -> None:
    for name in ("new", "doctor", "compare", "plot", "wiring"):
        assert any(c.callback.__name__ == name for c in app.registered_commands)
        assert feeddrive(name, "--help").exit_code == 0
