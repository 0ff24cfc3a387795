"""An FMU for model exchange, integrated here so that it steps like any other.

``step`` integrates from t to t + h with CVODE (BDF, relative tolerance
``TOLERANCE``, absolute that times the nominals), handling state, time and step
events where they occur.  An event indicator z changes its domain between z > 0 and
z <= 0 (FMI); to CVODE, which looks for changes of sign, a zero is shown as negative.
Between steps the FMU is in event mode: what the master
sets there is an event of its inputs, what it gets are values after the events at
t + h.  The integrator starts afresh where inputs or states jumped, and never
looks beyond the next time event or t + h, as inputs may jump there.

Source: FMI 2.0.4, 3.2; FMI 3.0.1, 3; Hindmarsh et al., ACM TOMS 31 (2005) 363.
"""

import ctypes
from collections.abc import Callable, Sequence
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.sundials import CVodeSolver
from fmpy.sundials.cvode import CVode
from fmpy.sundials.libraries import sundials_cvode
from fmpy.sundials.nvector_serial import NV_DATA_S
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.typed import Held
from orchestrator.instances.ending import WHOLE, Ended
from orchestrator.instances.instance import LocalInstance
from orchestrator.instances.logs import LogMessage

TOLERANCE = 1e-10
ITERATIONS = 1000  # of one event
CLOSE = 1e-13  # relative; two times that are the same to an integrator
BELOW_ZERO = -np.finfo(float).tiny
_ONE_STEP, _ROOT = 2, 2  # CV_ONE_STEP, CV_ROOT_RETURN
_FAILED = 3  # fmi2Error

DoStep = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int
)
_set_stop = sundials_cvode.CVodeSetStopTime
_set_stop.argtypes = [ctypes.c_void_p, ctypes.c_double]
_set_stop.restype = ctypes.c_int


class ModelExchangeInstance(LocalInstance):
    """As ``LocalInstance``, for FMUs that leave integrating to their importer."""

    def __init__(
        self,
        name: str,
        description: FmuDescription,
        folder: Path,
        log: Callable[[str, LogMessage], None],
    ) -> None:
        from fmpy import read_model_description

        super().__init__(name, description, folder, log)
        self._md = read_model_description(str(folder), validate=False)
        self._solver: _Solver | None = None
        self._at, self._next_event = 0.0, inf
        self._jumped = True
        self._failure: BaseException | None = None

    @property
    def step_major(self) -> int:
        return 2  # do_step is called like fmi2DoStep

    def _load(self, folder: Path) -> Any:
        from fmpy.fmi2 import FMU2Model
        from fmpy.fmi3 import FMU3Model

        kind = FMU2Model if self.description.fmi_major == 2 else FMU3Model
        return kind(
            guid=self.description.token,
            modelIdentifier=self.description.model_identifier,
            unzipDirectory=str(folder),
            instanceName=self.name,
        )

    def write(self, variables: Sequence[FmuVariable], values: list[Held]) -> None:
        super().write(variables, values)
        self._jumped = True

    def exit_initialization(self) -> None:
        super().exit_initialization()
        self._at = self.time
        with self._named("the events at the start"):
            self._settle()

    def bind(
        self,
        vector: NDArray[np.float64],
        inputs: Sequence[FmuVariable],
        first_input: int,
        outputs: Sequence[FmuVariable],
        first_output: int,
    ) -> None:
        super().bind(vector, inputs, first_input, outputs, first_output)
        self._given = vector[first_input : first_input + sum(v.size for v in inputs)]
        self._last = b""

    def _bind_step(self) -> None:
        self.do_step = DoStep(self._called)

    def _called(self, _slave: Any, t: float, h: float, _unused: int) -> int:
        """Step for the kernel, which takes a status and asks for the error later."""
        try:
            self.step(t, h)
        except BaseException as error:  # also Ctrl-C must not end inside of C
            self._failure = error
            return _FAILED
        return 0

    def failed_step(self, h: float, status: int) -> SimulationError:
        """Return the error of the latest step."""
        if isinstance(self._failure, SimulationError):
            return self._failure
        assert self._failure is not None
        raise self._failure

    def step(self, t: float, h: float) -> None:
        self.clock.value = t
        with self._named(f"a step of {h:.9g} s"):
            self._begin()
            try:
                self._integrate(t + h)
            except Ended as end:
                if end.at < t + h * (1 - WHOLE):
                    raise
                self._end, self.outcome.last = end, 1

    def ended(self) -> Ended:
        return self._end

    def _begin(self) -> None:
        """Let inputs set since the latest step take effect."""
        given = self._given.tobytes()
        self._jumped |= given != self._last
        self._last = given
        self._settle()
        self._fmu.enterContinuousTimeMode()
        if self._solver is None:
            self._solver = _Solver(self._fmu, self._md, self._at)
        elif self._jumped:
            self._solver.reset(self._at)
        self._jumped = False

    def _integrate(self, end: float) -> None:
        """Go from where the FMU is to ``end``, into event mode there."""
        assert self._solver is not None
        while True:
            target = min(end, self._next_event)
            if end < self._next_event <= end + CLOSE * abs(end):
                target = self._next_event  # t + h but for how it was rounded
            reached, event = self._solver.go(self._at, target)
            self._at = self.clock.value = reached
            if self._md.modelExchange.needsCompletedIntegratorStep:
                stepped, over = self._fmu.completedIntegratorStep()
                event |= stepped
                if over:
                    raise self._over()
            event |= reached >= self._next_event
            over = reached >= end
            if event or over:
                self._fmu.enterEventMode()
            if event:
                self._settle()
                self._jumped = True
            if over:
                return
            if event:
                self._fmu.enterContinuousTimeMode()
                self._solver.reset(reached)
                self._jumped = False

    def _over(self) -> Ended:
        reason = "an event asked to end the simulation"
        return Ended(self.name, self._at, reason)

    def _settle(self) -> None:
        """Iterate the event in which the FMU is until nothing changes any more."""
        fmi2 = self.description.fmi_major == 2
        update = self._fmu.newDiscreteStates if fmi2 else self._fmu.updateDiscreteStates
        for _ in range(ITERATIONS):
            again, over, nominals, values, timed, when = update()
            if over:
                raise self._over()
            self._jumped |= bool(nominals or values)
            self._next_event = when if timed else inf
            if not again and self._next_event > self._at:
                return
        raise self.fail("an event", f"did not settle in {ITERATIONS} iterations")


