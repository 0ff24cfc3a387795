"""Linearisations against matrices written by hand and difference quotients."""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from controllers.synthesis.linearise import linearise, without_bystanders
from fmus.model import Continuous, Sampled, Var


class Inner(NamedTuple):
    q: Annotated[float, Var("rad", "angle")] = 0.3
    w: Annotated[np.ndarray, Var("rad/s", "speeds")] = np.array([1.0, -2.0])


class State(NamedTuple):
    inner: Inner = Inner()
    z: Annotated[float, Var("1", "integral")] = 0.5


class Input(NamedTuple):
    u: Annotated[float, Var("V", "voltage")] = 0.2
    d: Annotated[float, Var("V", "disturbance")] = 0.0


class Output(NamedTuple):
    y: Annotated[float, Var("rad", "angle")]
    s: Annotated[float, Var("1", "sine of the angle")]


class Parameters(NamedTuple):
    a: Annotated[float, Var("1/s", "rate")] = 2.0


def derivative(x: State, u: Input, p: Parameters) -> State:
    return State(
        Inner(x.inner.w[0], x.inner.w * -p.a + u.u),
        np.sin(x.inner.q) * u.u + u.d,
    )


def output(x: State, u: Input, p: Parameters) -> Output:
    return Output(x.inner.q + x.z, np.sin(x.inner.q) + p.a * u.d)


def step(x, u, p, T_s, gain):
    slope = derivative(x, u, p)
    inner = Inner(x.inner.q + T_s * slope.inner.q, x.inner.w + T_s * slope.inner.w)
    return State(inner, x.z + T_s * slope.z), output(x, u, p)


class Derived(NamedTuple):
    gain: Annotated[float, Var("1", "gain")] = 0.0


def prepare(p, T_s):
    return Derived(p.a * T_s)


plant = Continuous("Plant", derivative, output, State(), Input(), Parameters())
law = Sampled(
    "Law", step, State(), Input(), Parameters(), Fraction(1, 500), prepare=prepare
)


def test_a_plant_is_linearised_as_by_hand():
    system = linearise(plant)
    s, c = np.sin(0.3), np.cos(0.3)
    np.testing.assert_allclose(
        system.A, [[0, 1, 0, 0], [0, -2, 0, 0], [0, 0, -2, 0], [0.2 * c, 0, 0, 0]]
    )
    np.testing.assert_allclose(system.B, [[0, 0], [1, 0], [1, 0], [s, 1]])
    np.testing.assert_allclose(system.C, [[1, 0, 0, 1], [c, 0, 0, 0]])
    np.testing.assert_allclose(system.D, [[0, 0], [0, 2]])
    assert system.dt == 0


def test_states_and_signals_keep_their_names():
    system = linearise(plant)
    assert system.state_labels == [
        "state.inner.q",
        "state.inner.w[1]",
        "state.inner.w[2]",
        "state.z",
    ]
    assert system.input_labels == ["u", "d"]
    assert system.output_labels == ["y", "s"]


def test_a_sampled_law_is_linearised_at_its_own_or_a_given_period():
    continuous = linearise(plant)
    for T_s, expected in ((None, 0.002), (0.01, 0.01)):
        system = linearise(law, T_s=T_s)
        assert system.dt == expected
        np.testing.assert_allclose(system.A, np.eye(4) + expected * continuous.A)
        np.testing.assert_allclose(system.B, expected * continuous.B)
        np.testing.assert_allclose(system.D, continuous.D)


def test_the_point_and_the_parameters_can_be_chosen():
    system = linearise(
        plant,
        parameters=Parameters(a=5.0),
        state=State(Inner(q=1.0)),
        input=Input(u=3.0),
    )
    assert system.A[1, 1] == -5
    assert system.A[3, 0] == pytest.approx(3 * np.cos(1.0))


def test_signals_are_selected_in_the_order_asked_for():
    system = linearise(plant, inputs=["d"], outputs=["s", "y"])
    np.testing.assert_allclose(system.D, [[2], [0]])
    np.testing.assert_allclose(system.B, [[0], [0], [0], [1]])
    assert system.input_labels == ["d"]
    assert system.output_labels == ["s", "y"]


def test_an_unknown_signal_is_refused_with_those_there_are():
    with pytest.raises(LookupError, match="no 'x', there are y, s"):
        linearise(plant, outputs=["x"])


def test_states_outside_the_path_of_the_signals_are_dropped():
    # q is shown by y and moved by w_1; w_2 leads nowhere, s follows from q alone
    system = without_bystanders(linearise(plant, inputs=["u"], outputs=["s"]))
    assert system.state_labels == ["state.inner.q", "state.inner.w[1]"]
    whole = linearise(plant, inputs=["u"], outputs=["s"])
    at = 3j
    np.testing.assert_allclose(system(at), whole(at))
