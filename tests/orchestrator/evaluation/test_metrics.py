"""Figures of recorded signals, against formulas worked out by hand."""

import numpy as np
import pytest
from pydantic import TypeAdapter

from orchestrator.errors import ScenarioError
from orchestrator.evaluation.expectation import check
from orchestrator.evaluation.metrics import evaluate
from orchestrator.evaluation.schema import Expectation, MetricSpec
from orchestrator.quantities.quantity import NoValue, Quantity
from orchestrator.result import Signal

TIME = np.arange(2001) / 1000


def signal(values, unit="rad", time=TIME, name="plant.x"):
    return Signal(name, time, np.broadcast_to(values, time.shape).astype(float), unit)


def figures(metric, signals, parameters=None):
    spec = TypeAdapter(MetricSpec).validate_python(metric)
    table = parameters or {}
    return evaluate({"m": spec}, signals, lambda name: table[name])


def test_an_error_is_reference_minus_actual_in_the_unit_asked_for():
    signals = {"plant.x": signal(1.0 + 0.5 * TIME), "trajectory.x": signal(1.0)}
    found = figures(
        {
            "kind": "error",
            "of": "plant.x",
            "against": "trajectory.x",
            "scale": "plant.r_g",
            "unit": "mm",
        },
        signals,
        {"plant.r_g": Quantity(0.01, "m/rad")},
    )
    assert found["m.peak"] == Quantity(pytest.approx(10.0), "mm")
    assert found["m.mean"].value == pytest.approx(-5.0)
    assert found["m.rms"].value == pytest.approx(
        1000 * 0.01 * 0.5 * np.sqrt(np.mean(TIME**2))
    )


def test_signals_of_different_rows_are_compared_where_both_have_one():
    signals = {"plant.x": signal(TIME), "t.x": signal(0.5, time=TIME[::2])}
    metric = {"kind": "error", "of": "plant.x", "against": "t.x"}
    expected = np.sqrt(np.mean((0.5 - TIME[::2]) ** 2))
    assert figures(metric, signals)["m.rms"].value == pytest.approx(expected)
    signals["t.x"] = signal(0.5, time=TIME + 1e-4)
    with pytest.raises(ScenarioError, match="no instant in common"):
        figures(metric, signals)


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        ("peak", 3.0),
        ("max", 1.0),
        ("min", -3.0),
        ("final", 1.0),
        ("mean", -1.0),
        ("mean_abs", 2.0),
    ],
)
def test_plain_figures(kind, value):
    signals = {"plant.x": signal(1.0 - 4.0 * (TIME < 1.0005))}
    found = figures({"kind": kind, "of": "plant.x", "window": ["0.001", 2]}, signals)
    assert found == {f"m.{kind}": Quantity(pytest.approx(value, abs=2e-3), "rad")}


def test_a_window_counts_both_its_ends():
    signals = {"plant.x": signal(TIME)}
    window = ["0.1", "0.3"]
    for kind, value in (("min", 0.1), ("max", 0.3)):
        found = figures({"kind": kind, "of": "plant.x", "window": window}, signals)
        assert found[f"m.{kind}"].value == value
    with pytest.raises(ScenarioError, match="no row"):
        figures({"kind": "rms", "of": "plant.x", "window": [5, 6]}, signals)


def test_settling_is_the_first_row_after_which_the_band_is_kept():
    decay = signal(np.where(TIME >= 0.5, np.exp(-(TIME - 0.5) / 0.1), 0.0))
    metric = {"kind": "settling", "of": "plant.x", "window": ["1/2", 2]}
    found = figures(metric, {"plant.x": decay})
    assert found["m.settling"] == Quantity(pytest.approx(0.300), "s")
    assert 0.1 * np.log(20) == pytest.approx(0.2996, abs=1e-4)
    assert found["m.peak"].value == 1.0
    assert found["m.peak_time"].value == 0.0


def test_what_does_not_settle_keeps_its_other_figures_and_says_why():
    ringing = signal(np.sin(2 * np.pi * 5.3 * TIME))
    found = figures({"kind": "settling", "of": "plant.x"}, {"plant.x": ringing})
    assert isinstance(found["m.settling"], NoValue)
    assert "not settled" in str(found["m.settling"])
    assert found["m.peak"].value == pytest.approx(1.0, abs=1e-3)


