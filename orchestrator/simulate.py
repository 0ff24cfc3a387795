"""One run of a system: the order in which everything is opened and closed.

1. read and check all FMUs, wire, order, schedule: nothing has run yet;
2. unpack and load each FMU (those that need Python or another tool in a process
   of their own), initialise together;
3. execute the timetable, recording;
4. whatever happens: end the streams, terminate and free the instances, delete
   what was unpacked.  Rows recorded before a failure stay readable.
"""

import logging
from collections.abc import Callable
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from time import perf_counter

import numpy as np

from orchestrator.archive import unpacked
from orchestrator.executor import Executor
from orchestrator.fmu import FmuDescription, read_fmu
from orchestrator.initialise import initialise
from orchestrator.instance import Instance, LocalInstance, LogMessage
from orchestrator.recorder import Recorder
from orchestrator.result import Result, Timing
from orchestrator.system import System
from orchestrator.timetable import Timetable
from orchestrator.wiring import Wiring, wire

LOG = logging.getLogger("feeddrive")
BETWEEN = 0.25  # s of wall time between two calls of progress, and two flushes
CHECKED = 256  # instants between two looks at the clock

Progress = Callable[[Fraction], None]


def simulate(
    system: System, folder: Path, *, progress: Progress | None = None
) -> Result:
    """Run a system and return what it recorded, kept under ``folder/result``.

    ``progress`` is told the time reached (s), about four times a second.

    Raises:
        FmuError, WiringError, ScheduleError: refused before anything ran.
        SimulationError: the run failed; rows until then are readable.
    """
    timetable = plan(system)
    wiring = timetable.wiring
    for note in wiring.notes:
        LOG.info(note)
    vector = np.zeros(wiring.size)
    with ExitStack() as stack:
        instances = {
            name: _load(name, part.fmu, stack) for name, part in wiring.parts.items()
        }
        initialise(wiring, instances, vector)
        recorder = Recorder(folder / "result", wiring.tables, vector)
        complete = False
        try:
            executor = Executor(timetable, instances, vector, recorder.rows)
            timing = _execute(timetable, executor, recorder, progress)
            complete = True
        finally:
            recorder.close(complete=complete)
    return Result(folder, timing)


def plan(system: System) -> Timetable:
    """Check a system completely and return its timetable, without running it."""
    wiring: Wiring = wire(
        system, {name: read_fmu(c.fmu) for name, c in system.components.items()}
    )
    timetable = Timetable(wiring)
    _ = timetable.schedule, timetable.order
    return timetable


def _load(name: str, fmu: FmuDescription, stack: ExitStack) -> Instance:
    folder = stack.enter_context(unpacked(fmu.path))
    instance: Instance
    if fmu.needs_execution_tool:
        from orchestrator.isolated import IsolatedInstance

        instance = IsolatedInstance(name, fmu, folder, _log)
    else:
        instance = LocalInstance(name, fmu, folder, _log)
    stack.callback(instance.close)
    return instance


def _log(name: str, message: LogMessage) -> None:
    level = logging.INFO if message.status == "OK" else logging.WARNING
    LOG.log(level, "%s at t = %.9g s: %s", name, message.time, message)


def _execute(
    timetable: Timetable,
    executor: Executor,
    recorder: Recorder,
    progress: Progress | None,
) -> Timing:
    begun = told = perf_counter()
    tick, count = timetable.schedule.tick, 0
    for k, program in timetable.instants():
        executor.run(k, program)
        count += 1
        if count % CHECKED == 0 and (now := perf_counter()) - told > BETWEEN:
            told = now
            recorder.flush()
            if progress:
                progress(k * tick)
    if progress:
        progress(timetable.wiring.system.stop)
    wall = perf_counter() - begun
    return Timing(wall, count, float(timetable.wiring.system.stop))
