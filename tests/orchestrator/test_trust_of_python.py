"""What docs/trust.md says is executed, and nothing else."""

import ctypes
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from broken import MISBEHAVES, pack
from typer.testing import CliRunner

from fmus.allowed import only_project, project, refusal
from orchestrator.cli import app
from orchestrator.scenario.design import find_function

Command = Callable[..., tuple[int, str]]
MODEL = Path(__file__).parents[1] / "fmus" / "small_models" / "pi.py"
SCENARIO = """
stop = "1/100"
[components.pi]
fmu = "{fmu}"
{more}
[record]
"pi.u" = true
"""
DESIGN = '[design.x]\ncall = "{}"\narguments = {{ {} }}\nsets = ["pi"]\n'


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Command:
    """Run a command in a project, beside which a stranger's folder lies."""
    for name in ("project", "stranger"):
        (tmp_path / name).mkdir()
    (tmp_path / "project" / "pyproject.toml").touch()
    monkeypatch.chdir(tmp_path / "project")

    def ran(*words: str) -> tuple[int, str]:
        done = CliRunner().invoke(app, list(words))
        return done.exit_code, " ".join(done.output.split())

    return ran


def written(folder: Path, fmu: str = "pi.py", more: str = "") -> str:
    text = MODEL.read_text() + "\nfrom pathlib import Path\n"
    (folder / "pi.py").write_text(text)
    (folder / "s.toml").write_text(SCENARIO.format(fmu=fmu, more=more))
    return str(folder / "s.toml")


def test_a_model_of_the_project_is_executed_a_strangers_only_if_trusted(
    command: Command, tmp_path: Path
) -> None:
    stranger = written(tmp_path / "stranger")
    for verb in ("run", "schedule"):
        code, told = command(verb, stranger)
        assert code == 2
        assert "lies neither in feeddrive nor in the project" in told
        assert "--trust" in told
    assert command("schedule", stranger, "--trust")[0] == 0
    assert command("schedule", written(tmp_path / "project"))[0] == 0
    (tmp_path / "project" / "link").symlink_to(tmp_path / "stranger")
    assert command("schedule", "link/s.toml")[0] == 2


@pytest.mark.parametrize(
    "call", ["os:system", "numpy:save", "builtins:exec", "fmus.build:build"]
)
def test_a_dotted_name_that_is_neither_is_refused(
    command: Command, tmp_path: Path, call: str
) -> None:
    """schedule carries none of them out, whatever they are."""
    design = DESIGN.format(call, 'command = "touch ran"')
    scenario = written(tmp_path / "project", more=design)
    code, told = command("run", scenario)
    assert code == 2
    assert "design.x: call = " in told
    assert command("schedule", scenario)[0] == 0
    assert not Path("ran").exists()


def test_what_ours_imported_is_not_ours() -> None:
    from orchestrator.errors import DesignError

    ours = "controllers.synthesis.ball_screw.pole_placement"
    assert callable(find_function(f"{ours}:design"))
    for call in ("controllers.synthesis.ball_screw_lpv.designs:Path", "fmus.own:Path"):
        with pytest.raises(DesignError, match="no design function; those are of"):
            find_function(call)


def test_the_rule_holds_in_commands_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert project() == tmp_path.resolve()
    assert refusal("os") is None
    with only_project():
        assert refusal("os") is not None
        assert refusal("numpy") is not None
        assert refusal("/elsewhere/model.py") is not None
        assert refusal(str(tmp_path / "model.py")) is None
        assert refusal("plants.xy_table.axis") is None
        assert refusal("no_such_module_anywhere.x") is None  # said by the import
    assert refusal("os") is None


@pytest.mark.parametrize("words", [["info"], ["check", "--static"]])
def test_reading_an_fmu_executes_nothing_of_it(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fmu = pack("misbehaves", MISBEHAVES, tmp_path)

    def forbidden(*_: Any, **__: Any) -> None:
        raise AssertionError("something of the FMU is executed")

    monkeypatch.setattr(subprocess, "Popen", forbidden)
    monkeypatch.setattr(ctypes, "CDLL", forbidden)
    if sys.platform != "win32":
        monkeypatch.setattr("os.fork", forbidden)
    monkeypatch.setattr("multiprocessing.process.BaseProcess.start", forbidden)
    told = CliRunner().invoke(app, [*words, str(fmu)])
    assert told.exit_code in (0, 1)  # it has findings
    assert "Misbehaves" in told.output or "misbehaves.fmu" in told.output
    assert "a fault" not in told.output
