"""Where dynamic items try an FMU out: instances on fmpy, any FMI and interface.

A ``Laboratory`` belongs to one item in one process.  It tells its parent what
is being tried, so that a crash can be placed.  FMUs without co-simulation are
stepped by forward Euler, which is enough to see whether two runs agree.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray

from orchestrator.checks.interface import Kind, load
from orchestrator.checks.item import CannotRun, NotApplicable
from orchestrator.fmu.description import FmuDescription, FmuVariable

Row: TypeAlias = NDArray[np.float64]

STEPS = 50
STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
OK, WARNING, DISCARD, ERROR, FATAL = range(5)
NO_INSTANCE = -1


@dataclass
class Laboratory:
    """The FMU under test.

    ``model`` is fmpy's description, ``printed`` returns what the FMU wrote to stdout
    and stderr, ``kept`` is what a later stage in another process gets.  ``h`` (s) is
    the step that the FMU suggests.
    """

    description: FmuDescription
    model: Any
    folder: Path
    tell: Callable[[str], None]
    printed: Callable[[], bytes]
    kept: dict[str, Any] = field(default_factory=dict)
    attempt: str = ""

    @property
    def kind(self) -> Kind:
        """The interface that is tried: co-simulation where there is one."""
        if self.description.co_simulation:
            return "co-simulation"
        if self.description.model_exchange:
            return "model exchange"
        raise NotApplicable("it has scheduled execution only, which nobody runs here")

    @property
    def interface(self) -> Any:
        """fmpy's element CoSimulation or ModelExchange: capabilities."""
        co_simulation = self.kind == "co-simulation"
        return self.model.coSimulation if co_simulation else self.model.modelExchange

    def needs(self, capability: str) -> None:
        """Raise ``NotApplicable`` if the FMU does not declare a capability."""
        if not getattr(self.interface, capability, None):
            raise NotApplicable(f"it declares no {capability}")

    def needs_co_simulation(self) -> None:
        if self.kind != "co-simulation":
            raise NotApplicable("it has no co-simulation")

    @property
    def h(self) -> float:
        fixed = getattr(self.interface, "fixedInternalStepSize", None)
        period = self.description.period
        chosen = period or self.description.default_step or fixed
        if chosen:
            return float(chosen)
        stop = getattr(self.model.defaultExperiment, "stopTime", None)
        return float(stop) / 1000 if stop and float(stop) > 0 else 1e-3

    def variables(self, **roles: str) -> list[FmuVariable]:
        """Return the variables with these attributes, such as causality."""
        return [
            v
            for v in self.description.variables.values()
            if all(getattr(v, key) == value for key, value in roles.items())
        ]

    def trying(self, text: str) -> None:
        """Say what is being tried, for whoever has to explain a crash."""
        self.attempt = text
        self.tell(text)

    def doing(self, text: str) -> None:
        """Say which call comes next in what is being tried."""
        self.tell(f"{self.attempt}: {text}" if self.attempt else text)

    @contextmanager
    def instance(self, name: str = "one", **options: Any) -> Iterator["Instance"]:
        """Give a fresh instance and free it afterwards."""
        instance = Instance(self, name, **options)
        try:
            yield instance
        finally:
            instance.free()

    @contextmanager
    def running(self, name: str = "one", **options: Any) -> Iterator["Instance"]:
        """Give an instance that has been initialised with its own start values."""
        with self.instance(name, **options) as instance:
            instance.begin()
            yield instance

    @cached_property
    def watched(self) -> list[FmuVariable]:
        """Every variable with numbers that may change while stepping."""
        return [
            v
            for v in self.description.variables.values()
            if v.causality in ("output", "local")
            and v.sort != "string"
            and v.fmi_type not in ("Binary", "Clock")
        ]

    def column(self, place: int) -> str:
        """Return the name of a place in a row."""
        return [v.name for v in self.watched for _ in range(v.size)][place]

    def trajectory(self, count: int = STEPS, **options: Any) -> Row:
        """Return the rows of a run with moving inputs, from start values."""
        with self.running(**options) as instance:
            return instance.run(count)


