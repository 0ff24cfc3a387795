"""The table's axis against the closed form of its transfer function."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.synthesis.linearise import linearise
from fmus.simulation import Simulation
from plants.xy_table import axis as xy_table

B, TAU = 78020.0, 1.2e-3
POLES = np.roots([1, 163, 193.3])


def step_response(t: np.ndarray) -> np.ndarray:
    """Return position after a step of 1 V at t = 0, by partial fractions."""
    late = np.maximum(t - TAU, 0)
    p, q = POLES
    rise = (np.exp(p * late) - 1) / p - (np.exp(q * late) - 1) / q
    return np.asarray(B * rise / (p - q))


def test_poles_and_static_gain_are_the_identified_ones() -> None:
    plant = linearise(xy_table.model, inputs=["u"], outputs=["y"])
    assert np.sort(plant.poles().real) == pytest.approx([-161.805, -1.19465], rel=1e-5)
    assert plant.dcgain() == pytest.approx(403.62, rel=1e-5)


def position(steps: list[float], u: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the instants and positions of a run with these steps and inputs."""
    axis = Simulation(xy_table.model)
    axis.begin()
    names = axis.layout
    times, positions = [0.0], [0.0]
    for h, voltage in zip(steps, u, strict=True):
        axis.values[names["u"].reference] = voltage
        axis.step(times[-1], h)
        times.append(times[-1] + h)
        positions.append(float(axis.values[names["y"].reference]))
    return np.array(times), np.array(positions)


@pytest.mark.parametrize("h", [1e-4, 5e-4, 7e-4, 1.2e-3, 3.1e-3])
def test_dead_time_is_exact_whatever_the_communication_step(h: float) -> None:
    n = round(0.03 / h)
    # the first step at rest, so that the change does not fall on the start
    times, y = position([h] * n, [0.0] + [1.0] * (n - 1))
    np.testing.assert_allclose(y, step_response(times - h), rtol=0, atol=1e-10)


@given(
    st.lists(
        st.tuples(st.floats(1e-5, 2e-3), st.floats(-2, 2)), min_size=5, max_size=30
    )
)
def test_uneven_steps_and_inputs_superpose(pairs: list[tuple[float, float]]) -> None:
    steps = [h for h, _ in pairs]
    u = [0.0] + [voltage for _, voltage in pairs[1:]]
    times, y = position(steps, u)
    expected = np.zeros_like(times)
    for start, change in zip(times, np.diff(u, prepend=0.0), strict=False):
        expected += change * step_response(times - start)
    np.testing.assert_allclose(y, expected, rtol=0, atol=1e-10)
