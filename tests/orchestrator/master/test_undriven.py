"""What nothing drives is said, with the value it holds."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from systems import part, system
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.fmu.description import read_fmu
from orchestrator.master.undriven import in_words, undriven
from orchestrator.system import Mapped, System

SCENARIO = "ball_screw_pole_placement/mc_ppc_track_500"


def held(of: System) -> dict[str, tuple[float, str, bool]]:
    fmus = {name: read_fmu(c.fmu) for name, c in of.components.items()}
    found = undriven(of, fmus)
    return {one.input: (one.value, one.unit, one.given) for one in found}


def test_inputs_without_a_connection_are_listed_with_their_values():
    a, b = (part(name, "integrator", "1/1000") for name in "ab")
    assert held(system("1", [a, b], {"b.u": "a.z"})) == {"a.u": (0.0, "1/s", False)}
    given = replace(a, start={"u": 3.0})
    assert held(system("1", [given])) == {"a.u": (3.0, "1/s", True)}
    mapped = replace(given, map={"rate": Mapped("u", 60.0, unit="1/min")})
    assert held(system("1", [mapped])) == {"a.rate": (0.05, "1/min", True)}


def test_run_schedule_json_and_report_say_what_holds_a_start_value(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    said = "nothing drives controller.u_d = 0 V, plant.d_1 = 0 V, plant.d_2 = 0 V"
    monkeypatch.chdir(tmp_path)
    for verb in (
        ["schedule"],
        ["run", "--set", "stop=0.01", "-o", str(tmp_path / "r")],
    ):
        result = CliRunner().invoke(app, [verb[0], SCENARIO, *verb[1:]])
        assert result.exit_code == 0, result.output
        assert said in " ".join(result.stdout.split())
        told = CliRunner().invoke(
            app, [verb[0], SCENARIO, "--json", "--set", "stop=0.01"]
        )
        inputs = [one["input"] for one in json.loads(told.stdout)["undriven"]]
        assert inputs == ["controller.u_d", "plant.d_1", "plant.d_2"]
    assert said[1:] in (tmp_path / "r/report.html").read_text()


def test_nothing_is_said_where_everything_is_driven_or_given():
    a = replace(part("a", "integrator", "1/1000"), start={"u": 1.0})
    fmus = {"a": read_fmu(a.fmu)}
    assert in_words(undriven(system("1", [a]), fmus)) == ""
