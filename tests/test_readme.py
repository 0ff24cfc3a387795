"""What the README and the docs say to type works as it stands there."""

import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from systems import MODELS

from fmus.build import build
from orchestrator.scenario.reading import load_scenario

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


COMMANDS = [
    line for block in blocks(README, "bash") for line in block.splitlines() if line
]


@pytest.mark.parametrize("line", [c for c in COMMANDS if c.startswith("feeddrive")])
def test_a_command_of_the_readme_runs(line: str, tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text(blocks(README, "toml")[0])
    build(str(MODELS / "disguised.py"), folder=tmp_path).rename(tmp_path / "their.fmu")
    command = [sys.executable, "-m", "orchestrator", *shlex.split(line)[1:]]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_the_make_targets_of_the_readme_exist() -> None:
    makefile = (ROOT / "Makefile").read_text()
    named = re.findall(r"^make (\S+)", "\n".join(COMMANDS), re.MULTILINE)
    assert named == ["demo", "test"]
    assert all(f"\n{target}:" in makefile for target in named)


def test_the_python_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    model, session = blocks(README, "python")
    (tmp_path / "speed_pi.py").write_text('"""Speed PI. Source: README."""\n\n' + model)
    assert build(str(tmp_path / "speed_pi.py")).is_file()
    exec(session, {})


def test_the_scenario_of_the_docs_is_one(tmp_path: Path) -> None:
    scenario, *_ = blocks((ROOT / "docs" / "scenarios.md").read_text(), "toml")
    assert tomllib.loads(scenario)
    file = tmp_path / "scenario.toml"
    file.write_text(scenario)
    assert load_scenario(file).spec.components["controller"].latency == 1


def test_every_link_of_the_readme_leads_somewhere() -> None:
    links = re.findall(r"\]\(([^)]+)\)", README)
    assert [link for link in links if not (ROOT / link).exists()] == []