class Instance:
    """One instance; every call that is not accepted raises ``FMICallException``."""

    def __init__(
        self,
        lab: Laboratory,
        name: str,
        *,
        token: str | None = None,
        folder: Path | None = None,
        logging: bool = True,
    ) -> None:
        self.lab = lab
        self.messages: list[tuple[int, str, str]] = []
        self.time = 0.0
        lab.doing("loading the library")
        self.face = load(lab.kind, lab.description, folder or lab.folder, name, token)
        self.face.number_of_states = len(lab.model.derivatives)
        self.fmu = self.face.fmu
        self.freed = self.initialised = False
        lab.doing(f"instantiating {name!r}")
        self.face.instantiate(self._message, logging)

    @property
    def exists(self) -> bool:
        return bool(self.fmu.component)

    def _message(self, status: int, category: bytes | None, text: bytes | None) -> None:
        words = [(b or b"").decode("utf-8", "replace") for b in (category, text)]
        self.messages.append((status, words[0], words[1]))

    def begin(self, start: float = 0.0, **times: float | None) -> "Instance":
        """Go through initialisation; ``stop`` and ``tolerance`` as for ``enter``."""
        self.enter(start, **times)
        self.leave()
        return self

    def enter(
        self, start: float = 0.0, stop: float | None = None, tol: float | None = None
    ) -> None:
        self.lab.doing("entering initialisation")
        if not self.exists:
            said = "; ".join(text for *_, text in self.messages[-3:])
            raise CannotRun(f"no instance could be made: {said or 'it says no more'}")
        self.time = start
        self.face.enter(start, stop, tol)

    def leave(self) -> None:
        self.lab.doing("leaving initialisation")
        self.face.leave()
        self.initialised = True

    def step(self, t: float, h: float) -> None:
        self.face.step(t, h)
        self.time = t + h

    def run(self, count: int, *, excited: bool = True, h: float | None = None) -> Row:
        """Step ``count`` times; return a row of all values after each."""
        size, first = h or self.lab.h, self.time
        self.lab.doing(f"stepping {count} times by {size:g} s")
        rows = []
        for k in range(count):
            if excited:
                self.excite(k)
            self.step(first + k * size, size)
            rows.append(self.row())
        return np.array(rows)

    def excite(self, k: int) -> None:
        """Move every real input about its start value, within its bounds."""
        for i, variable in enumerate(self.lab.variables(causality="input")):
            if variable.sort == "real":
                self.set(variable, excitation(variable, np.sin(0.3 * k + i)))

    def row(self) -> Row:
        """Return all numbers that may change, in the order of the description."""
        values: list[float] = []
        for variable in self.lab.watched:
            values.extend(map(float, self.get(variable)))
        return np.array(values)

    def get(self, variable: FmuVariable) -> list[Any]:
        return self.face.get(variable)

    def set(self, variable: FmuVariable, values: Sequence[Any]) -> None:
        self.face.set(variable, values)

    def read_unknown(self) -> None:
        """Read a real variable that the FMU does not have."""
        known = (v.reference for v in self.lab.description.variables.values())
        fmi2 = self.lab.description.fmi_major == 2
        read = self.fmu.getReal if fmi2 else self.fmu.getFloat64
        read([max(known, default=0) + 100_000])

    def status(self, call: Callable[..., Any], *arguments: Any) -> int:
        """Return the status of a call instead of raising it."""
        try:
            call(*arguments)
        except FMICallException as error:
            return int(error.status)
        return OK

    def free(self) -> None:
        if self.exists and not self.freed:
            self.lab.doing("freeing the instance")
            if self.initialised:
                self.status(self.fmu.terminate)
            self.fmu.freeInstance()
        self.freed = True
        self.face.forget()


def start_of(variable: FmuVariable) -> list[Any]:
    """Return the start values of a variable as its description gives them."""
    text = variable.start
    if text is None:
        return []
    if variable.sort == "string":
        return [text]
    words = text.split()
    if variable.sort == "boolean":
        values: list[Any] = [word in ("true", "1") for word in words]
    elif variable.sort == "real":
        values = [float(word) for word in words]
    else:
        values = [int(word) for word in words]
    return values * variable.size if len(values) == 1 else values


def excitation(variable: FmuVariable, part: float) -> list[float]:
    """Return values near a real variable's start: ``part`` (-1 to 1) of a tenth."""
    values = []
    for start in start_of(variable) or [0.0] * variable.size:
        moved = start + 0.1 * part * max(1.0, abs(start))
        low = float(variable.min) if variable.min else -np.inf
        high = float(variable.max) if variable.max else np.inf
        values.append(float(np.clip(moved, low, high)))
    return values


def same(one: Row, other: Row, rtol: float = 0.0) -> bool:
    """Tell whether two tables are equal, or within ``rtol`` of their columns' size."""
    if rtol == 0.0 or one.shape != other.shape:
        return bool(np.array_equal(one, other, equal_nan=True))
    scale = np.maximum(np.max(np.abs(one), axis=0, initial=0), 1e-9)
    return bool(np.all(np.abs(one - other) <= rtol * scale))
