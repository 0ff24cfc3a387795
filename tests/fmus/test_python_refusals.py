"""What a Python FMU refuses is an error with a reason, and changes nothing."""

import ctypes

import fmpy
import numpy as np
import pytest
from python_slave import put, python_fmu, read, start


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"u": 1.0}, "u cannot be set"),
        ({"T_s": 1.0}, "T_s cannot be set"),
        ({"r": float("nan")}, "r cannot be nan"),
        ({"state.q": 0.0}, "state.q cannot be set once stepping has begun"),
    ],
)
def test_what_may_not_be_set_is_an_error_that_changes_nothing(slave, values, said):
    fmu = start(slave(python_fmu("pi")), r=0.1)
    before = read(fmu, *fmu.references)
    with pytest.raises(fmpy.fmi1.FMICallException, match="error"):
        put(fmu, **values)
    assert any(f"instance (SmallPI): {said}" in message for message in fmu.messages)
    np.testing.assert_equal(read(fmu, *fmu.references), before)
    fmu.doStep(0.0, 1 / 2000)


def test_a_variable_that_is_not_there_is_an_error(slave):
    fmu = start(slave(python_fmu("pi")))
    for call in (
        lambda: fmu.getReal([10_000]),
        lambda: fmu.getInteger([0]),
        lambda: fmu.getString([0]),
        lambda: fmu.getBoolean([fmu.references["r"]]),
    ):
        with pytest.raises(fmpy.fmi1.FMICallException, match="error"):
            call()
    assert any("no variable with reference 10000" in m for m in fmu.messages)
    fmu.doStep(0.0, 1 / 2000)


def test_calls_out_of_order_are_errors(slave):
    fmu = slave(python_fmu("pi"))
    for call, then in (
        (lambda: fmu.doStep(0.0, 1 / 2000), fmu.setupExperiment),
        (fmu.exitInitializationMode, fmu.enterInitializationMode),
        (fmu.enterInitializationMode, fmu.exitInitializationMode),
        (fmu.exitInitializationMode, fmu.terminate),
        (lambda: fmu.doStep(0.0, 1 / 2000), fmu.reset),
        (fmu.terminate, fmu.setupExperiment),
    ):
        with pytest.raises(fmpy.fmi1.FMICallException, match="error"):
            call()
        assert "is not allowed" in fmu.messages[-1]
        then()


def test_without_logging_or_its_category_nothing_is_said(slave):
    fmu = start(slave(python_fmu("pi")))
    for on, categories in ((0, []), (1, [b"logStatusFatal"])):
        texts = (ctypes.c_char_p * len(categories))(*categories)
        fmu.fmi2SetDebugLogging(fmu.component, on, len(categories), texts)
        with pytest.raises(fmpy.fmi1.FMICallException, match="error"):
            fmu.getReal([10_000])
    assert fmu.messages == []


@pytest.mark.parametrize(
    ("t", "h", "said"),
    [
        (0.0, 0.0, "a step of 0.0 s is no step"),
        (0.0, -1e-3, "is no step"),
        (1e-3, 1e-3, "stands at 0.0 s and cannot step from 0.001 s"),
    ],
)
def test_a_step_that_is_none_is_an_error_with_a_reason(slave, t, h, said):
    fmu = start(slave(python_fmu("pi")))
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmu.doStep(t, h)
    assert any(said in message for message in fmu.messages)


def test_an_infinite_result_names_the_variable(slave):
    fmu = start(slave(python_fmu("spring_mass")), k=1e300, c=1e300)
    with np.errstate(all="ignore"), pytest.raises(fmpy.fmi1.FMICallException):
        fmu.doStep(0.0, 1e-3)
    assert any("state.x is not finite" in message for message in fmu.messages)


def test_a_foreign_state_is_refused(slave):
    late = start(slave(python_fmu("late")))
    fmu = start(slave(python_fmu("pi")))
    for blob in (late.serializeFMUstate(late.getFMUstate()), b"no state at all"):
        state = fmu.deSerializeFMUstate(blob)
        with pytest.raises(fmpy.fmi1.FMICallException, match="error"):
            fmu.setFMUstate(state)
    assert any("this is a state of Late" in message for message in fmu.messages)


def test_after_a_failed_step_only_a_reset_or_an_earlier_state_helps(slave):
    fmu = start(slave(python_fmu("spring_mass")))
    saved = fmu.getFMUstate()
    put(fmu, k=1e300, c=1e300)
    for _ in range(2):
        with np.errstate(all="ignore"), pytest.raises(fmpy.fmi1.FMICallException):
            fmu.doStep(0.0, 1e-3)
    assert "no step after one that failed" in fmu.messages[-1]
    fmu.setFMUstate(saved)
    fmu.doStep(0.0, 1e-3)


def test_states_are_settable_before_stepping_begins(slave):
    fmu = start(slave(python_fmu("pi")), **{"state.q": 0.25})
    assert read(fmu, "u") == [0.25]
