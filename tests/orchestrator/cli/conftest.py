"""The command in a folder of its own."""

from pathlib import Path

import pytest
from command import DRIVE
from typer.testing import CliRunner

from orchestrator.cli import app


@pytest.fixture
def feeddrive(tmp_path, monkeypatch):
    """Run the command in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    return lambda *arguments: CliRunner().invoke(app, [str(a) for a in arguments])


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    file = tmp_path / "drive.toml"
    file.write_text(DRIVE)
    return file
