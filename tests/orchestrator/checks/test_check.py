"""``check`` finds in foreign FMUs what is known of their exporters, and tells it."""

import json
import re
import tomllib
from pathlib import Path

import pytest
from lxml import etree
from third_party import fmus_in, plain_pythonfmu, qfmu
from typer.testing import CliRunner

from fmus.build import build
from fmus.compile import host_platform
from orchestrator.checks import Report, check_fmu
from orchestrator.cli import app

EXPECTED = Path(__file__).parents[2] / "data" / "expected"
TO_COMPILE = 34

linux = pytest.mark.skipif(
    host_platform() != "linux-x86_64", reason="these FMUs hold linux64 binaries"
)


def assert_expected(report: Report, name: str) -> None:
    """Compare what was found with what is known of the exporter."""
    text = (EXPECTED / f"{name}.toml").read_text(encoding="utf-8")
    expected = tomllib.loads(text)
    chance = set(expected.pop("sometimes", ()))
    found = {
        outcome.item.key: [f.text for f in outcome.findings]
        for outcome in report.outcomes
        if outcome.findings and outcome.item.key not in chance
    }
    assert found.keys() == expected.keys()
    for key, texts in found.items():
        for text in texts:
            assert any(re.search(p, text) for p in expected[key]), (key, text)
        for pattern in expected[key]:
            assert any(re.search(pattern, t) for t in texts), (key, pattern)


@linux
def test_openmodelica(tmp_path: Path) -> None:
    fmu = fmus_in("gemseo-fmu==3.1.1", "linux", tmp_path)["Mass_Damper"]
    items = set(range(1, 39)) - {TO_COMPILE}  # a hundred files
    assert_expected(check_fmu(fmu, only=items), "openmodelica")


@linux
def test_qfmu(tmp_path: Path) -> None:
    matrices = {"A": "[[0,1],[0,-10]]", "B": "[[0],[5]]", "C": "[[1,0],[0,1]]"}
    fmu = qfmu(tmp_path, "drive", "ss", **matrices)
    assert_expected(check_fmu(fmu), "qfmu")


@linux
def test_pythonfmu3(tmp_path: Path) -> None:
    fmu = fmus_in("gemseo-fmu==3.1.1", "linux", tmp_path)["FMU3Model"]
    assert_expected(check_fmu(fmu), "pythonfmu3")


@linux
def test_plain_pythonfmu_lacks_initial_unknowns(tmp_path: Path) -> None:
    assert_expected(check_fmu(plain_pythonfmu(tmp_path)), "pythonfmu")


@linux
def test_a_missing_system_library_is_named(tmp_path: Path) -> None:
    fmu = fmus_in("modestpy==0.1.1", "Simple2R1C_linux64", tmp_path)
    report = check_fmu(fmu["Simple2R1C_linux64"])
    assert_expected(report, "jmodelica")
    stopped = [o for o in report.outcomes if o.verdict == "could not be run"]
    assert len(stopped) > 20
    assert all("libgfortran.so.3" in o.reason for o in stopped)
    assert not report.clean


def test_json_and_junit_tell_the_same(tmp_path: Path) -> None:
    junit = tmp_path / "check.xml"
    fmu = str(build("plants.ball_screw.two_mass"))
    arguments = ["check", fmu, "--static", "--json", "--junit", str(junit)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["clean"] is True
    assert all({"number", "clause", "verdict"} <= item.keys() for item in told["items"])
    suite = etree.parse(str(junit)).getroot()
    assert int(suite.get("tests")) == len(told["items"])
    assert int(suite.get("failures")) == 0


def test_a_finding_comes_with_clause_and_remedy(tmp_path: Path) -> None:
    fmu = plain_pythonfmu(tmp_path)
    junit = tmp_path / "check.xml"
    arguments = ["check", str(fmu), "--only", "5", "--junit", str(junit)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 1
    assert "5 static, error: ModelStructure/InitialUnknowns" in result.output
    assert "FMI 2.0.5 section 2.2.8" in result.output
    assert "remedy: list every output" in result.output
    failure = etree.parse(str(junit)).getroot().find("testcase/failure")
    assert "InitialUnknowns" in failure.text


def test_an_unsafe_archive_is_a_finding_and_nothing_of_it_is_run(
    tmp_path: Path,
) -> None:
    import zipfile

    fmu = tmp_path / "evil.fmu"
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription/>")
        archive.writestr("../outside.txt", "x")
    report = check_fmu(fmu)
    first, *others = report.outcomes
    assert "climbs out of the archive" in first.findings[0].text
    assert {o.verdict for o in others} == {"could not be run"}
    assert [f.name for f in tmp_path.iterdir()] == ["evil.fmu"]


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["check", str(tmp_path / "nothing.fmu")])
    assert result.exit_code == 2
    assert "no such file" in result.output
