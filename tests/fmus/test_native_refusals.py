"""What may not be done is refused with a sentence, and changes nothing."""

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from fmpy import fmi2, fmi3


def set_outside(it: Any, name: str, value: float) -> str:
    message: str = it.refused(lambda: it.set(name, value))
    assert message.startswith("it: fmi")
    return message


def test_a_wrong_token_gives_no_instance(compiled: Callable, version: int) -> None:
    with pytest.raises(RuntimeError, match=r"the token .* is not that of this binary"):
        compiled("pi").new(version, fmu={"guid": "other"})


@pytest.mark.parametrize("logging", [True, False])
def test_an_instance_needs_a_name(
    compiled: Callable, version: int, logging: bool
) -> None:
    with pytest.raises(RuntimeError, match="an instance needs a name"):
        compiled("pi").new(version, "", loggingOn=logging)


def test_null_arguments_do_not_crash(compiled: Callable) -> None:
    library = ctypes.CDLL(str(compiled("pi").library))
    library.fmi2Instantiate.restype = ctypes.c_void_p
    assert library.fmi2Instantiate(None, 1, b"token-100%", None, None, 0, 1) is None
    assert library.fmi2Instantiate(b"it", 1, None, None, None, 0, 1) is None
    assert library.fmi2DoStep(None, ctypes.c_double(0), ctypes.c_double(1), 0) == 3
    assert library.fmi3Terminate(None) == 3
    library.fmi2FreeInstance(None)
    library.fmi3FreeInstance(None)
    it = library.fmi2Instantiate(b"it", 1, b"token-100%", None, None, 0, 1)
    it = ctypes.c_void_p(it)
    assert library.fmi2ExitInitializationMode(it) == 3
    assert library.fmi2SetFMUstate(it, None) == 3
    library.fmi2FreeInstance(it)


def test_unsupported_ways_to_instantiate_say_so(compiled: Callable) -> None:
    built = compiled("shaft")
    with pytest.raises(RuntimeError, match="event mode"):
        built.new(3, eventModeUsed=True)
    log: list[str] = []
    it = fmi3.FMU3ScheduledExecution(
        guid="token-100%",
        modelIdentifier="Shaft",
        unzipDirectory=str(built.folder),
        instanceName="it",
    )
    with pytest.raises(Exception, match="Failed"):
        it.instantiate(logMessage=lambda e, s, c, message: log.append(message))
    assert b"use co-simulation" in log[0]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("omega", "it is computed by the model"),
        ("der(state.theta_m)", "it is computed by the model"),
        ("C", "it is a constant"),
        ("J_l", "it is a fixed parameter"),
        ("state.theta_m", "states are set before or during initialization"),
    ],
)
def test_what_cannot_be_set_while_stepping(
    compiled: Callable, version: int, name: str, expected: str
) -> None:
    it = compiled("shaft").new(version).begin()
    before = it.all()
    message = set_outside(it, name, 1.0)
    assert f"{name} cannot be set now: {expected}" in message
    assert it.all() == before
    it.step(0.0, 1e-3)


def test_period_and_time_cannot_be_set(compiled: Callable, version: int) -> None:
    it = compiled("pi").new(version)
    assert "T_s cannot be set now: it is a constant" in set_outside(it, "T_s", 1.0)
    write = it.fmu.setReal if version == 2 else it.fmu.setFloat64
    time = it.layout.size
    assert "it is the time" in it.refused(lambda: write([time], [1.0]))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_only_finite_values_are_taken(
    compiled: Callable, version: int, value: float
) -> None:
    it = compiled("shaft").new(version)
    for name in "K", "tau", "state.theta_l":
        message = set_outside(it, name, value)
        assert f"{name} cannot be" in message
        assert "finite value was expected" in message
        assert np.isfinite(it.get(name))


def test_a_set_of_several_is_done_whole_or_not_at_all(
    compiled: Callable, version: int
) -> None:
    it = compiled("shaft").new(version).begin()
    write = it.fmu.setReal if version == 2 else it.fmu.setFloat64
    references = [it.layout["tau"].reference, it.layout["J_l"].reference]
    it.refused(lambda: write(references, [7.0, 7.0]))
    assert it.get("tau") == 0.5


def test_unknown_references_are_named(compiled: Callable, version: int) -> None:
    it = compiled("pi").new(version)
    read = it.fmu.getReal if version == 2 else it.fmu.getFloat64
    assert "value reference 999" in it.refused(lambda: read([999]))


