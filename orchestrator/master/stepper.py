"""One FMU in a test's hands: set inputs, step, look at outputs.

The FMU is initialised at t = 0 when it is opened; time is kept exactly.  It runs
in this process, or in one of its own where it brings an interpreter.
"""

from collections.abc import Mapping
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from orchestrator.errors import ScenarioError
from orchestrator.fmu.description import FmuDescription, read_fmu
from orchestrator.fmu.ports import Port, ports
from orchestrator.fmu.start_values import start_values
from orchestrator.fmu.structure import sized
from orchestrator.fmu.typed import held
from orchestrator.master.simulate import open_instance
from orchestrator.quantities.quantity import parse_period
from orchestrator.system import Component, Value


class Stepper:
    """``fmu["u"] = 1.0; fmu.step("1/1000"); fmu["y"]``; a context manager.

    Variables of several numbers are tuples, in the FMU's order.  ``values`` are
    written before initialisation: parameters, start values, inputs.

    Raises:
        FmuError: the file is no FMU that runs here.
        WiringError: a value names no variable, or does not fit it.
        SimulationError: the FMU refuses a call; the message says what it logged.
    """

    def __init__(
        self, path: str | Path, values: Mapping[str, Value] | None = None
    ) -> None:
        described = read_fmu(path)
        self.time = Fraction(0)
        component = self._component = Component(
            described.path.stem,
            described.path,
            described.period or Fraction(1),
            start=dict(values or {}),
        )
        self.description: FmuDescription = sized(described, component)
        written = start_values(component, self.description)
        with ExitStack() as stack:
            self._instance = open_instance(
                component.name, self.description, stack, component.isolation
            )
            self._instance.instantiate()
            self._instance.set_up(0.0, None, None)
            self._instance.write(
                [variable for variable, _ in written],
                [number for _, numbers in written for number in numbers],
            )
            self._instance.enter_initialization()
            self._instance.bind(np.zeros(0), (), 0, (), 0)
            self._instance.exit_initialization()
            self._stack = stack.pop_all()

    def __setitem__(self, name: str, value: Value) -> None:
        variable = self.description[name]
        given = value if isinstance(value, tuple) else (value,)
        if len(given) != variable.size:
            raise ScenarioError(
                f"{self.description.path}: {name} takes {variable.size} values, "
                f"not {len(given)}"
            )
        major, found = self.description.fmi_major, self._ports(name)
        pairs = zip(found, given, strict=True)
        values = [held(name, port, one, major) for port, one in pairs]
        self._instance.write([variable], values)

    def _ports(self, name: str) -> list[Port]:
        return ports(self._component, self.description, name)

    def __getitem__(self, name: str) -> Any:
        found = self._instance.read([self.description[name]])
        return found[0] if len(found) == 1 else tuple(found)

    def step(self, period: Fraction | float | str | None = None) -> None:
        """Step by a period (s, exact as in a scenario; default: the FMU's own)."""
        h = self.description.period if period is None else parse_period(period)
        if h is None:
            raise ScenarioError(
                f"{self.description.path}: says no period of its own; step('1/1000')"
            )
        self._instance.step(float(self.time), float(h))
        self.time += h

    def close(self) -> None:
        """Terminate and free the FMU, and delete what was unpacked."""
        self._stack.close()

    def __enter__(self) -> "Stepper":
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        self.close()
