"""From any input to any output: the exact transfer functions, units, refusals."""

from fractions import Fraction
from pathlib import Path

import control as ct
import numpy as np
import pytest
from measured_loops import composed, decibels, degrees

from controllers.ball_screw import p_pi
from controllers.synthesis.ball_screw.loops import sampled_loop
from controllers.synthesis.frequency import evaluate, respond
from controllers.synthesis.linearise import linearise
from orchestrator.errors import ResponseError, ScenarioError
from orchestrator.response.expected import respond as respond_of
from orchestrator.response.figures import figures, to_frd, words
from orchestrator.response.measure import measure, measure_transfer
from orchestrator.response.traced import beside, traced
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

SCREW = "ball_screw_pole_placement/p_pi_a_track_500"
TABLE = "cascade_nppi/p_pi_0_4hz"
T_S = 1 / 20_000


def test_compliance_and_tracking_are_the_exact_ones_of_the_closed_loop() -> None:
    """d_2 and the command x_r to x_2 with the loop closed, in motion."""
    composition = composed(SCREW, "encoder.on=false")
    found = measure_transfer(
        composition,
        ["plant.d_2"],
        ["plant.x_2", "controller.u"],
        lowest=Fraction(4),
        quick=True,
    )
    low = found.hz <= 0.25 / T_S
    loop = sampled_loop("p_pi", False, {}, 1, T_S)
    exact = respond(loop, found.hz[low])
    assert decibels(found.G[low, 0, 0], exact.disturbance) < 0.01
    assert degrees(found.G[low, 0, 0], exact.disturbance) < 0.1
    assert (str(found.unit(0, 0)), str(found.unit(1, 0))) == ("rad/V", "1")
    equations = traced(composition, found)
    for i in (0, 1):
        assert decibels(found.G[low, i, 0], equations.G[low, i, 0]) < 1e-3

    command = measure_transfer(
        composition, ["trajectory.x_r"], ["plant.x_2"], lowest=Fraction(4), quick=True
    )
    low = command.hz <= 0.25 / T_S
    z = np.exp(2j * np.pi * command.hz[low] * T_S)
    law = linearise(p_pi.model, inputs=["x_r"], outputs=["u"], T_s=T_S)
    plant = ct.ss(loop.plant)["x_2", "u"]
    C, P = evaluate(law, z)[:, 0, 0], evaluate(plant, z)[:, 0, 0]
    wanted = P * C / z / (1 + respond(loop, command.hz[low]).L)
    assert decibels(command.G[low, 0, 0], wanted) < 0.01
    assert degrees(command.G[low, 0, 0], wanted) < 0.1
    equations = traced(composition, command)
    assert decibels(command.G[low, 0, 0], equations.G[low, 0, 0]) < 1e-3
    assert figures("way", command)["way.peak"].value == pytest.approx(
        np.max(np.abs(wanted)), rel=0.02
    )
    frd = to_frd(command)
    assert (frd.ninputs, frd.noutputs) == (1, 1)


def test_a_clock_with_an_offset_delays_nothing_but_itself() -> None:
    """Broken where it publishes, at t = 1/4000 + k/2000, not where rows begin."""
    composition = composed(TABLE, "controller.offset=1/4000")
    found = measure(composition, ["controller.u"], lowest=Fraction(16), quick=True)
    way = measure_transfer(
        composition, ["controller.u"], ["controller.u"], lowest=Fraction(16), quick=True
    )
    for one in (found, way):
        equations, told = beside(composition, one)
        assert equations is not None, told
        G = one.G[:, 0, 0] if one is way else -one.T[:, 0, 0]  # type: ignore[attr-defined]
        assert np.allclose(G, equations.G[:, 0, 0], atol=1e-6)
    # half a sample earlier in the plant: the reading is half a sample older
    plain = measure(composed(TABLE), ["controller.u"], lowest=Fraction(16), quick=True)
    assert found.s_max[0] == pytest.approx(plain.s_max[0], rel=0.1)


def test_what_is_excited_faster_than_its_loop_is_told_with_its_alias() -> None:
    found = measure_transfer(
        composed(TABLE), ["plant.d"], ["plant.y"], lowest=Fraction(16), quick=True
    )
    assert found.slower == "controller.u"
    assert found.alias > 1e-3
    assert any("controller.u is slower than plant.d" in line for line in words(found))


def test_a_response_from_input_to_output_is_held_to_its_figures(tmp_path: Path) -> None:
    file = tmp_path / "stiff.toml"
    file.write_text(f"""
base = "{TABLE}"
responses.stiff = {{ excite = "plant.d", observe = "plant.y", from = "16 Hz" }}
[expect]
"stiff.peak" = {{ below = 700, unit = "um/V" }}
"stiff.bandwidth_hz" = {{ above = 200, unit = "Hz" }}
""")
    done = respond_of(compose(load_scenario(file), run_earlier))
    assert [check.met for check in done.checks] == [True, False]
    assert "stiff.peak = 630.71 um/V" in done.checks[0].text


@pytest.mark.parametrize(
    ("excited", "observed", "complaint"),
    [
        ("plant.dd", "plant.y", "excite plant.dd: plant .* has no variable 'dd'"),
        ("plat.d", "plant.y", "excite plat.d: no such input or output; did you mean"),
        ("plant.b", "plant.y", "no real input or output but a real parameter"),
        ("plant.d", "plant.b", "observe plant.b: plant.b is no real signal"),
        ("plant.d", "plant", "observe plant: no such signal"),
        ("plant.d", "reference.x_r", "no connection leads there from plant.d"),
        ("controller.e", "plant.y", "controller.e drives nothing"),
    ],
)
def test_ways_that_are_none_are_refused_by_name(
    excited: str, observed: str, complaint: str
) -> None:
    with pytest.raises(ResponseError, match=complaint):
        measure_transfer(composed(TABLE), [excited], [observed])


@pytest.mark.parametrize(
    ("response", "complaint"),
    [
        ('{ excite = "plant.d" }', "observe is missing"),
        ('{ break = "controller.u", observe = "plant.y" }', "say either break"),
        ("{ amplitude = 1 }", "say either break"),
        ('{ excite = "plat.d", observe = "plant.y" }', "stiff.excite: there is no"),
    ],
)
def test_entries_that_name_no_way_are_refused(
    response: str, complaint: str, tmp_path: Path
) -> None:
    file = tmp_path / "s.toml"
    file.write_text(f'base = "{TABLE}"\nresponses.stiff = {response}\n')
    with pytest.raises(ScenarioError, match=complaint):
        load_scenario(file)