def test_other_types_are_refused_by_name(compiled: Callable, version: int) -> None:
    it = compiled("shaft").new(version)
    switch, number = it.layout["friction"].reference, it.layout["K"].reference
    if version == 2:
        wrong = [
            lambda: it.fmu.getReal([switch]),
            lambda: it.fmu.setReal([switch], [0.0]),
            lambda: it.fmu.getInteger([switch]),
            lambda: it.fmu.setInteger([switch], [0]),
            lambda: it.fmu.getString([switch]),
        ]
        other = [lambda: it.fmu.getBoolean([number])]
    else:
        wrong = [
            lambda: it.fmu.getFloat64([switch]),
            lambda: it.fmu.getFloat32([switch]),
            lambda: it.fmu.setInt32([switch], [0]),
            lambda: it.fmu.getUInt8([switch]),
            lambda: it.fmu.getString([switch]),
            lambda: it.fmu.getClock([switch]),
        ]
        other = [lambda: it.fmu.getBoolean([number])]
    for call in wrong:
        assert "friction is a Boolean variable" in it.refused(call)
    for call in other:
        assert "K is a floating-point variable" in it.refused(call)


def test_arrays_must_be_whole_in_fmi3(compiled: Callable) -> None:
    it = compiled("mix").new(3)
    K = it.layout["K"].reference
    assert "K has 6 values, but only 5" in it.refused(
        lambda: it.fmu.setFloat64([K], [0.0] * 5)
    )
    assert "values more than" in it.refused(lambda: it.fmu.setFloat64([K], [0.0] * 7))
    assert "lies inside K" in it.refused(lambda: it.fmu.getFloat64([K + 1], 1))
    np.testing.assert_array_equal(it.get("K"), [[1, 2, 3], [4, 5, 6]])


@pytest.mark.parametrize("h", [0.0, -1e-3, np.nan, np.inf])
def test_a_step_must_go_forward(compiled: Callable, version: int, h: float) -> None:
    it = compiled("shaft").new(version).begin()
    assert "must be positive" in it.refused(lambda: it.step(0.0, h))
    it.step(0.0, 1e-3)


def test_a_step_must_begin_where_the_instance_stands(
    compiled: Callable, version: int
) -> None:
    it = compiled("pi").new(version).begin(start=0.5)
    message = it.refused(lambda: it.step(0.0, 1e-3))
    assert "begins at 0 s, but the instance stands at 0.5 s" in message
    it.step(0.5, 1e-3)
    it.refused(lambda: it.step(0.5, 1e-3))
    it.refused(lambda: it.step(np.nan, 1e-3))
    it.step(0.501 * (1 + 1e-15), 1e-3)


def test_no_step_leads_past_the_stop_time(compiled: Callable, version: int) -> None:
    it = compiled("pi").new(version).begin(stop=0.3)
    for k in range(3):
        it.step(k * 0.1, 0.1)
    assert "after the stop time" in it.refused(lambda: it.step(3 * 0.1, 0.1))


def test_a_step_without_end_is_refused(compiled: Callable, version: int) -> None:
    for name in "shaft", "pi":
        it = compiled(name).new(version).begin()
        assert "inner steps" in it.refused(lambda it=it: it.step(0.0, 1e12))


def test_order_of_calls_is_kept(compiled: Callable, version: int) -> None:
    it = compiled("pi").new(version)
    assert "not allowed before initialization" in it.refused(lambda: it.step(0.0, 1.0))
    it.refused(it.fmu.exitInitializationMode)
    it.refused(it.fmu.terminate)
    it.enter()
    assert "not allowed in initialization" in it.refused(lambda: it.step(0.0, 1.0))
    it.fmu.exitInitializationMode()
    it.refused(it.fmu.exitInitializationMode)
    it.step(0.0, 1.0)
    it.fmu.terminate()
    assert "not allowed after terminate" in it.refused(lambda: it.step(1.0, 1.0))
    assert "the simulation is over" in set_outside(it, "r", 0.0)
    assert it.get("ticks") == 20_000
    it.fmu.freeInstance()


