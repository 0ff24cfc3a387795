"""One instance under test: the order of its calls, and what they leave behind.

Every call that is not accepted raises ``FMICallException``; after an Error the
instance is only reset or freed, after Fatal nothing at all is called.  An FMU may
end the run by itself: steps after that are not taken, and a run has the rows until
then.  FMUs without co-simulation are stepped by forward Euler, which is enough to
see whether two runs agree.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from fmpy.fmi1 import FMICallException
from numpy.typing import NDArray

from orchestrator.checks.interface import load
from orchestrator.checks.item import CannotRun
from orchestrator.fmu.description import FmuVariable

if TYPE_CHECKING:
    from orchestrator.checks.laboratory import Laboratory

Row: TypeAlias = NDArray[np.float64]

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
FAR = 1e5  # steps to the stop time of an FMU that wants one


class Instance:
    """One instance; ``ended`` tells that the FMU has ended the run."""

    def __init__(
        self,
        lab: "Laboratory",
        name: str,
        *,
        token: str | None = None,
        folder: Path | None = None,
        prefix: str = "",
        logging: bool = True,
    ) -> None:
        self.lab = lab
        self.messages: list[tuple[int, str, str]] = []
        self.time = 0.0
        self.worst = OK  # status since the last reset
        self.freed = self.initialised = self.ended = False
        lab.doing("loading the library")
        place = folder or lab.folder
        self.face = load(lab.kind, lab.description, place, name, token, prefix)
        self.face.number_of_states = len(lab.model.derivatives)
        self.fmu = self.face.fmu
        self.fmu._call = self._watched(self.fmu._call)
        self._logging = logging
        self._instantiate()

    def _instantiate(self) -> None:
        self.lab.doing(f"instantiating {self.fmu.instanceName!r}")
        self.face.instantiate(self._message, self._logging)

    def _watched(self, call: Callable[..., Any]) -> Callable[..., Any]:
        def watched(function: str, *arguments: Any) -> Any:
            try:
                return call(function, *arguments)
            except FMICallException as error:
                self.worst = max(self.worst, int(error.status))
                self.lab.blamed = self.lab.told
                raise
            finally:
                self.lab.beat()

        return watched

    @property
    def exists(self) -> bool:
        return bool(self.fmu.component)

    def _message(self, status: int, category: bytes | None, text: bytes | None) -> None:
        words = [(b or b"").decode("utf-8", "replace") for b in (category, text)]
        self.messages.append((status, words[0], words[1]))

    def begin(self, start: float = 0.0, *experiment: float | None) -> "Instance":
        """Go through initialisation; stop time and tolerance as for ``enter``."""
        self.enter(start, *experiment)
        self.leave()
        return self

    def enter(self, start: float = 0.0, *experiment: float | None) -> None:
        """Enter initialisation with a stop time and a tolerance, each or None.

        Without both of them an FMU that refuses gets a stop time, as a new instance.
        """
        self.lab.doing("entering initialisation")
        if not self.exists:
            said = "; ".join(text for *_, text in self.messages[-3:])
            raise CannotRun(f"no instance could be made: {said or 'it says no more'}")
        self.time = start
        stop, tol = experiment or (self.lab.stop, None)
        try:
            self.face.enter(start, stop, tol)
        except FMICallException:
            if experiment or stop is not None or self.worst >= FATAL:
                raise
            self._enter_with_stop(start)

    def _enter_with_stop(self, start: float) -> None:
        stop = start + FAR * self.lab.h
        major = self.lab.description.fmi_major
        free = getattr(self.fmu, f"fmi{major}FreeInstance")
        free(self.fmu.component)  # fmpy's own freeing unloads the library as well
        self._instantiate()
        self.worst = OK
        self.face.enter(start, stop, None)
        self.lab.stop = stop
        self.lab.notes["stop"] = f"it wants a stop time; it got {stop:g} s"

    def leave(self) -> None:
        self.lab.doing("leaving initialisation")
        self.ended = self.face.leave()
        self.initialised = True

    def configure(self, variables: Iterable[FmuVariable]) -> None:
        """Set structural parameters to their start values, where it is allowed."""
        self.lab.doing("setting structural parameters in configuration mode")
        self.fmu.enterConfigurationMode()
        for variable in variables:
            self.set(variable, start_of(variable))
        self.fmu.exitConfigurationMode()

    def step(self, t: float, h: float) -> None:
        """Step, unless the FMU has ended the run."""
        if self.ended:
            return
        self.ended = self.face.step(t, h)
        if self.ended:
            self.lab.notes["end"] = f"it ends the run itself at t = {t:.9g} s"
        else:
            self.time = t + h

    def run(self, count: int, *, excited: bool = True, h: float | None = None) -> Row:
        """Step ``count`` times; return a row of all values after each."""
        size, first = h or self.lab.h, self.time
        self.lab.doing(f"stepping {count} times by {size:g} s")
        rows = []
        for k in range(count):
            if excited and not self.ended:
                self.excite(k)
            self.step(first + k * size, size)
            if self.ended:
                break
            rows.append(self.row())
        return np.array(rows).reshape(len(rows), sum(v.size for v in self.lab.watched))

    def excite(self, k: int) -> None:
        """Move every real input about its start value, within its bounds."""
        for i, variable in enumerate(self.lab.excited):
            self.set(variable, excitation(variable, np.sin(0.3 * k + i)))

    def row(self) -> Row:
        """Return all numbers that may change, in the order of ``watched``."""
        found: dict[str, list[float]] = {}
        groups: dict[str, list[FmuVariable]] = defaultdict(list)
        for variable in self.lab.watched:
            groups[variable.fmi_type].append(variable)
        for variables in groups.values():
            values = iter(self._read(variables))
            for variable in variables:
                numbers = [float(next(values)) for _ in range(variable.size)]
                found[variable.name] = numbers
        return np.array([x for v in self.lab.watched for x in found[v.name]])

    def _read(self, variables: list[FmuVariable]) -> list[Any]:
        try:
            return self.face.get_many(variables)
        except FMICallException:
            for variable in variables:  # so that what is refused has a name
                self.lab.doing(f"reading {variable.name}")
                self.get(variable)
            raise

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

    def reset(self) -> None:
        self.fmu.reset()
        self.worst, self.ended, self.initialised = OK, False, False

    def restore(self, state: Any, time: float) -> None:
        """Go back to a saved state, which was running at a time (s)."""
        self.fmu.setFMUState(state)
        self.time, self.worst, self.ended, self.initialised = time, OK, False, True

    def free(self) -> None:
        if self.exists and not self.freed and self.worst < FATAL:
            self.lab.doing("freeing the instance")
            if self.initialised and self.worst < ERROR:
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
