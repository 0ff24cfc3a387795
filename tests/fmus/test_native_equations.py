"""A native FMU computes what the NumPy equations say, at the right times."""

from collections.abc import Callable
from ctypes import POINTER, c_double
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from fmpy import fmi2, fmi3
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from fmus.model import Continuous, add, pack


def rk4(model: Continuous, x: Any, u: Any, p: Any, h: float) -> Any:
    def f(state: Any) -> Any:
        return model.derivative(state, u, p)

    k1 = f(x)
    k2 = f(add(x, [(h / 2, k1)]))
    k3 = f(add(x, [(h / 2, k2)]))
    k4 = f(add(x, [(h, k3)]))
    return add(x, [(h / 6, k1), (h / 3, k2), (h / 3, k3), (h / 6, k4)])


def test_runge_kutta_steps_equal_numpy(compiled: Callable, version: int) -> None:
    built = compiled("shaft")
    model = built.model
    it = built.new(version)
    it.set("K", 650.0)
    it.set("friction", False)
    it.set("state.omega_l", -2.0)
    it.begin()
    p = model.parameters._replace(K=650.0, friction=False)
    x = model.state._replace(omega_l=-2.0)
    h = 5e-5
    for k in range(200):
        u = model.input._replace(tau=np.sin(400 * k * h), d=0.1 * (k > 100))
        it.set("tau", u.tau)
        it.set("d", u.d)
        it.step(k * h, h)
        for _ in range(5):
            x = rk4(model, x, u, p, h / 5)
        y = model.output(x, u, p)
        rates = model.derivative(x, u, p)
        for name in y._fields:
            assert it.get(name) == pytest.approx(getattr(y, name), rel=1e-12)
        for name in x._fields:
            assert it.get(f"state.{name}") == pytest.approx(
                getattr(x, name), rel=1e-12, abs=1e-15
            )
            assert it.get(f"der(state.{name})") == pytest.approx(
                getattr(rates, name), rel=1e-12, abs=1e-9
            )


def test_sampled_steps_equal_numpy(compiled: Callable, version: int) -> None:
    built = compiled("pi")
    model = built.model
    it = built.new(version)
    it.set("T_i", 0.02)
    it.begin()
    T_s = float(model.period)
    p, x = model.parameters._replace(T_i=0.02), model.state
    for k in range(500):
        if k == 300:
            p = p._replace(K_p=0.7)
            it.set("K_p", 0.7)
        u = model.input._replace(r=np.cos(k), y=0.01 * k)
        it.set("r", u.r)
        it.set("y", u.y)
        it.step(k * T_s, T_s)
        x, y = model.step(x, u, p, T_s, model.prepare(p, T_s))
        assert it.get("u") == pytest.approx(y.u, rel=1e-12)
        assert it.get("state.q") == pytest.approx(x.q, rel=1e-12)
        assert it.get("ticks") == k + 1


def test_arrays_keep_their_order(compiled: Callable, version: int) -> None:
    it = compiled("mix").new(version)
    K = np.arange(6.0).reshape(2, 3) ** 2
    it.set("K", K)
    it.set("u", [1.0, -2.0, 0.5])
    it.begin()
    it.step(0.0, 1e-3)
    np.testing.assert_allclose(it.get("y"), K @ [1.0, -2.0, 0.5] + [1.0, -1.0])
    assert it.get("z") == 2.0 + K[1, 0]
    np.testing.assert_array_equal(it.get("K"), K)
    np.testing.assert_allclose(it.get("state.s"), [1.002, -0.998])


def test_advance_replaces_runge_kutta(compiled: Callable, version: int) -> None:
    it = compiled("exact").new(version).begin()
    it.set("u", 3.0)
    it.step(0.0, 0.0123)
    x = 3.0 - 2.0 * np.exp(-300.0 * 0.0123)
    assert it.get("state.x") == pytest.approx(x, rel=1e-12)
    assert it.get("y") == pytest.approx(x + 3.0, rel=1e-12)


def test_start_values_are_those_of_the_model(compiled: Callable, version: int) -> None:
    for name in "shaft", "pi", "mix", "late":
        built = compiled(name)
        it = built.new(version)
        for variable in built.layout.variables:
            if variable.start:
                np.testing.assert_array_equal(
                    np.ravel(it.get(variable.name)), variable.start
                )


def test_outputs_follow_what_is_set_before_stepping(
    compiled: Callable, version: int
) -> None:
    shaft = compiled("shaft").new(version)
    shaft.enter()
    shaft.set("tau", 0.25)
    assert shaft.get("felt") == pytest.approx(700 * 0.1 + 0.25)
    shaft.set("K", 100.0)
    assert shaft.get("felt") == pytest.approx(100 * 0.1 + 0.25)
    assert shaft.get("der(state.omega_m)") == pytest.approx((0.25 - 10) / 2e-3)

    pi = compiled("pi").new(version)
    pi.enter()
    pi.set("r", 2.0)
    assert pi.get("u") == pytest.approx(0.5 * 2.0 + 0.25)
    assert pi.get("u") == pytest.approx(0.5 * 2.0 + 0.25)
    assert pi.get("state.k") == 0.0
    pi.fmu.exitInitializationMode()
    assert pi.get("u") == pytest.approx(0.5 * 2.0 + 0.25)


