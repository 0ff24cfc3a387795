"""Frequency responses by a stepped sine: of linear objects, and of friction."""

from typing import Any

import control as ct
import numpy as np
import pytest

from controllers.references import stepped_sine as reference
from controllers.synthesis.linearise import linearise
from controllers.synthesis.stepped_sine import (
    bandwidth,
    frequencies,
    notch_at_peak,
    peak,
    respond,
)
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run
from plants.leadscrew import axis

T = 2e-4
SWEEP: dict[str, Any] = {"f_1": 20.0, "f_N": 400.0, "N": 9, "T_d": 0.4}


def driven(f_1: float, f_N: float, N: int, T_d: float) -> np.ndarray:
    """Return the reference of amplitude 1, all at once."""
    t = np.arange(round(T_d / T)) * T
    f_hz = frequencies(f_1, f_N, N, T_d)
    return np.concatenate([np.sin(2 * np.pi * f * t) for f in f_hz])


def test_the_reference_is_what_the_analysis_takes_it_for() -> None:
    sweep: dict[str, Any] = {"f_1": 50.0, "f_N": 400.0, "N": 3, "T_d": 0.04}
    p = reference.Parameters(amplitude=2.0, **sweep)
    x, rows = reference.State(), []
    for _ in range(620):  # and twenty samples of the rest behind
        x, y = reference.step(x, reference.Input(), p, T)
        rows.append(float(y.x_r))
    expected = np.append(2 * driven(**sweep), np.zeros(20))
    assert rows == pytest.approx(expected, abs=1e-12)


def filtered(r: np.ndarray) -> tuple[np.ndarray, ct.StateSpace]:
    """Return r through a resonance at 150 Hz, damping 0.1, behind a hold."""
    omega = 2 * np.pi * 150
    continuous = ct.tf2ss([omega**2], [1, 0.2 * omega, omega**2])
    sampled = ct.sample_system(continuous, T, "zoh")
    return ct.forced_response(sampled, T * np.arange(len(r)), r).outputs, sampled


def test_a_linear_object_is_found_to_a_thousandth() -> None:
    r = driven(**SWEEP)
    x, sampled = filtered(r)
    found = respond(r, x, T, **SWEEP)
    exact = sampled(np.exp(2j * np.pi * found.f_hz * T))
    assert np.max(np.abs(found.G / exact - 1)) < 1e-3
    assert np.max(found.distortion) < 1e-2


def test_peak_bandwidth_and_notch_of_a_resonance() -> None:
    sweep: dict[str, Any] = {"f_1": 100.0, "f_N": 300.0, "N": 21, "T_d": 1.0}
    r = driven(**sweep)
    x, _ = filtered(r)
    found = respond(r, x, T, **sweep)
    # the top of 1/|...| lies at f sqrt(1 - 2 zeta^2)
    f, size = peak(found)
    assert f == pytest.approx(150 * np.sqrt(0.98), rel=5e-3)
    assert size == pytest.approx(5.0252, rel=0.01)  # lines 6 % apart
    assert bandwidth(found) == pytest.approx(231.0, rel=5e-3)
    named = notch_at_peak(r, x, T, **sweep, name="omega_hz")
    assert named == {"omega_hz": f}
    with pytest.raises(ValueError, match="no peak above"):
        peak(found, above_hz=200.0)
    with pytest.raises(ValueError, match="does not fall"):
        bandwidth(found, level=1e-3)
    with pytest.raises(ValueError, match="stop later"):
        respond(r[:-10], x[:-10], T, **sweep)


def test_every_dwell_begins_and_ends_at_zero_with_whole_periods() -> None:
    f_hz = frequencies(**SWEEP)
    periods = f_hz * SWEEP["T_d"] / 2
    assert periods == pytest.approx(np.round(periods))
    r = driven(**SWEEP)
    dwell = round(SWEEP["T_d"] / T)
    assert np.abs(r[::dwell]).max() < 1e-9


def swept(amplitude: str, *overrides: str) -> tuple[np.ndarray, np.ndarray]:
    """Return f_hz and G (m/A) of the light axis in open loop, co-simulated."""
    names = [f"source.{k}={v}" for k, v in SWEEP.items()]
    told = [f"source.amplitude={amplitude}", *names, "stop=18/5", *overrides]
    done = run(load_scenario("leadscrew_nctf/sweep_open", told), report=False)
    r, x = (done[name].values for name in ("source.u", "y_axis.x"))
    found = respond(r, x, T, **SWEEP)
    return found.f_hz, found.G


def test_the_co_simulated_mechanism_without_friction_is_its_linearisation() -> None:
    f_hz, G = swept("0.1", "y_axis.T_c=0", "y_axis.C_sd=0.02")
    p = axis.Parameters(T_c=0.0, C_sd=0.02)
    plant = linearise(axis.model, parameters=p, inputs=["u"], outputs=["x"])
    keep = [i for i, name in enumerate(plant.state_labels) if name != "state.z"]
    A, B, C = plant.A[np.ix_(keep, keep)], plant.B[keep], plant.C[:, keep]
    held = ct.sample_system(ct.ss(A, B, C, 0), T, "zoh")
    exact = held(np.exp(2j * np.pi * f_hz * T))
    assert np.max(np.abs(G / exact - 1)) < 0.01


def test_friction_shows_as_a_peak_at_small_amplitudes_only() -> None:
    """Peak 1 of fig. 4-2: near 100 Hz at 0.1 A, gone at 1 A."""
    f_hz, small = swept("0.1")
    _, large = swept("1")
    near = int(np.argmin(np.abs(f_hz - 100)))
    assert np.abs(small)[near] > 1.5 * np.abs(small)[0]
    assert np.abs(large)[near] < 0.1 * np.abs(large)[0]