def test_a_result_that_is_not_finite_fails_the_step_and_reset_recovers(
    compiled: Callable, version: int
) -> None:
    it = compiled("explosive").new(version).begin()
    good = it.saved()
    message = it.refused(lambda: it.step(0.0, 1.0))
    assert "state.x is" in message or "y is" in message
    assert "finite values were expected" in message
    assert "after a failed step" in it.refused(lambda: it.step(1.0, 1.0))
    if version == 2:
        assert it.fmu.getRealStatus(fmi2.fmi2LastSuccessfulTime) == 0.0
    it.restore(good)
    it.step(0.0, 1e-3)
    it.refused(lambda: it.step(1e-3, 1.0))
    it.fmu.reset()
    it.begin()
    it.step(0.0, 1e-3)


def test_initialization_ends_only_with_finite_outputs(
    compiled: Callable, version: int
) -> None:
    it = compiled("pi").new(version)
    it.enter()
    it.set("T_i", 0.0)
    it.set("state.q", 1e308)
    it.set("K_p", 1e308)
    it.set("r", 1e308)
    message = it.refused(it.fmu.exitInitializationMode)
    assert "u is inf" in message
    it.set("r", 0.0)
    it.fmu.exitInitializationMode()


def test_logging_can_be_switched_off(compiled: Callable, version: int) -> None:
    it = compiled("pi").new(version, loggingOn=False)

    def wrong() -> None:
        with pytest.raises(Exception, match="status 3"):
            it.step(0.0, 1.0)

    wrong()
    assert it.log == []
    it.fmu.setDebugLogging(True, ["logStatusError"])
    wrong()
    assert len(it.log) == 1
    it.fmu.setDebugLogging(True, ["logStatusWarning"])
    wrong()
    it.fmu.setDebugLogging(False, [])
    wrong()
    assert len(it.log) == 1
    it.fmu.setDebugLogging(True, [])
    assert "no log category logNoise" in it.refused(
        lambda: it.fmu.setDebugLogging(True, ["logNoise"])
    )


def test_long_names_are_not_cut(compiled: Callable, version: int) -> None:
    name = "Antrieb_" + "ä" * 2000
    it = compiled("pi").new(version, name)
    assert it.refused(lambda: it.step(0.0, 1.0)).startswith(
        f"{name}: fmi{version}DoStep"
    )


def test_a_percent_sign_is_no_format(compiled: Callable) -> None:
    it = compiled("pi").new(3, "100%s")
    assert it.refused(lambda: it.step(0.0, 1.0)).startswith("100%s: ")
    it = compiled("pi").new(2, "100%s")
    assert it.refused(lambda: it.step(0.0, 1.0)).startswith("100%%s: ")


def test_unsupported_functions_say_so(compiled: Callable) -> None:
    two = compiled("shaft").new(2).begin()
    for call in (
        two.fmu.cancelStep,
        lambda: two.fmu.getIntegerStatus(fmi2.fmi2DoStepStatus),
        lambda: two.fmu.getStringStatus(fmi2.fmi2PendingStatus),
        lambda: two.fmu.getRealOutputDerivatives([0], [1]),
        lambda: two.fmu.setRealInputDerivatives([0], [1], [0.0]),
    ):
        assert "not supported" in two.refused(call)
    two.step(0.0, 0.25)
    assert two.fmu.getRealStatus(fmi2.fmi2LastSuccessfulTime) == 0.25
    assert two.fmu.getBooleanStatus(fmi2.fmi2Terminated) is False
    three = compiled("shaft").new(3).begin()
    for call in (
        three.fmu.enterConfigurationMode,
        three.fmu.enterStepMode,
        lambda: three.fmu.fmi3EvaluateDiscreteStates(three.fmu.component),
        lambda: three.fmu.getAdjointDerivative([0], [1], [1.0], 1),
        lambda: three.fmu.getOutputDerivatives([0], [1]),
    ):
        assert "not supported" in three.refused(call)


def test_derivatives_are_of_unknowns_by_knowns(
    compiled: Callable, version: int
) -> None:
    built = compiled("shaft")
    it = built.new(version).begin()
    size = (1,) if version == 3 else ()
    mass, speed, torque = (
        built.layout[name].reference for name in ("J_m", "omega", "tau")
    )
    for knowns, unknowns, said in (
        ([torque], [mass], "is no unknown"),
        ([mass], [speed], "is no known"),
        ([torque], [9999], "9999"),
    ):
        call = (unknowns, knowns, [1.0], *size)
        assert said in it.refused(lambda c=call: it.fmu.getDirectionalDerivative(*c))
