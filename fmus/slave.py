"""What a Python FMU runs: a model's own NumPy equations behind FMI 2.0.

Whatever is refused raises; pythonfmu logs the message and returns Fatal, for it
knows no other way.  This module and ``fmus.simulation`` are bundled into every
Python FMU and import nothing but NumPy, pythonfmu and the model contract.
"""

from typing import Any, ClassVar

import numpy as np
from pythonfmu import Fmi2Slave

from fmus.layout import Variable
from fmus.model import Model
from fmus.simulation import Simulation


class ModelSlave(Fmi2Slave):  # type: ignore[misc]
    """Base of every Python FMU; the generated subclass only names its model."""

    model: ClassVar[Model]

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.simulation = Simulation(self.model)
        self.stepping = False
        self.time = 0.0
        variables = self.simulation.layout.variables
        self.owners = {r: v for v in variables for _, r in v.elements()}

    def setup_experiment(
        self,
        start_time: float,
        stop_time: float | None = None,
        tolerance: float | None = None,
    ) -> None:
        """Take the start time (s); the other two mean nothing here."""
        self.time = self.simulation.start_time = start_time

    def exit_initialization_mode(self) -> None:
        """Publish the initial outputs; from now on only steps change them."""
        self.simulation.refresh()
        self.simulation.begin()
        self._refuse_what_is_not_finite()
        self.stepping = True

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Step the model; the instance's clock follows the caller's."""
        if not step_size > 0 or not np.isfinite(step_size):
            raise ValueError(f"{self._who}: a step of {step_size} s is no step")
        rounding = 1e-9 * step_size + 8 * np.finfo(float).eps * abs(self.time)
        if not abs(current_time - self.time) <= rounding:
            raise ValueError(
                f"{self._who} stands at {self.time} s, it cannot step from "
                f"{current_time} s"
            )
        self._refuse_negative_delay()
        self.simulation.step(current_time, step_size)
        self._refuse_what_is_not_finite()
        self.time = current_time + step_size
        return True

    def get_real(self, vrs: list[int]) -> list[float]:
        """Return real values by reference."""
        return [self._get(vr, boolean=False) for vr in vrs]

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Return Boolean values by reference."""
        return [bool(self._get(vr, boolean=True)) for vr in vrs]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set real inputs, tunable parameters and, before stepping, states."""
        for vr, value in zip(vrs, values, strict=True):
            self._set(vr, value, boolean=False)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Set Boolean parameters and inputs."""
        for vr, value in zip(vrs, values, strict=True):
            self._set(vr, float(value), boolean=True)

    @property
    def _who(self) -> str:
        return f"{self.instance_name} ({self.model.name})"

    def _owner(self, reference: int, boolean: bool) -> Variable:
        variable = self.owners.get(reference)
        if variable is None:
            raise ValueError(f"{self._who} has no variable with reference {reference}")
        if variable.boolean != boolean:
            kind = "Boolean" if variable.boolean else "Real"
            raise TypeError(f"{self._who}: {variable.name} is {kind}")
        return variable

    def _get(self, reference: int, boolean: bool) -> float:
        self._owner(reference, boolean)
        if not self.stepping:
            self.simulation.refresh()
        return float(self.simulation.values[reference])

    def _set(self, reference: int, value: float, boolean: bool) -> None:
        variable = self._owner(reference, boolean)
        var, block = variable.var, variable.block
        settable = block in ("parameter", "input", "state") and not var.constant
        early = block == "state" or var.fixed
        if not settable or (early and self.stepping):
            until = " once stepping has begun" if settable else ""
            raise ValueError(f"{self._who}: {variable.name} cannot be set{until}")
        if not np.isfinite(value):
            raise ValueError(f"{self._who}: {variable.name} cannot be {value}")
        self.simulation.values[reference] = value
        if block == "parameter":
            self.simulation.derived = None
        self.simulation.outputs_stale = True

    def _refuse_negative_delay(self) -> None:
        for reference in self.simulation.delays.values():
            if self.simulation.values[reference] < 0:
                name = self.owners[reference].name
                raise ValueError(f"{self._who}: the dead time {name} is negative")

    def _refuse_what_is_not_finite(self) -> None:
        if name := self.simulation.not_finite():
            raise FloatingPointError(f"{self._who}: {name} is no longer finite")

    def _get_fmu_state(self) -> dict[str, Any]:
        return self.simulation.snapshot() | {
            "of": type(self).__module__,
            "stepping": self.stepping,
            "time": self.time,
        }

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        if state["of"] != type(self).__module__:
            raise ValueError(f"{self._who}: this is a state of {state['of']}")
        self.simulation.restore(state)
        self.stepping, self.time = state["stepping"], state["time"]
