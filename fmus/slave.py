"""What a Python FMU runs: a model's own NumPy equations behind FMI 2.0.

pythonfmu 0.7 answers a Python exception with Fatal and releases the instance
twice, which kills the host.  So nothing raises once the instance exists: what
is refused changes nothing and is logged as an error, which the gate
(``python_gate.c``) turns into the status Error.  After a step that failed half way
the instance must be reset or set back to an earlier state.  This module and
``fmus.simulation`` are bundled into every Python FMU and import nothing but
NumPy, pythonfmu and the model contract.
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

import numpy as np
from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from fmus.layout import Variable
from fmus.model import Model
from fmus.simulation import Simulation

INSTANTIATED, INITIALIZING, STEPPING, TERMINATED = (
    "before initialization mode",
    "in initialization mode",
    "between steps",
    "after terminate",
)


class ModelSlave(Fmi2Slave):  # type: ignore[misc]
    """Base of every Python FMU; the generated subclass only names its model."""

    model: ClassVar[Model]

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.simulation = Simulation(self.model)
        self.phase = INSTANTIATED
        self.time = 0.0
        self.stop_time = np.inf
        self.failed = False
        variables = self.simulation.layout.variables
        self.owners = {r: v for v in variables for _, r in v.elements()}

    def setup_experiment(
        self,
        start_time: float,
        stop_time: float | None = None,
        tolerance: float | None = None,
    ) -> None:
        """Take start and stop time (s); the tolerance means nothing here."""
        with self._refusing():
            self._only(INSTANTIATED, "fmi2SetupExperiment")
            self.time = self.simulation.start_time = start_time
            self.stop_time = np.inf if stop_time is None else stop_time

    def enter_initialization_mode(self) -> None:
        """Begin initialization."""
        with self._refusing():
            self._only(INSTANTIATED, "fmi2EnterInitializationMode")
            self.phase = INITIALIZING

    def exit_initialization_mode(self) -> None:
        """Publish the initial outputs; from now on only steps change them."""
        with self._refusing():
            self._only(INITIALIZING, "fmi2ExitInitializationMode")
            self.simulation.refresh()
            self.simulation.begin()
            self._check_finite()
            self.phase = STEPPING

    def terminate(self) -> None:
        """End stepping; values can still be read."""
        with self._refusing():
            self._only(STEPPING, "fmi2Terminate")
            self.phase = TERMINATED

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Step the model; the instance's clock follows the caller's."""
        with self._refusing():
            self._check_step(current_time, step_size)
            self.failed = True
            self.simulation.step(current_time, step_size)
            self._check_finite()
            self.failed = False
            self.time = current_time + step_size
            return True
        return False

    def get_real(self, vrs: list[int]) -> list[float]:
        """Return real values by reference; NaN for what is no real variable."""
        return [self._get(vr, boolean=False) for vr in vrs]

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Return Boolean values by reference; False for what is none."""
        return [self._get(vr, boolean=True) == 1.0 for vr in vrs]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set real inputs, tunable parameters and, before stepping, states."""
        for vr, value in zip(vrs, values, strict=True):
            self._set(vr, value, boolean=False)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Set Boolean parameters and inputs."""
        for vr, value in zip(vrs, values, strict=True):
            self._set(vr, float(value), boolean=True)

    def get_integer(self, vrs: list[int]) -> list[int]:
        """Refuse: no model has integers."""
        self._refuse("there are no integer variables")
        return [0 for _ in vrs]

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Refuse: no model has integers."""
        self._refuse("there are no integer variables")

    def get_string(self, vrs: list[int]) -> list[str]:
        """Refuse: no model has strings."""
        self._refuse("there are no string variables")
        return ["" for _ in vrs]

    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """Refuse: no model has strings."""
        self._refuse("there are no string variables")

    @contextmanager
    def _refusing(self) -> Iterator[None]:
        """Turn whatever is raised into a refusal."""
        try:
            yield
        except Exception as error:
            self._refuse(str(error) or type(error).__name__)

    def _refuse(self, message: str) -> None:
        text = f"{self.instance_name} ({self.model.name}): {message}"
        self.log(text, Fmi2Status.error, "logStatusError")

    def _begun(self) -> bool:
        return self.phase in (STEPPING, TERMINATED)

    def _only(self, phase: str, call: str) -> None:
        if self.phase != phase:
            raise ValueError(f"{call} is not allowed {self.phase}")

    def _owner(self, reference: int, boolean: bool) -> Variable:
        variable = self.owners.get(reference)
        if variable is None:
            raise ValueError(f"there is no variable with reference {reference}")
        if variable.boolean != boolean:
            kind = "Boolean" if variable.boolean else "Real"
            raise TypeError(f"{variable.name} is {kind}")
        return variable

    def _get(self, reference: int, boolean: bool) -> float:
        with self._refusing():
            self._owner(reference, boolean)
            if not self._begun():
                self.simulation.refresh()
            return float(self.simulation.values[reference])
        return float("nan")

    def _set(self, reference: int, value: float, boolean: bool) -> None:
        with self._refusing():
            variable = self._owner(reference, boolean)
            var, block = variable.var, variable.block
            settable = block in ("parameter", "input", "state") and not var.constant
            early = block == "state" or var.fixed
            if not settable or (early and self._begun()):
                until = " once stepping has begun" if settable else ""
                raise ValueError(f"{variable.name} cannot be set{until}")
            if not np.isfinite(value):
                raise ValueError(f"{variable.name} cannot be {value}")
            self.simulation.put(reference, value, block)

    def _check_step(self, t: float, h: float) -> None:
        if self.failed:
            raise ValueError("no step after one that failed: reset the instance")
        self._only(STEPPING, "fmi2DoStep")
        if not (h > 0 and np.isfinite(h)):
            raise ValueError(f"a step of {h} s is no step")
        rounding = 1e-9 * h + 8 * np.finfo(float).eps * abs(self.time)
        if not abs(t - self.time) <= rounding:
            raise ValueError(f"it stands at {self.time} s and cannot step from {t} s")
        if t + h > self.stop_time + rounding:
            raise ValueError(f"a step to {t + h} s goes past {self.stop_time} s")
        for reference in self.simulation.delays.values():
            if self.simulation.values[reference] < 0:
                raise ValueError(f"{self.owners[reference].name} is a negative delay")

    def _check_finite(self) -> None:
        if name := self.simulation.not_finite():
            raise FloatingPointError(f"{name} is not finite")

    def _get_fmu_state(self) -> dict[str, Any]:
        return self.simulation.snapshot() | {
            "of": type(self).__module__,
            "phase": self.phase,
            "time": self.time,
            "failed": self.failed,
        }

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        if state.get("of") != type(self).__module__:
            self._refuse(f"this is a state of {state.get('of', 'something else')}")
            return
        self.simulation.restore(state)
        self.phase, self.time = state["phase"], state["time"]
        self.failed = state["failed"]

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        try:
            read: Any = json.loads(state)
        except ValueError:
            return {}
        return read if isinstance(read, dict) else {}
