"""One FMU instance on fmpy: the same calls for FMI 2 and 3, CS and ME.

Calls that an FMU refuses raise fmpy's ``FMICallException``.  A step that the FMU
ends the run with is none of these: ``step`` says so.
"""

from collections.abc import Callable, Sequence
from ctypes import byref, c_double
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
from fmpy.fmi1 import FMICallException, calloc, free
from fmpy.fmi2 import (
    FMU2Model,
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.logging import addLoggerProxy
from numpy.typing import NDArray

from orchestrator.checks.item import CannotRun
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.instances.group import strict

Kind: TypeAlias = Literal["co-simulation", "model exchange"]
Log: TypeAlias = Callable[[int, bytes | None, bytes | None], None]
CLASSES = {
    (2, "co-simulation"): FMU2Slave,
    (2, "model exchange"): FMU2Model,
    (3, "co-simulation"): FMU3Slave,
    (3, "model exchange"): FMU3Model,
}
ITERATIONS = 100  # of discrete states in one event
DISCARD = 2
LAST_SUCCESSFUL_TIME, TERMINATED = 2, 3  # what fmi2GetStatus can be asked for


def required_functions(kind: Kind, major: int) -> list[str]:
    """Return the names every library of this interface has to export."""
    return [name for name in dir(CLASSES[major, kind]) if name.startswith("fmi")]


def load(
    kind: Kind,
    description: FmuDescription,
    folder: Path,
    name: str,
    token: str | None,
    prefix: str = "",
) -> "Face":
    """Load the library of an unpacked FMU, whose functions may have a prefix.

    Raises:
        CannotRun: there is none for this machine, or it does not load.
    """
    face = {2: Face2, 3: Face3}[description.fmi_major]
    base: Any = CLASSES[description.fmi_major, kind]
    try:
        fmu = (_prefixed(base, prefix) if prefix else base)(
            guid=description.token if token is None else token,
            modelIdentifier=description.model_identifier,
            unzipDirectory=str(folder),
            instanceName=name,
        )
    except AttributeError as error:
        raise CannotRun(f"a function is missing: {error}") from None
    except Exception as error:  # fmpy raises bare Exception when loading fails
        raise CannotRun(str(error).replace(f"{folder}/", "")) from None
    return face(strict(fmu), kind)


def _prefixed(base: Any, prefix: str) -> Any:
    """Return fmpy's class for a library that says ``<prefix>fmi2DoStep``.

    Named alike, for fmpy reads the version of FMI from the name of the class.
    """

    class Library:
        def __init__(self, dll: Any) -> None:
            self._handle, self._dll = dll._handle, dll

        def __getattr__(self, name: str) -> Any:
            return getattr(self._dll, prefix + name)

    def load_functions(self: Any) -> None:
        self.dll = Library(self.dll)
        base._loadFunctions(self)

    return type(base.__name__, (base,), {"_loadFunctions": load_functions})


class Face:
    """What both versions of FMI share."""

    def __init__(self, fmu: Any, kind: Kind) -> None:
        self.fmu = fmu
        self.exchanging = kind == "model exchange"
        self.number_of_states = 0

    def instantiate(self, log: Log, logging: bool) -> None:
        raise NotImplementedError

    def enter(self, start: float, stop: float | None, tol: float | None) -> None:
        raise NotImplementedError

    def leave(self) -> bool:
        """Leave initialisation; tell whether the FMU ends the run at once."""
        self.fmu.exitInitializationMode()
        if not self.exchanging:
            return False
        ends = self._settle()
        if not ends:
            self.fmu.enterContinuousTimeMode()
        return ends

    def step(self, t: float, h: float) -> bool:
        """Step; tell whether the FMU ends the run there, as it may."""
        return self._euler(t, h) if self.exchanging else self._do_step(t, h)

    def _do_step(self, t: float, h: float) -> bool:
        raise NotImplementedError

    def forget(self) -> None:
        """Hear no more of the instance, which is gone."""

    def get(self, variable: FmuVariable) -> list[Any]:
        return self.get_many([variable])

    def get_many(self, variables: Sequence[FmuVariable]) -> list[Any]:
        """Return the values of variables of one type, one after the other."""
        raise NotImplementedError

    def set(self, variable: FmuVariable, values: Sequence[Any]) -> None:
        raise NotImplementedError

    def count_states(self) -> int:
        raise NotImplementedError

    def derivatives(self, values: Any, count: int) -> None:
        raise NotImplementedError

    def directional(
        self, unknowns: list[int], known: int, seed: list[float], size: int
    ) -> list[float]:
        """Return the ``size`` changes of the unknowns as a known changes by a seed."""
        raise NotImplementedError

    def rates(self, references: list[int]) -> list[float]:
        """Return the first derivatives of scalar outputs of a co-simulation."""
        raise NotImplementedError

    def states(self) -> NDArray[np.float64]:
        """Return the continuous states, shape (states,)."""
        count = self.count_states()
        values = (c_double * count)()
        if count:
            self.fmu.getContinuousStates(values, count)
        return np.array(values)

    def set_states(self, values: NDArray[np.float64]) -> None:
        if count := len(values):
            self.fmu.setContinuousStates((c_double * count)(*values), count)

    def _discrete_states(self) -> tuple[Any, ...]:
        """Update them; return whether once more is needed and whether it ends."""
        raise NotImplementedError

    def _settle(self) -> bool:
        for _ in range(ITERATIONS):
            again, ends, *_rest = self._discrete_states()
            if ends or not again:
                return bool(ends)
        return False

    def _euler(self, t: float, h: float) -> bool:
        self.fmu.setTime(t)
        states = self.states()
        slopes = (c_double * len(states))()
        if len(states):
            self.derivatives(slopes, len(states))
        self.fmu.setTime(t + h)
        self.set_states(states + h * np.array(slopes))
        enter, ends = self.fmu.completedIntegratorStep()
        if enter and not ends:
            self.fmu.enterEventMode()
            ends = self._settle()
            if not ends:
                self.fmu.enterContinuousTimeMode()
        return bool(ends)


_LISTENERS: dict[bytes | None, Log] = {}


def _hear(_env: Any, name: Any, status: int, category: Any, text: Any) -> None:
    latest = next(reversed(_LISTENERS.values()), None)
    if listener := _LISTENERS.get(name, latest):
        listener(status, category, text)


# One for all: fmpy's proxy, which formats the messages, keeps only the last it got.
_LOGGER = fmi2CallbackLoggerTYPE(_hear)


class Face2(Face):
    """FMI 2.0."""

    def instantiate(self, log: Log, logging: bool) -> None:
        _LISTENERS[self.fmu.instanceName.encode()] = log
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = _LOGGER
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        addLoggerProxy(byref(callbacks))
        try:
            self.fmu.instantiate(callbacks=callbacks, loggingOn=logging)
        except Exception:  # fmpy's way to say that there is no instance
            self.fmu.component = None

    def forget(self) -> None:
        _LISTENERS.pop(self.fmu.instanceName.encode(), None)

    def enter(self, start: float, stop: float | None, tol: float | None) -> None:
        self.fmu.setupExperiment(tolerance=tol, startTime=start, stopTime=stop)
        self.fmu.enterInitializationMode()

    def get_many(self, variables: Sequence[FmuVariable]) -> list[Any]:
        name = _fmi2_type(variables[0])
        values = getattr(self.fmu, f"get{name}")([v.reference for v in variables])
        return [v.decode("utf-8", "replace") if name == "String" else v for v in values]

    def set(self, variable: FmuVariable, values: Sequence[Any]) -> None:
        getattr(self.fmu, f"set{_fmi2_type(variable)}")([variable.reference], values)

    def count_states(self) -> int:
        return self.number_of_states

    def derivatives(self, values: Any, count: int) -> None:
        self.fmu.getDerivatives(values, count)

    def directional(
        self, unknowns: list[int], known: int, seed: list[float], size: int
    ) -> list[float]:
        found: list[float] = self.fmu.getDirectionalDerivative(unknowns, [known], seed)
        return found

    def rates(self, references: list[int]) -> list[float]:
        orders = [1] * len(references)
        found: list[float] = self.fmu.getRealOutputDerivatives(references, orders)
        return found

    def _discrete_states(self) -> tuple[Any, ...]:
        found: tuple[Any, ...] = self.fmu.newDiscreteStates()
        return found

    def _do_step(self, t: float, h: float) -> bool:
        try:
            self.fmu.doStep(t, h)
        except FMICallException as error:
            if error.status != DISCARD or not self._ends(t):
                raise
            return True
        return False

    def _ends(self, t: float) -> bool:
        """Tell whether a discarded step ends the run, or went a part of its way."""
        try:
            if self.fmu.getBooleanStatus(TERMINATED):
                return True
            return bool(self.fmu.getRealStatus(LAST_SUCCESSFUL_TIME) > t)
        except FMICallException:  # it does not say
            return False


class Face3(Face):
    """FMI 3.0."""

    def instantiate(self, log: Log, logging: bool) -> None:
        def message(_env: Any, status: int, category: Any, text: Any) -> None:
            log(status, category, text)

        try:
            self.fmu.instantiate(logMessage=message, loggingOn=logging)
        except Exception:  # fmpy's way to say that there is no instance
            self.fmu.component = None

    def enter(self, start: float, stop: float | None, tol: float | None) -> None:
        self.fmu.enterInitializationMode(tolerance=tol, startTime=start, stopTime=stop)

    def get_many(self, variables: Sequence[FmuVariable]) -> list[Any]:
        name, size = _fmi3_type(variables[0]), sum(v.size for v in variables)
        references = [v.reference for v in variables]
        values = getattr(self.fmu, f"get{name}")(references, size)
        return [v.decode("utf-8", "replace") if name == "String" else v for v in values]

    def set(self, variable: FmuVariable, values: Sequence[Any]) -> None:
        getattr(self.fmu, f"set{_fmi3_type(variable)}")(
            [variable.reference], list(values)
        )

    def count_states(self) -> int:
        from ctypes import c_size_t

        count = c_size_t()
        self.fmu.fmi3GetNumberOfContinuousStates(self.fmu.component, byref(count))
        return int(count.value)

    def derivatives(self, values: Any, count: int) -> None:
        self.fmu.getContinuousStateDerivatives(values, count)

    def directional(
        self, unknowns: list[int], known: int, seed: list[float], size: int
    ) -> list[float]:
        found: list[float] = self.fmu.getDirectionalDerivative(
            unknowns, [known], seed, nSensitivity=size
        )
        return found

    def rates(self, references: list[int]) -> list[float]:
        orders = [1] * len(references)
        found: list[float] = self.fmu.getOutputDerivatives(references, orders)
        return found

    def _discrete_states(self) -> tuple[Any, ...]:
        found: tuple[Any, ...] = self.fmu.updateDiscreteStates()
        return found

    def _do_step(self, t: float, h: float) -> bool:
        _event, ends, _early, _reached = self.fmu.doStep(t, h)
        return bool(ends)


def _fmi2_type(variable: FmuVariable) -> str:
    kind = variable.fmi_type
    return "Integer" if kind == "Enumeration" else kind


def _fmi3_type(variable: FmuVariable) -> str:
    kind = variable.fmi_type
    return "Int64" if kind == "Enumeration" else kind
