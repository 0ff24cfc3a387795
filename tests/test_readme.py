"""What the README and the docs say to type works as it stands there."""

import json
import re
import tomllib
from pathlib import Path

import pytest
from printed import blocks, typed

from fmus.build import build
from orchestrator.scenario.reading import load_scenario

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


COMMANDS = [
    line for block in blocks(README, "bash") for line in block.splitlines() if line
]


SWAP = [c for c in COMMANDS if "their" in c]
ALONE = [c for c in COMMANDS if c.startswith("feeddrive") and c not in SWAP]


@pytest.mark.parametrize("line", ALONE)
def test_a_command_of_the_readme_runs(line: str, tmp_path: Path) -> None:
    typed(line, tmp_path)


HOLD = (ROOT / "docs" / "does-it-hold.md").read_text()


def hold(folder: Path) -> None:
    """Put the example of docs/does-it-hold.md into a folder."""
    example = ROOT / "docs" / "examples" / "does_it_hold" / "drive.toml"
    text = example.read_text().replace("../../../", f"{ROOT.as_posix()}/")
    (folder / "drive.toml").write_text(text)


@pytest.mark.parametrize(
    "line", [c for b in blocks(HOLD, "bash") for c in b.splitlines() if c]
)
def test_a_command_of_does_it_hold_runs(line: str, tmp_path: Path) -> None:
    hold(tmp_path)
    typed(line, tmp_path)


def test_the_python_of_does_it_hold_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    hold(tmp_path)
    (session,) = blocks(HOLD, "python")
    exec(session, {})


def test_the_swap_of_the_readme_runs_as_printed(tmp_path: Path) -> None:
    """A foreign FMU in the plant's place by the map that is proposed and measured."""
    build_it, propose, swap = SWAP
    typed(build_it, tmp_path)
    assert "proposed and not applied" in typed(propose, tmp_path)
    written = tomllib.loads((tmp_path / "map.toml").read_text())
    printed = tomllib.loads(blocks(README, "toml")[0])
    assert {name: written[name] for name in printed} == printed
    told = json.loads(typed(f"{swap} --json", tmp_path))
    assert (told["not_taken_over"], told["warnings"]) == ([], [])
    for name in ("tracking.peak", "tracking.rms", "u.peak"):
        ours, theirs = (told[run][name]["value"] for run in ("original", "metrics"))
        assert theirs == pytest.approx(ours, rel=1e-6), name


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
