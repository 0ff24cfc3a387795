"""What the master injects goes through a loop as the loop's own formula says."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from systems import part, system

from orchestrator.master.fused.lanes import Lanes
from orchestrator.master.simulate import plan, simulate
from orchestrator.result import Recorded, Result
from orchestrator.system import Injection, Mapped, System

T, K, ROWS, N = 1e-3, -80.0, 1200, 50
A = 0.3


def loop(latency: int, sink_gain: float = 1.0) -> System:
    """u = K x, published ``latency`` samples late, integrated: x⁺ = x + T (u + d)."""
    parts = [
        part("gain", "counter", "1/1000", latency=latency, parameters={"gain": K}),
        part(
            "sum", "integrator", "1/1000", map={"u": Mapped("u", sink_gain, unit="1")}
        ),
    ]
    wires = {"gain.u": "sum.y", "sum.u": "gain.seen"}
    record = {"sum.y": "1/1000", "gain.seen": "1/1000"}
    given = system("1199/1000", parts, wires, record)
    sine = A * np.sin(2 * np.pi * np.arange(N) / N)
    return replace(given, injections={"sum.u": Injection((*sine,))})


def amplitude(values: NDArray[np.float64]) -> complex:
    """The sine's phasor over the last period."""
    last = values[-N:]
    k = np.arange(len(values) - N, len(values))
    return complex(2j / N * np.sum(last * np.exp(-2j * np.pi * k / N)))


@pytest.mark.parametrize("latency", [0, 1, 2])
@pytest.mark.parametrize("executor", ["python", "kernel", "fused", "lanes"])
def test_an_injected_sine_goes_through_the_loop_as_its_formula_says(
    executor: str, latency: int, tmp_path: Path
) -> None:
    given = loop(latency)
    found: Recorded
    if executor == "lanes":
        (member, _) = Lanes(plan(given), frozenset({"sum.y", "gain.seen"}), 2).run(
            [{}, {}]
        )
        found = member.signals
    else:
        found = simulate(given, tmp_path, executor=executor)  # type: ignore[arg-type]
        assert isinstance(found, Result)
    z = np.exp(2j * np.pi / N)
    plant = T / (z - 1)
    closed = plant / (1 - K * z**-latency * plant)
    x = found["sum.y"].values
    assert amplitude(x) == pytest.approx(A * closed, rel=1e-9)
    assert amplitude(found["gain.seen"].values) == pytest.approx(
        A * K * z**-latency * closed, rel=1e-9
    )


def test_a_sink_that_counts_otherwise_receives_the_injection_in_our_numbers(
    tmp_path: Path,
) -> None:
    """Their u is -2 times ours: the plant integrates twice as fast, downwards."""
    given = loop(0, -2.0)
    parts = dict(given.components)
    parts["gain"] = replace(parts["gain"], parameters={"gain": -K / 2})
    x = simulate(replace(given, components=parts), tmp_path)["sum.y"].values
    z = np.exp(2j * np.pi / N)
    plant = -2 * T / (z - 1)
    assert amplitude(x) == pytest.approx(A * plant / (1 + K / 2 * plant), rel=1e-9)
