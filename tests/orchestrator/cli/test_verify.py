"""``verify`` finds every bit of an FMU of ours that its sources do not make."""

import json
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fmus.build import build
from orchestrator.cli import app

MODULE = "controllers.xy_table.speed_pi"


def altered(fmu: Path, target: Path, what: str) -> Path:
    """Copy an FMU in which one bit of a file is another."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            content = bytearray(old.read(name))
            if name.startswith(what):
                content[len(content) // 2] ^= 1
            new.writestr(name, bytes(content))
    return target


def verified(fmu: Path) -> tuple[int, dict[str, str]]:
    done = CliRunner().invoke(app, ["verify", str(fmu), "--json"])
    told = json.loads(done.stdout)
    return done.exit_code, {f["file"]: f["verdict"] for f in told["files"]}


def test_an_fmu_of_ours_is_what_its_sources_make() -> None:
    code, verdicts = verified(build(MODULE, fmi=3))
    assert code == 0
    assert set(verdicts.values()) == {"the same"}
    assert any(name.startswith("binaries/") for name in verdicts)


@pytest.mark.parametrize("what", ["binaries/", "documentation/index.html"])
def test_what_was_altered_is_named(what: str, tmp_path: Path) -> None:
    code, verdicts = verified(altered(build(MODULE), tmp_path / "x.fmu", what))
    (wrong,) = (name for name, verdict in verdicts.items() if verdict == "differs")
    assert wrong.startswith(what)
    assert code == 1


def test_what_has_no_sources_of_ours_is_refused(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["verify", str(build(MODULE, kind="python"))])
    assert done.exit_code == 2
    assert "has no C sources of ours" in done.output
