"""An FMU instance in this process, FMI 2.0 or 3.0, called through ctypes."""

import ctypes
from collections.abc import Callable, Sequence
from contextlib import chdir, suppress
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.trust import is_trusted
from orchestrator.errors import FeedDriveError, FmuError, SimulationError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.structure import is_structural
from orchestrator.fmu.typed import Held
from orchestrator.instances.doing import mark, rest
from orchestrator.instances.ending import WHOLE, Ended, discarded
from orchestrator.instances.group import (
    DISCARD,
    ERROR,
    FATAL,
    Group,
    good,
    groups,
    strict,
    told,
)
from orchestrator.instances.logs import (
    SPEAKERS,
    LogMessage,
    callbacks,
    log_errors_only,
)
from orchestrator.instances.texts import Texts
from orchestrator.native import library as c

_LOADING = Lock()  # the working folder is that of all threads


class LocalInstance:
    """An FMU loaded into this process with ctypes, through fmpy.

    ``folder`` is the unpacked archive.  ``log`` receives every message.
    """

    def __init__(
        self,
        name: str,
        description: FmuDescription,
        folder: Path,
        log: Callable[[str, LogMessage], None],
    ) -> None:
        self.name = name
        self.description = description
        self.clock = ctypes.c_double(0.0)
        self._log = log
        self._messages: list[LogMessage] = []
        self._fmi2 = description.fmi_major == 2
        self.slave: Any = None
        self._initialized = False
        self._worst = 0
        self._quiet = False
        self.outcome = c.Outcome()
        _require_binary(description, folder)
        mark(name, "load")
        try:
            with _LOADING, chdir(Path.cwd()):  # fmpy goes to the folder of the FMU
                self._fmu = strict(self._load(folder))
            self.library: Any = self._fmu.dll
            rest()
        except FeedDriveError:
            raise
        except Exception as error:  # fmpy raises bare Exception when loading fails
            raise FmuError(
                f"{description.path} ({name}): its library cannot be loaded: {error}; "
                f"check with `ldd` which system library it lacks"
            ) from None

    @property
    def step_major(self) -> int:
        return self.description.fmi_major

    @property
    def time(self) -> float:
        """The start of the latest step (s); the kernel writes it too."""
        return self.clock.value

    def _load(self, folder: Path) -> Any:
        from fmpy.fmi2 import FMU2Slave
        from fmpy.fmi3 import FMU3Slave

        kind = FMU2Slave if self._fmi2 else FMU3Slave
        return kind(
            guid=self.description.token,
            modelIdentifier=self.description.model_identifier,
            unzipDirectory=str(folder),
            instanceName=self.name,
        )

    def instantiate(self) -> None:
        if self.slave is not None and self._worst != FATAL:  # anew
            free = "fmi2FreeInstance" if self._fmi2 else "fmi3FreeInstance"
            getattr(self._fmu, free)(self._fmu.component)
            self.slave, self._worst, self._messages = None, 0, []
        with self._named("instantiate"):
            self._create()
        self.slave = ctypes.c_void_p(self._fmu.component)

    def _create(self) -> None:
        if self._fmi2:
            SPEAKERS[self.name] = self
            self._fmu.instantiate(callbacks=callbacks(), loggingOn=True)
        else:
            self._fmu.instantiate(logMessage=self._fmi3_message, loggingOn=True)

    def _fmi3_message(self, _env: Any, status: int, category: Any, text: Any) -> None:
        self.record(status, category, text)

    def record(self, status: int, category: bytes | None, text: bytes | None) -> None:
        """Keep what the FMU logs, and pass it on."""
        if self._quiet and status == 0:
            return  # from an FMU that logs all the same
        label = told(status)
        name, said = ((b or b"").decode("utf-8", "replace") for b in (category, text))
        message = LogMessage(label, name, said, self.time)
        self._messages = [*self._messages[-9:], message]
        self._log(self.name, message)

    def _named(self, function: str) -> "_Named":
        return _Named(self, function)

    def fail(self, function: str, reason: str) -> SimulationError:
        """Return the error for a failed call, with what the FMU logged."""
        said = "; ".join(str(m) for m in self._messages[-3:])
        more = "; run with -v to switch its logging on" if self._quiet else ""
        told = f"logged: {said}" if said else f"logged nothing{more}."
        return SimulationError(
            f"{self.name} ({self.description.path.name}): {function} at "
            f"t = {self.time:.9g} s {reason}. The FMU {told}"
        )

    def write(self, variables: Sequence[FmuVariable], values: list[Held]) -> None:
        """Set variables; the structural parameters first, in configuration mode."""
        given = iter(values)
        parts = [(v, [next(given) for _ in range(v.size)]) for v in variables]
        structural = [part for part in parts if is_structural(part[0])]
        if structural:
            with self._named("configure"):
                self._fmu.enterConfigurationMode()
            self._set(structural)
            with self._named("leave configuration mode"):
                self._fmu.exitConfigurationMode()
        self._set([part for part in parts if not is_structural(part[0])])

    def _set(self, parts: Sequence[tuple[FmuVariable, list[Any]]]) -> None:
        for variable, values in parts:
            with self._named(f"set {variable.name}"):
                (Texts if variable.is_text else Group)(self, [variable]).set(values)

    def read(self, variables: Sequence[FmuVariable]) -> list[Held]:
        found: list[Held] = []
        for variable in variables:
            with self._named(f"get {variable.name}"):
                found += (Texts if variable.is_text else Group)(self, [variable]).get()
        return found

    def set_up(self, start: float, stop: float | None, tolerance: float | None) -> None:
        """Hand over the experiment; FMI 3.0 takes it with its initialisation."""
        self.clock.value = start
        if self._fmi2:
            with self._named("set up experiment"):
                self._fmu.setupExperiment(tolerance, startTime=start, stopTime=stop)
        else:
            self._experiment = {
                "tolerance": tolerance,
                "startTime": start,
                "stopTime": stop,
            }

    def enter_initialization(self) -> None:
        with self._named("enter initialization"):
            if self._fmi2:
                self._fmu.enterInitializationMode()
            else:
                self._fmu.enterInitializationMode(**self._experiment)

    def exit_initialization(self) -> None:
        with self._named("exit initialization"):
            self._fmu.exitInitializationMode()
        self._initialized = True

    def quiet(self) -> None:
        """Let the FMU log errors alone; ours log nothing else anyway."""
        if self.description.says_it_is_ours:
            return
        self._quiet = True
        categories = self.description.log_categories
        with self._named("set debug logging"):
            log_errors_only(
                self.library, self.slave, self.description.fmi_major, categories
            )

    def bind(
        self,
        vector: NDArray[np.float64],
        inputs: Sequence[FmuVariable],
        first_input: int,
        outputs: Sequence[FmuVariable],
        first_output: int,
    ) -> None:
        self.inputs = groups(self, inputs, vector, first_input)
        self.outputs = groups(self, outputs, vector, first_output)
        self._bind_step()

    def _bind_step(self) -> None:
        name = "fmi2DoStep" if self._fmi2 else "fmi3DoStep"
        self.do_step = self.library[name]
        self.do_step.restype = ctypes.c_int
        if self._fmi2:
            self.tail: tuple[Any, ...] = (1,)
            self.do_step.argtypes = [
                ctypes.c_void_p,
                ctypes.c_double,
                ctypes.c_double,
                ctypes.c_int,
            ]
        else:
            flags = [ctypes.c_bool(), ctypes.c_bool(), ctypes.c_bool()]
            self._reached = ctypes.c_double()
            self._event, self._ended, self._early = flags
            pointers = [ctypes.pointer(flag) for flag in flags]
            self.tail = (True, *pointers, ctypes.pointer(self._reached))
            self.do_step.argtypes = [
                ctypes.c_void_p,
                ctypes.c_double,
                ctypes.c_double,
                ctypes.c_bool,
                *[ctypes.POINTER(ctypes.c_bool)] * 3,
                ctypes.POINTER(ctypes.c_double),
            ]

    def push(self) -> None:
        mark(self.name, "set")
        for group in self.inputs:
            group.push()

    def pull(self) -> None:
        mark(self.name, "get")
        for group in self.outputs:
            group.pull()

    def step(self, t: float, h: float) -> None:
        mark(self.name, "doStep")
        self.clock.value = t
        if not self._fmi2:
            self._reached.value = t + h
        status = self.do_step(self.slave, t, h, *self.tail)
        if not self._fmi2:
            self.outcome.reached = self._reached.value
            self.outcome.ended = self._ended.value
            self.outcome.early = self._early.value
        whole = self.outcome.reached >= t + h * (1 - WHOLE)
        if good(status) and self.outcome.ended and whole:
            self.outcome.last = 1
        elif not good(status) or self.outcome.ended or self.outcome.early:
            raise self.failed_step(h, status)

    def failed_step(self, h: float, status: int) -> SimulationError:
        """Return the error for a step that failed or by which the FMU ended the run."""
        self.refused(status)
        if ended := self._ended_by(h, status):
            return ended
        return self.fail(f"doStep of {h:.9g} s", f"returned {told(status)}")

    def _ended_by(self, h: float, status: int) -> Ended | None:
        """Return how the FMU ended the run by a step with this status, if it did."""
        if good(status):
            return self.ended()
        if status != DISCARD:
            return None
        found = discarded(self, self.time, h)
        return found and Ended(self.name, *found)

    def ended(self) -> Ended:
        """Return how the FMU ended the run by its latest step."""
        early = self.outcome.early and not self.outcome.ended
        reason = "it returned early" if early else "it asked to end the simulation"
        return Ended(self.name, self.outcome.reached, reason)

    def refused(self, status: int) -> None:
        """Remember the worst status of a call; it decides what ``close`` may call."""
        known = 0 <= status <= FATAL
        self._worst = max(self._worst, status if known else ERROR)

    def close(self) -> None:
        """Terminate and free the instance, whatever state it is in."""
        mark(self.name, "terminate and free")
        if self.slave is None:
            return
        with suppress(Exception):
            if self._initialized and self._worst <= DISCARD:
                self._fmu.terminate()
        if not is_trusted(
            self.description.path
        ):  # a thread it left may still run its code
            self._fmu.freeLibrary = lambda: None
        with suppress(Exception):
            if self._worst != FATAL:  # then no call is allowed any more
                self._fmu.freeInstance()
        self.slave = None
        rest()


class _Named:
    """Turn what fmpy raises in a block into our error naming the call."""

    def __init__(self, instance: LocalInstance, function: str) -> None:
        self.instance, self.function = instance, function

    def __enter__(self) -> None:
        mark(self.instance.name, self.function)

    def __exit__(self, kind: Any, error: BaseException | None, _trace: Any) -> None:
        rest()
        if error is None or isinstance(error, FeedDriveError):
            return
        self.instance.refused(getattr(error, "status", 0))
        if isinstance(error, Exception):
            raise self.instance.fail(self.function, f"failed ({error})") from None


def _require_binary(description: FmuDescription, folder: Path) -> None:
    import fmpy

    host = fmpy.platform if description.fmi_major == 2 else fmpy.platform_tuple
    suffix = fmpy.sharedLibraryExtension
    binary = folder / "binaries" / host / f"{description.model_identifier}{suffix}"
    if not binary.is_file():
        there = ", ".join(description.platforms) or "none at all"
        raise FmuError(
            f"{description.path}: has no binary for this machine "
            f"(binaries/{host}/{binary.name}); it has: {there}. Ask its supplier for "
            f"this platform, or build it from its sources"
        )
