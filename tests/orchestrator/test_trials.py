"""Small inputs that once gave a wrong number or a nonsense message: what is right."""

import json
import re
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.result import Result

TRIALS = Path(__file__).parents[1] / "data" / "trials"
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="binaries of Linux")


class Right(NamedTuple):
    """Exit code, last values of signals, figures, and what must be said."""

    exit_code: int = 0
    last: Mapping[str, float] = {}
    figures: Mapping[str, tuple[float, str]] = {}
    warned: str = ""
    error: str = ""


REFUSED = 2
RIGHT = {
    "01_relative_quantity": Right(last={"a.dT": 10, "b.dT": 10}),
    "02_state_event_exact_zero": Right(last={"a.on": 1}),
    "03a_string_parameter": Right(last={"a.y": 42.5}),
    "03b_string_parameter_number": Right(
        REFUSED, error="a.fileName is a String; give a"
    ),
    "03c_string_record": Right(REFUSED, error="texts are not recorded"),
    "04_integer_cut": Right(REFUSED, error="a.n is an Integer; give a whole number"),
    "05_bounds_of_type": Right(REFUSED, error="the FMU allows at most 5"),
    "06_fmu_ends_run": Right(last={"a.t": 0.03}),
    "07a_undefined_unit": Right(
        last={"b.y": 10 * 2 * np.pi / 60}, warned="names the unit rpm without defining"
    ),
    "07b_rad_ignored": Right(REFUSED, error="one counts radians, the other does not"),
    "08a_own_unit_in_metric": Right(figures={"speed.max": (np.pi / 3, "rad/s")}),
    "08b_Nm_in_metric": Right(figures={"torque.max": (10, "N.m")}),
    "08c_own_unit_in_map": Right(last={"a.w": 10}),
    "09_needs_stop_time": Right(
        last={"a.y": 0}, warned="it was handed the stop, 0.05 s"
    ),
    "10_fixed_step_hint": Right(
        last={"a.h": 0.01}, warned="0.01 s is no multiple of 0.004"
    ),
    "11_boolean_to_real": Right(REFUSED, error='"rin" = { name = "rin", gain = 1 }'),
    "12_tunable_driven": Right(last={"a.y": 0}),
}


@pytest.mark.parametrize("trial", sorted(path.stem for path in TRIALS.glob("*.toml")))
def test_a_trial_gives_the_right_value_or_says_why_not(
    trial: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = RIGHT[trial]
    code, said = ran(f"{trial}.toml", tmp_path / "run", monkeypatch)
    assert code == right.exit_code, said
    assert right.error in said.get("error", "")
    assert right.warned in " ".join(said.get("warnings", []))
    assert bool(right.warned) == bool(said.get("warnings"))
    for name, (value, unit) in right.figures.items():
        figure = said["metrics"][name]
        assert (figure["value"], figure["unit"]) == (pytest.approx(value), unit)
    if right.last:
        result = Result(tmp_path / "run")
        found = {name: float(result[name].values[-1]) for name in right.last}
        assert found == pytest.approx(right.last)


def test_a_state_event_at_a_step_is_in_its_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ran("02_state_event_exact_zero.toml", tmp_path / "run", monkeypatch)
    assert Result(tmp_path / "run")["a.on"].values.tolist() == [0, 1, 1]


def test_an_fmu_that_ended_the_run_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, said = ran("06_fmu_ends_run.toml", tmp_path / "run", monkeypatch)
    assert (said["ended"]["by"], said["ended"]["at"]) == ("a", 0.03)


def test_a_switch_is_0_or_1_by_the_map_that_its_refusal_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, said = ran("11_boolean_to_real.toml", tmp_path / "run", monkeypatch)
    (line,) = re.findall(r"^\[components\.b\.map\]\n(.*)$", said["error"], re.M)
    text = (TRIALS / "11_boolean_to_real.toml").read_text()
    changed = text.replace(
        "[connections]", f"[components.b.map]\n{line}\n[connections]"
    )
    (tmp_path / "mapped.toml").write_text(changed)
    shutil.copy(TRIALS / "mix.fmu", tmp_path)
    code, said = ran(str(tmp_path / "mapped.toml"), tmp_path / "mapped", monkeypatch)
    assert code == 0, said
    assert set(Result(tmp_path / "mapped")["b.rout"].values) <= {0.0, 1.0}


def test_what_drives_a_tunable_parameter_arrives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trial = "12_tunable_driven.toml"
    text = (TRIALS / trial).read_text()
    shutil.copy(TRIALS / "tun.fmu", tmp_path)
    shutil.copy(TRIALS / "plant.fmu", tmp_path)
    (tmp_path / trial).write_text(text + '"a.k" = true\n')
    given = "--set", "p.start.u=3"
    code, _ = ran(str(tmp_path / trial), tmp_path / "run", monkeypatch, *given)
    assert code == 0
    k, y = (Result(tmp_path / "run")[name].values for name in ("a.k", "a.y"))
    assert k[-1] > 0.1
    np.testing.assert_allclose(y[1:], 2 * k[:-1])  # the FMU's y = 2 k, a step later


def test_a_description_of_20000_variables_is_read(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(TRIALS)
    told = CliRunner().invoke(app, ["info", "big.fmu", "--json"])
    assert told.exit_code == 0
    assert len(json.loads(told.stdout)["variables"]) >= 20_000


def ran(
    scenario: str, folder: Path, monkeypatch: pytest.MonkeyPatch, *options: str
) -> tuple[int, dict[str, Any]]:
    """Run a scenario beside the files that its FMUs read; return code and JSON."""
    monkeypatch.chdir(TRIALS)
    command = ["run", scenario, "-o", str(folder), "--json", *options]
    result = CliRunner().invoke(app, command)
    return result.exit_code, json.loads(result.stdout)