def test_a_figure_too_large_for_a_number_has_no_value_and_warns_of_nothing():
    signals = {"plant.x": signal(1e200 * TIME)}
    found = figures({"kind": "rms", "of": "plant.x"}, signals)
    assert found == {"m.rms": NoValue("rad", why="too large for a number")}
    assert figures({"kind": "peak", "of": "plant.x"}, signals)["m.peak"].value == 2e200


def test_a_stair_that_never_oscillates_and_a_sine_that_is_not_there_have_no_value():
    signals = {"plant.x": signal(0.0), "gain.K": signal(3.0, "V")}
    stairs = {"kind": "sustained", "of": "plant.x", "level": "gain.K", "span": 0.5}
    found = figures(stairs | {"dwell": "1/2", "tail": "1/10"}, signals)["m.level"]
    assert found == NoValue("V", why="no oscillation of more than 0.5 rad up to 3 V")
    sine = {"kind": "sine", "of": "gain.K", "against": "plant.x", "frequency_hz": 5.0}
    found = figures(sine | {"unit": "V/deg"}, signals)
    assert found["m.ratio"].unit == "V/deg"
    assert "no component" in str(found["m.phase"])


def test_the_ratio_of_two_sines_is_gain_and_phase():
    omega = 2 * np.pi * 7.3
    signals = {
        "plant.x": signal(0.2 + 3.0 * np.sin(omega * TIME - 0.4), "um"),
        "source.u": signal(1.5 * np.sin(omega * TIME + 0.3), "V"),
    }
    metric = {"kind": "sine", "of": "plant.x", "frequency_hz": "source.f_hz"}
    parameters = {"source.f_hz": Quantity(7.3, "Hz")}
    alone = figures(metric, signals, parameters)
    assert alone["m.amplitude"] == Quantity(pytest.approx(3.0), "um")
    both = figures(metric | {"against": "source.u"}, signals, parameters)
    assert both["m.ratio"] == Quantity(pytest.approx(2.0), "um/V")
    assert both["m.phase"] == Quantity(pytest.approx(np.degrees(-0.7)), "deg")


@pytest.mark.parametrize("hertz", [950.0, 500.0, 0.0, -50.0])
@pytest.mark.parametrize("kind", ["sine", "spectrum"])
def test_rows_show_no_sine_of_half_their_rate_or_more_nor_of_none(kind, hertz):
    """At 1 kHz, 950 Hz has the rows of 50 Hz."""
    signals = {"plant.x": signal(1.0 + np.sin(2 * np.pi * 50.0 * TIME))}
    signals["u.y"] = signals["plant.x"]
    metric = {"kind": kind, "of": "plant.x", "frequency_hz": hertz}
    for one in (metric, metric | {"against": "u.y"})[: 2 if kind == "sine" else 1]:
        found = figures(one, signals)
        assert all(isinstance(figure, NoValue) for figure in found.values())
        assert all(f"{hertz:g} Hz is" in figure.why for figure in found.values())


def test_two_rows_determine_no_sine_and_no_line():
    metric = {"of": "plant.x", "window": [0, "1/1000"]}
    sine = {"kind": "sine", "frequency_hz": 50.0}
    for kind in (sine, sine | {"kind": "spectrum"}):
        found = figures(metric | kind, {"plant.x": signal(TIME)})
        assert "2 rows are too few" in found["m.amplitude"].why
    band = {"kind": "spectrum", "band_hz": [10, 100]}
    found = figures(metric | band, {"plant.x": signal(TIME)})
    assert "2 rows are too few" in found["m.amplitude"].why


@pytest.mark.parametrize(("end", "whole"), [("2", True), ("2.0009", True), (5, False)])
def test_a_window_that_ends_after_the_rows_has_no_value(end, whole):
    """The last row is at 2 s, one each ms: until 2.0009 s there is no other."""
    metric = {"kind": "mean", "of": "plant.x", "window": ["0.5", end]}
    found = figures(metric, {"plant.x": signal(TIME)})["m.mean"]
    if whole:
        assert found == Quantity(pytest.approx(1.25), "rad")
    else:
        why = "its window ends at 5 s, the rows at 2 s; set stop to 5 or later"
        assert found == NoValue("rad", why=why)


def test_a_spectral_line_has_the_amplitude_of_its_sine():
    signals = {"plant.x": signal(0.5 * np.sin(2 * np.pi * 43.0 * TIME) + 2.0)}
    metric = {"kind": "spectrum", "of": "plant.x", "frequency_hz": 43.0}
    found = figures(metric, signals)
    assert found["m.amplitude"].value == pytest.approx(0.5, rel=2e-3)
    assert found["m.frequency"] == Quantity(pytest.approx(43.0, abs=0.3), "Hz")