class _Solver(CVodeSolver):  # type: ignore[misc]  # fmpy is not typed
    """CVODE on the FMU's states, one internal step at a time."""

    def __init__(self, fmu: Any, md: Any, start: float) -> None:
        fmi2 = md.fmiVersion.startswith("2")
        self._error: BaseException | None = None
        self.cvode_mem = None  # fmpy frees it, also after a constructor that failed
        super().__init__(
            nx=md.numberOfContinuousStates
            if fmi2
            else fmu.getNumberOfContinuousStates(),
            nz=md.numberOfEventIndicators if fmi2 else fmu.getNumberOfEventIndicators(),
            get_x=fmu.getContinuousStates,
            set_x=fmu.setContinuousStates,
            get_dx=fmu.getDerivatives if fmi2 else fmu.getContinuousStateDerivatives,
            get_z=fmu.getEventIndicators,
            get_nominals=fmu.getNominalsOfContinuousStates,
            set_time=fmu.setTime,
            input=None,
            startTime=start,
            relativeTolerance=TOLERANCE,
        )

    def go(self, start: float, target: float) -> tuple[float, bool]:
        """Make one internal step towards target; return its end and whether an
        event indicator changed its sign there.
        """
        if target - start <= CLOSE * max(abs(start), abs(target)):
            self.set_time(target)
            return target, False
        reached = ctypes.c_double()
        _set_stop(self.cvode_mem, target)
        arguments = target, self.x, ctypes.byref(reached), _ONE_STEP
        flag = CVode(self.cvode_mem, *arguments)
        if flag < 0:
            if self._error is not None:
                raise self._error
            raise RuntimeError(f"CVODE gave up at {reached.value:.9g} s: {self._why()}")
        self.set_time(reached.value)
        if not self.discrete:
            self.set_x(self.px, self.nx)
        return reached.value, flag == _ROOT

    def _why(self) -> str:
        return str(self.error_info[-1]) if self.error_info else "no reason given"

    def f(self, t: float, y: Any, ydot: Any, user_data: Any) -> int:
        return self._guarded(self._f, t, y, ydot)

    def g(self, t: float, y: Any, gout: Any, user_data: Any) -> int:
        return self._guarded(self._g, t, y, gout)

    def _f(self, t: float, y: Any, ydot: Any) -> None:
        self.set_time(t)
        if self.discrete:
            np.ctypeslib.as_array(NV_DATA_S(ydot), (1,))[:] = 0.0
            return
        self.set_x(NV_DATA_S(y), self.nx)
        self.get_dx(NV_DATA_S(ydot), self.nx)

    def _g(self, t: float, y: Any, gout: Any) -> None:
        self.set_time(t)
        if not self.discrete:
            self.set_x(NV_DATA_S(y), self.nx)
        self.get_z(gout, self.nz)
        z = np.ctypeslib.as_array(gout, (self.nz,))
        z[z == 0] = BELOW_ZERO

    def _guarded(self, function: Callable[..., None], *arguments: Any) -> int:
        """Return what CVODE wants: 0, or -1 after an exception, which is kept."""
        try:
            function(*arguments)
        except BaseException as error:
            self._error = error
            return -1
        return 0
