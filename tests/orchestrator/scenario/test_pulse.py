"""Signs and ratios of two FMUs, by one short pulse on both."""

from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.build import build
from orchestrator.fmu.description import read_fmu
from orchestrator.scenario.pulse import Measured, Subject, measure, signs
from orchestrator.supplied import build_supplied

NAMES = {"u": "motor_voltage", "d_2": "table_force", "x_1": "screw", "x_2": "table"}
flips = st.lists(st.sampled_from([1.0, -1.0]), min_size=1, max_size=4)


@given(flips, flips, st.data())
def test_signs_explain_every_answer(inputs, outputs, data):
    measured = [
        Measured(f"u{i}", f"y{j}", a * b * data.draw(st.floats(0.1, 10)), 1.0)
        for i, a in enumerate(inputs)
        for j, b in enumerate(outputs)
    ]
    found = signs(measured)
    for one in measured:
        assert found[one.input] * found[one.output] * one.ratio > 0
    changed = sum(sign < 0 for sign in found.values())
    assert changed <= sum(sign < 0 for sign in (*inputs, *outputs))


def test_one_reversed_motor_is_the_motor_and_not_both_scales():
    answers = [Measured("u", "x_1", -1.0, 1.0), Measured("u", "x_2", -1.0, 1.0)]
    assert signs(answers) == {"u": -1.0, "x_1": 1.0, "x_2": 1.0}


def test_answers_that_contradict_one_another_give_no_sign():
    pairs = [("u", "x", 1.0), ("u", "y", 1.0), ("d", "x", 1.0), ("d", "y", -1.0)]
    found = signs([Measured(i, o, r, 1.0) for i, o, r in pairs])
    assert "d" not in found or "u" not in found


def test_the_supplied_drive_is_measured_as_it_is(tmp_path: Path):
    period = Fraction(1, 20_000)
    ours = read_fmu(build("plants.ball_screw.two_mass"))
    theirs = read_fmu(build_supplied("supplied.ball_screw", tmp_path))
    pairs = {n: (ours[n], theirs[other]) for n, other in NAMES.items()}
    found = measure(
        Subject(ours, period, {}),
        Subject(theirs, period, {}),
        [(*pairs["u"], 1.0), (*pairs["d_2"], 1.0)],
        [pairs["x_1"], pairs["x_2"]],
    )
    per_rad = 20 / (2 * 3.141592653589793)
    ratios = {(one.input, one.output): one.ratio for one in found}
    assert ratios == {
        ("u", "x_1"): pytest.approx(-per_rad, rel=1e-6),
        ("u", "x_2"): pytest.approx(-per_rad, rel=1e-6),
        ("d_2", "x_1"): pytest.approx(per_rad, rel=1e-6),
        ("d_2", "x_2"): pytest.approx(per_rad, rel=1e-6),
    }
    assert all(one.is_exact for one in found)


def test_what_cannot_be_run_is_not_measured(tmp_path: Path):
    plant = read_fmu(build("plants.ball_screw.two_mass"))
    broken = tmp_path / "none.fmu"
    broken.write_bytes(plant.path.read_bytes())
    gone = read_fmu(broken)
    broken.unlink()
    subject = Subject(plant, Fraction(1, 20_000), {})
    other = Subject(gone, Fraction(1, 20_000), {})
    pair = plant["u"], plant["u"], 1.0
    assert measure(subject, other, [pair], [(plant["x_1"], plant["x_1"])]) == []
