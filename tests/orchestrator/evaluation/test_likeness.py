"""Whole signals against a baseline: what passes, what does not, and what is said."""

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.evaluation.baseline import update
from orchestrator.evaluation.likeness import differences, tube
from orchestrator.evaluation.schema import Likeness
from orchestrator.history.folder import BEGUN
from orchestrator.result import Signal
from orchestrator.session import run

pytest_plugins = ["pytester"]
TIME = np.arange(2001) / 1000
DRIVE = """\
stop = "0.2"
expect_like = { folder = "baseline/", relative = 1e-3, time = "1 ms" }
[components.voltage]
data = "u.csv"
[components.plant]
fmu = "plants.ball_screw.two_mass"
step = "1/2000"
[connections]
"plant.u" = "voltage.u"
[record]
"plant.x_2" = "1/2000"
"""


def unlike(was: np.ndarray, now: np.ndarray, unit: str = "m", **options: object) -> str:
    spec = Likeness.model_validate({"folder": ".", **options})
    signals = [{"y": Signal("y", TIME, v, u)} for v, u in ((was, "m"), (now, unit))]
    return "; ".join(d.text for d in differences(*signals, spec))


def test_a_tube_is_what_brute_force_over_every_shift_says() -> None:
    values = np.random.default_rng(3).normal(size=400)
    time, reach = TIME[:400], 0.0025
    lower, upper = tube(time, values, reach)
    shifts = [-reach, *np.arange(-0.002, 0.0021, 0.001), reach]
    seen = [np.interp(time + s, time, values) for s in shifts]
    np.testing.assert_allclose(lower, np.min(seen, axis=0), atol=1e-9)
    np.testing.assert_allclose(upper, np.max(seen, axis=0), atol=1e-9)


def test_a_shift_or_a_factor_beyond_the_tolerance_is_named() -> None:
    was = np.sin(2 * np.pi * 3 * TIME)
    late = np.sin(2 * np.pi * 3 * np.maximum(TIME - 0.004, 0))
    assert unlike(was, late, time="5 ms") == ""
    assert "it amounts to a shift of +0.004 s" in unlike(was, late, time="2 ms")
    assert unlike(was, 1.02 * was, relative=0.02) == ""
    told = unlike(was, 1.02 * was, relative=0.005)
    assert "it amounts to a factor of 1.02" in told
    assert unlike(was, 1e3 * was, unit="mm") == ""


def test_a_pulse_that_vanishes_in_the_tube_is_an_event_that_is_missing() -> None:
    was = np.where((TIME > 0.5) & (TIME < 0.503), 1.0, 0.0)
    assert "changes 0 times, in the baseline 2 times" in unlike(
        was, 0 * was, time="10 ms"
    )
    assert "changes at 0.513 s" in unlike(was, np.roll(was, 12), time="10 ms")
    assert unlike(was, np.roll(was, 8), time="10 ms") == ""


def test_another_frequency_within_a_wide_tube_is_seen() -> None:
    was, now = (np.sin(2 * np.pi * f * TIME) for f in (50.0, 55.0))
    told = unlike(was, now, time="20 ms", relative=0.1)
    assert told.startswith("oscillates at 55")
    assert "baseline at 50" in told
    assert unlike(was, now, time="20 ms", relative=0.1, frequency=0.11) == ""


def test_what_is_not_finite_never_passes() -> None:
    was = np.sin(TIME)
    now = np.where(TIME > 1, np.nan, was)
    assert "leaves the tube" in unlike(was, now, absolute=1e9)


def test_a_baseline_that_is_not_finite_is_refused() -> None:
    was = np.where(TIME > 1, np.inf, np.sin(TIME))
    assert unlike(was, was) == (
        "the baseline holds values that are no finite numbers; update it"
    )


def test_what_is_no_baseline_does_not_become_one(tmp_path: Path) -> None:
    """NaN, a signal that was not recorded, and in place of the folder of a run."""

    class Done(dict[str, Signal]):
        folder = tmp_path

    file = tmp_path / "drive.toml"
    values = {"a.y": np.where(TIME > 1, np.nan, TIME), "a.z": TIME}
    done = Done({n: Signal(n, TIME, v, "m") for n, v in values.items()})

    def told(folder: str, *signals: str) -> str:
        tables = {name: {} for name in signals}
        spec = Likeness.model_validate({"folder": folder, "signals": tables})
        with pytest.raises(ScenarioError) as error:
            update(file, spec, done)  # type: ignore[arg-type]
        return str(error.value)

    assert "a.y holds values that are no finite numbers" in told("kept")
    assert "a.x was not recorded" in told("kept", "a.x")
    rows = tmp_path / "runs" / "result" / "1.parquet"
    rows.parent.mkdir(parents=True)
    rows.write_text("rows")
    (tmp_path / "runs" / BEGUN).write_text("{}")
    assert "is the folder of a run" in told("runs", "a.z")
    assert rows.read_text() == "rows"
    assert not (tmp_path / "kept").exists()