def test_a_get_after_a_set_shows_the_outputs_of_the_last_step(
    compiled: Callable, version: int
) -> None:
    it = compiled("shaft").new(version).begin()
    it.step(0.0, 5e-5)
    before = it.all()
    it.set("tau", 9.0)
    it.set("K", 500.0)
    after = it.all()
    assert after.pop("tau") == 9.0
    assert after.pop("K") == 500.0
    assert after.items() <= before.items()


def test_several_ticks_or_none_fall_into_a_step(
    compiled: Callable, version: int
) -> None:
    it = compiled("pi").new(version).begin(start=2.0)
    it.step(2.0, 2e-5)
    assert it.get("ticks") == 1
    it.step(2.00002, 2e-5)
    assert it.get("ticks") == 1
    it.step(2.00004, 0.99996)
    assert it.get("ticks") == 20_000


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(1, 40), min_size=1, max_size=40))
def test_ticks_run_however_the_time_is_cut(compiled: Callable, cuts: list[int]) -> None:
    """Steps of sevenths of 1/3000 s; tick j runs once its time is passed."""
    it = compiled("third").new().begin()
    for before, cut in zip(np.cumsum([0, *cuts]), cuts, strict=False):
        t = before / 21_000
        it.step(t, (before + cut) / 21_000 - t)
        assert it.get("ticks") == -(-(before + cut) // 7)
    it.fmu.freeInstance()


def test_random_steps_add_up_to_the_same_motion(
    compiled: Callable, version: int
) -> None:
    built = compiled("shaft")
    whole, cut = (built.new(version, name).begin() for name in ("whole", "cut"))
    whole.step(0.0, 0.05)
    times = np.sort(np.random.default_rng(1).uniform(0, 0.05, 300))
    times = np.concatenate([[0.0], times, [0.05]])
    for t, end in pairwise(times):
        cut.step(t, end - t)
    for variable in built.layout.block("state"):
        assert cut.get(variable.name) == pytest.approx(
            whole.get(variable.name), rel=1e-6, abs=1e-9
        )


def test_a_period_that_is_no_decimal_is_met_exactly(
    compiled: Callable, version: int
) -> None:
    it = compiled("third").new(version).begin()
    for k in range(3000):
        it.step(k / 3000, 1 / 3000)
    assert it.get("ticks") == 3000


def test_time_is_a_variable_after_all_others(compiled: Callable, version: int) -> None:
    built = compiled("pi")
    it = built.new(version).begin(start=1.0)
    it.step(1.0, 0.25)
    read = it.fmu.getReal if version == 2 else it.fmu.getFloat64
    assert read([built.layout.size]) == [1.25]


@pytest.mark.parametrize("name", ["exact", "late", "pi"])
def test_only_plain_equations_can_be_exchanged(
    compiled: Callable, version: int, name: str
) -> None:
    built = compiled(name)
    kind = fmi2.FMU2Model if version == 2 else fmi3.FMU3Model
    model = kind(
        guid="token-100%",
        modelIdentifier=built.model.name,
        unzipDirectory=str(built.folder),
        instanceName="me",
    )
    with pytest.raises(Exception, match="nstantiat"):
        model.instantiate()


def test_model_exchange_gives_the_trajectory_of_the_equations(
    compiled: Callable, version: int
) -> None:
    built = compiled("shaft")
    model = built.model
    arguments = {
        "guid": "token-100%",
        "modelIdentifier": model.name,
        "unzipDirectory": str(built.folder),
        "instanceName": "me",
    }
    fmu: Any
    if version == 2:
        fmu = fmi2.FMU2Model(**arguments)
        fmu.instantiate()
        fmu.setupExperiment()
        fmu.enterInitializationMode()
    else:
        fmu = fmi3.FMU3Model(**arguments)
        fmu.instantiate()
        assert fmu.getNumberOfContinuousStates() == 4
        assert fmu.getNumberOfEventIndicators() == 0
        fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    assert not any(
        fmu.newDiscreteStates() if version == 2 else fmu.updateDiscreteStates()
    )
    nominal = np.zeros(4)
    states, rates = np.zeros(4), np.zeros(4)
    pointers = [_pointer(v) for v in (states, rates, nominal)]
    fmu.getNominalsOfContinuousStates(pointers[2], 4)
    usual = [0.1, 10, 0.1, 10]  # of a length and a speed; the last by the model itself
    np.testing.assert_array_equal(nominal, usual)
    fmu.enterContinuousTimeMode()

    def exchanged(t: float, x: Any) -> Any:
        states[:] = x
        fmu.setTime(t)
        fmu.setContinuousStates(pointers[0], 4)
        if version == 2:
            fmu.getDerivatives(pointers[1], 4)
        else:
            fmu.getContinuousStateDerivatives(pointers[1], 4)
        return rates.copy()

    def written(t: float, x: Any) -> Any:
        state = type(model.state)(*x)
        return pack(model.derivative(state, model.input, model.parameters))

    tight = {"rtol": 1e-10, "atol": 1e-12}
    got, expected = (
        solve_ivp(f, (0, 0.02), pack(model.state), **tight)
        for f in (exchanged, written)
    )
    np.testing.assert_allclose(got.y[:, -1], expected.y[:, -1], rtol=1e-6)
    for x in got.y.T:
        np.testing.assert_allclose(exchanged(0.0, x), written(0.0, x), rtol=1e-10)
    fmu.completedIntegratorStep()
    fmu.getContinuousStates(pointers[1], 4)
    np.testing.assert_array_equal(rates, states)
    fmu.enterEventMode()
    fmu.terminate()
    fmu.freeInstance()


def _pointer(values: Any) -> Any:
    return values.ctypes.data_as(POINTER(c_double))