def test_the_strongest_line_of_a_band_is_found_between_the_lines():
    f_1, f_2 = 43.37, 90.0  # the second is stronger, and outside
    x = 0.5 * np.sin(2 * np.pi * f_1 * TIME) + np.sin(2 * np.pi * f_2 * TIME) + 2.0
    metric = {"kind": "spectrum", "of": "plant.x", "band_hz": [20, 80]}
    found = figures(metric, {"plant.x": signal(x)})
    assert found["m.frequency"] == Quantity(pytest.approx(f_1, abs=0.05), "Hz")
    assert found["m.amplitude"].value == pytest.approx(0.5, rel=0.2)
    none = figures(metric, {"plant.x": signal(np.full(len(TIME), 2.0))})
    assert isinstance(none["m.frequency"], NoValue)
    assert "no line stands out from 20 to 80 Hz" in none["m.frequency"].why


def test_per_divides_by_a_parameter_with_its_unit():
    signals = {"plant.x": signal(6.0, "um")}
    metric = {"kind": "peak", "of": "plant.x", "per": "rope.size", "unit": "um/V"}
    found = figures(metric, signals, {"rope.size": Quantity(2.0, "V")})
    assert found["m.peak"] == Quantity(3.0, "um/V")


@pytest.mark.parametrize(
    ("metric", "remedy"),
    [
        ({"kind": "peak", "of": "plant.y"}, "plant.x"),
        ({"kind": "peak", "of": "plant.x", "unit": "V"}, "metrics.m"),
        ({"kind": "peak", "of": "plant.x", "per": 0.0}, "zero"),
    ],
)
def test_a_metric_that_cannot_be_taken_is_named(metric, remedy):
    with pytest.raises(ScenarioError, match=r"metrics\.m") as refusal:
        figures(metric, {"plant.x": signal(1.0)})
    assert remedy in str(refusal.value)


WARM = {"plant.x": signal(30.0, "degC"), "plant.y": signal(20.0, "degC")}


@pytest.mark.parametrize(
    "factors",
    [{"per": "20 degC"}, {"scale": 2, "unit": "K"}, {"scale": 2}, {"per": "2"}],
)
def test_a_multiple_of_a_temperature_in_degrees_is_refused(factors):
    with pytest.raises(ScenarioError, match="begins at zero"):
        figures({"kind": "final", "of": "plant.x", **factors}, WARM)


def test_a_multiple_of_a_difference_or_of_kelvins_is_taken():
    error = {"kind": "error", "of": "plant.x", "against": "plant.y", "scale": 2}
    assert figures({**error, "unit": "K"}, WARM)["m.mean"].value == -20
    kelvin = {"plant.x": signal(300.0, "K")}
    found = figures({"kind": "final", "of": "plant.x", "per": "150 K"}, kelvin)
    assert found["m.final"] == Quantity(2.0)


def test_expectations_convert_units_and_refuse_not_a_number():
    found = {"m.peak": Quantity(2.49, "um"), "m.rms": Quantity(float("nan"), "um")}

    def met(**bounds):
        (result,) = check({"m.peak": Expectation(**bounds)}, found)
        return result.met

    assert met(below=2.5, unit="um")
    assert not met(below=2.49, unit="um")
    assert met(above=2.4e-3, below=2.5e-3, unit="mm")
    assert met(near=2.490, within=0.005)
    assert not met(near=2.480, within=0.005)
    (result,) = check({"m.rms": Expectation(below=1.0)}, found)
    assert not result.met
    with pytest.raises(ScenarioError, match=r"m\.peak"):
        check({"m.paek": Expectation(below=1.0)}, found)


def test_an_expectation_on_what_has_no_value_is_unmet_with_the_reason():
    found = {"m.settling": NoValue("s", why="not settled: 3 um at 2 s")}
    (result,) = check({"m.settling": Expectation(below=30, unit="ms")}, found)
    assert (result.met, result.decided) == (False, False)
    assert result.text == "m.settling: not settled: 3 um at 2 s; expected below 30 ms"
    with pytest.raises(ScenarioError, match=r"m\.settling"):
        check({"m.settling": Expectation(below=30, unit="mm")}, found)