def voltages(file: Path, gain: float = 1.0, late: float = 0.0) -> None:
    time = np.arange(0, 0.2005, 0.0005)
    u = gain * np.sin(2 * np.pi * 20 * np.maximum(time - late, 0)) ** 2
    rows = "".join(f"{t:.4f},{v!r}\n" for t, v in zip(time, u.tolist(), strict=True))
    file.write_text(f"t [s],u [V]\n{rows}")


WRONG = """\
base = "drive.toml"
[metrics.position]
kind = "peak"
of = "plant.x_2"
[expect]
"position.peak" = { below = 1e-6 }
"""
HEIR = """\
base = "drive.toml"
expect_like = {{ folder = "baseline/{folder}", relative = 1e-3, time = "1 ms" }}
components.voltage.data = "{name}.csv"
"""


def test_scenarios_are_held_against_their_baseline_in_pytest(
    pytester: pytest.Pytester,
) -> None:
    """Made; then met, met within the time tolerance, late, larger, and not there."""
    (pytester.path / "drive.toml").write_text(DRIVE)
    voltages(pytester.path / "u.csv")

    def outcome(*options: str, **expected: int) -> str:
        result = pytester.runpytest_subprocess("-p", "no:cacheprovider", *options)
        result.assert_outcomes(**expected)
        return result.stdout.str()

    (pytester.path / "wrong.toml").write_text(WRONG)
    text = outcome("--feeddrive-update", passed=1, failed=1)
    assert "so it is not made the baseline" in text
    assert [f.name for f in (pytester.path / "baseline").iterdir()] == ["drive"]
    (pytester.path / "wrong.toml").unlink()
    cases = {"soon": {"late": 0.0005}, "late": {"late": 0.005}, "larger": {"gain": 1.1}}
    for name, options in {**cases, "fresh": {}}.items():
        voltages(pytester.path / f"{name}.csv", **options)
        folder = "" if name == "fresh" else "drive"
        (pytester.path / f"{name}.toml").write_text(
            HEIR.format(folder=folder, name=name)
        )
    text = outcome(passed=2, failed=3)
    said = {
        name: text.partition(f" scenario {name} ")[2].partition("____ ")[0]
        for name in ("late", "larger", "fresh")
    }
    for name, words in (("late", "shift of +0.00"), ("larger", "factor of 1.1")):
        assert "not like drive: plant.x_2: leaves the tube" in said[name]
        assert f"it amounts to a {words}" in said[name]
    assert "--feeddrive-update makes it the baseline" in said["fresh"]


def test_the_verb_run_compares_as_pytest_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Exit code 1 where it is unlike, 0 where it was changed on purpose."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "drive.toml"
    file.write_text(DRIVE)
    voltages(tmp_path / "u.csv")

    def ran(code: int, *options: str) -> tuple[list[str], str]:
        done = CliRunner().invoke(app, ["run", "drive.toml", "--json", *options])
        assert done.exit_code == code, done.output
        found: list[str] = json.loads(done.stdout)["unlike"]
        return found, done.stderr

    assert "there is no baseline" in ran(1)[1]
    first = run(file, tmp_path / "first")
    update(file, first.scenario.spec.expect_like, first)
    assert ran(0)[0] == []
    voltages(tmp_path / "u.csv", late=0.005)
    (told,), said = ran(1)
    assert told.startswith("not like drive: plant.x_2: leaves the tube")
    assert "it amounts to a shift of +0.005 s" in told
    assert told in said
    assert "not like drive" in ran(0, "--set", "plant.m_1=0.003")[1]


def test_a_signals_own_tolerance_replaces_the_common_one() -> None:
    spec = Likeness.model_validate(
        {"folder": ".", "time": "1 ms", "signals": {"a.y": {"absolute": 2.0}}}
    )
    assert (spec.of("a.y").absolute, spec.of("a.y").time) == (2.0, Fraction(1, 1000))
    assert spec.of("a.z").absolute == 0
