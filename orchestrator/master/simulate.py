"""One run of a system: the order in which everything is opened and closed.

1. read and check all FMUs, wire, order, schedule: nothing has run yet;
2. unpack and load each FMU (those that were not built here, or need Python or
   another tool, in a process of their own), initialise together;
3. execute the timetable, recording: natively where all FMUs run in this process
   and a compiler is there, else in Python, with the same bits;
4. whatever happens: end the streams, terminate and free the instances, delete
   what was unpacked.  Rows recorded before a failure stay readable.
"""

import gc
import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from time import perf_counter
from typing import Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fmus.compile import CompileError
from fmus.trust import is_trusted
from orchestrator.errors import ScheduleError, SimulationError, shown
from orchestrator.fmu.archive import unpacked
from orchestrator.fmu.description import FmuDescription, read_fmu
from orchestrator.fmu.structure import sized
from orchestrator.instances.doing import rest
from orchestrator.instances.ending import Ended
from orchestrator.instances.load import load
from orchestrator.instances.logs import LogMessage
from orchestrator.instances.protocol import Instance
from orchestrator.master.apart import let_in, simulate_apart
from orchestrator.master.checkpoint import Checkpoints, Keeper, refuse_options
from orchestrator.master.executor import Executor
from orchestrator.master.groups import only_python
from orchestrator.master.initialise import initialise
from orchestrator.master.layout import Wiring
from orchestrator.master.pace import Pacer
from orchestrator.master.recorder import Recorder, refuse_no_room
from orchestrator.master.remembered import Remembered
from orchestrator.master.timetable import Timetable
from orchestrator.master.warm import Origin, Warm
from orchestrator.master.wiring import wire
from orchestrator.profile import Profile, Spent
from orchestrator.result import End, Result, Timing
from orchestrator.system import Isolation, System
from orchestrator.warned import warn

LOG = logging.getLogger("feeddrive")
_UNSAID = Isolation()
NOT_RUN = ("sources/", "documentation/")  # parts of an FMU that no run needs
LONGEST_LINE = 10_000_000  # numbers that one latency or delay holds back
BETWEEN = 0.1  # s of wall time between two calls of progress, and two flushes

Progress = Callable[[Fraction], None]
Choice: TypeAlias = Literal["kernel", "python", "fused"]


class Engine(Protocol):
    """Carries out a timetable: yields instants reached, counts those done.

    It goes on behind ``count`` instants, and yields when ``until`` is reached.
    """

    name: Choice
    count: int
    until: int | None

    def run(self) -> Iterator[int]: ...
    def spent(self) -> tuple[Mapping[str, Spent], float]: ...
    def remembered(self) -> Remembered: ...
    def remember(self, known: Remembered) -> None: ...


def simulate(
    system: System,
    folder: Path,
    *,
    timetable: Timetable | None = None,
    progress: Progress | None = None,
    executor: Choice | None = None,
    profile: bool = False,
    recorded: Callable[[Result], None] | None = None,
    checkpoints: Checkpoints | None = None,
    pace: float | None = None,
    origin: Origin | None = None,
) -> Result:
    """Run a system and return what it recorded, kept under ``folder/result``.

    ``timetable`` is what ``plan`` returned for it, if that was asked before.
    ``progress`` is told the time reached (s), about ten times a second.
    ``executor`` is chosen when None; with ``profile`` the timing of the result
    says where the time went.  ``recorded`` is told the result before FMUs are freed.
    With ``checkpoints`` a run that is killed can be gone on with; ``pace`` holds it
    to the clock, so many times as fast; it begins where ``origin`` was, else at 0.

    Raises:
        FmuError, WiringError, ScheduleError: refused before anything ran.
        SimulationError: the run failed; rows until then are readable.
    """
    timetable = timetable or plan(system)
    saves, paced = bool(checkpoints or origin), pace is not None
    refuse_options(timetable, executor, profile=profile, saves=saves, paced=paced)
    pacer = None if pace is None else Pacer(pace, timetable)
    warm = Warm(origin, timetable) if origin else None
    if let_in(timetable):
        return simulate_apart(simulate, system, folder, timetable, progress, executor)
    wiring = timetable.wiring
    for note in wiring.notes:
        LOG.info(note)
    for guess in wiring.warnings:
        warn(guess)
    if warm:
        warn(str(warm))
    folder.mkdir(parents=True, exist_ok=True)
    refuse_no_room(folder, wiring.tables, system.stop)
    vector = np.zeros(wiring.size)
    shared: dict[Path, Path] = {}
    with ExitStack() as stack:
        instances = {
            name: open_instance(name, part.fmu, stack, part.component.isolation, shared)
            for name, part in wiring.parts.items()
        }
        quiet = not LOG.isEnabledFor(logging.INFO)
        initialise(wiring, instances, vector, quiet=quiet)
        keeper = None
        if checkpoints:
            keeper = Keeper(folder, checkpoints, timetable, instances, vector)
        rows = keeper.saved.rows if keeper and keeper.saved else None
        if warm and rows is None:
            warm.restore(instances, vector)
        recorder = Recorder(folder / "result", wiring.tables, vector, rows)
        complete = False
        try:
            with _older_objects_left_alone():
                engine = _engine(
                    executor, timetable, instances, vector, recorder, profile
                )
                if warm and rows is None:
                    warm.begin(engine, recorder)
                timing, ended = _execute(
                    timetable, engine, recorder, progress, keeper, pacer, warm
                )
            if profile:
                where = Profile.of(*engine.spent(), timing.wall_s)
                timing = replace(timing, profile=where)
            complete = True
        finally:
            drop = keeper.drop if keeper else lambda: None
            recorder.close(complete=complete, converted=drop)
        result = Result(folder, timing, ended)
        if recorded:
            recorded(result)
    return result


@contextmanager
def _older_objects_left_alone() -> Iterator[None]:
    """Spare the run walks of the garbage collector over all there was before it.

    With 200 FMUs one walk takes 100 ms, as long as 6,000 steps.
    """
    if gc.get_freeze_count():  # the caller's own choice, or another run's
        yield
        return
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def _engine(
    executor: Choice | None,
    timetable: Timetable,
    instances: Mapping[str, Instance],
    vector: NDArray[np.float64],
    recorder: Recorder,
    profiled: bool,
) -> Engine:
    """Return the executor asked for, else the fastest that works here.

    Raises:
        SimulationError: the kernel was asked for and cannot be used.
    """
    why = only_python(timetable.wiring)
    if profiled and why:
        raise SimulationError(
            f"profile: {why}, and whose time that takes is not known; run without it"
        )
    if executor == "fused":
        from orchestrator.master.fused.executor import Fused

        if profiled:
            raise SimulationError(
                "executor fused: where the time goes inside one function is not "
                "known; profile with the kernel"
            )
        try:
            return Fused(timetable, instances, vector, recorder.tables)
        except CompileError as error:
            raise SimulationError(
                f"executor fused cannot be compiled: {error}"
            ) from None
    if executor != "python" and (executor or not why):
        from orchestrator.master.kernel import Kernel

        try:
            return Kernel(
                timetable, instances, vector, recorder.tables, profiled=profiled
            )
        except CompileError as error:
            why = f"the kernel cannot be compiled: {error}"
        if executor == "kernel":
            raise SimulationError(f"executor kernel: {why}; leave the choice open")
        warn(f"{why}; the Python executor is used, which is slower")
    rows = {name: table.row for name, table in recorder.tables.items()}
    return Executor(timetable, instances, vector, rows, profiled=profiled)


def plan(system: System) -> Timetable:
    """Check a system completely and return its timetable, without running it."""
    wiring: Wiring = wire(
        system, {n: sized(read_fmu(c.fmu), c) for n, c in system.components.items()}
    )
    _refuse_long_lines(wiring)
    timetable = Timetable(wiring)
    _ = timetable.schedule, timetable.order
    return timetable


def _refuse_long_lines(wiring: Wiring) -> None:
    """Refuse what is held back for longer than there is memory for.

    Raises:
        ScheduleError: a latency or a delay has too many samples.
    """
    lines = {
        f"components.{name}.latency": (part.component.latency, part.delayed)
        for name, part in wiring.parts.items()
    }
    for name, faults in wiring.system.faults.items():
        lines[f"faults.{name}"] = (max(fault.samples for fault in faults), 1)
    for where, (samples, width) in lines.items():
        if samples * width > LONGEST_LINE:
            raise ScheduleError(
                f"{where}: {samples} samples of {width} numbers would have to be "
                f"kept; at most {LONGEST_LINE} numbers are"
            )


def open_instance(
    name: str,
    fmu: FmuDescription,
    stack: ExitStack,
    isolation: Isolation = _UNSAID,
    shared: dict[Path, Path] | None = None,
) -> Instance:
    """Unpack and load an FMU; closing ``stack`` frees it and deletes its folder.

    ``shared`` keeps the folders of FMU files that several instances may share, so
    that their code is loaded once: 200 copies of one library are 8 times as slow.

    Raises:
        FmuError: its library cannot be loaded here.
    """
    apart = isolation.process
    if apart is None:
        apart = fmu.needs_execution_tool or not is_trusted(fmu.path)
    alone = shared is None or apart or fmu.once_per_process
    folders = {} if shared is None or alone else shared
    if fmu.path not in folders:
        folders[fmu.path] = stack.enter_context(unpacked(fmu.path, NOT_RUN))
    folder, clocks = folders[fmu.path], shared is not None
    instance: Instance
    if apart:
        from orchestrator.instances.isolated import IsolatedInstance

        instance = IsolatedInstance(name, fmu, folder, _log, isolation, clocks)
    else:
        instance = load(name, fmu, folder, _log, clocks=clocks)
    stack.callback(instance.close)
    return instance


def _log(name: str, message: LogMessage) -> None:
    level = logging.INFO if message.status == "OK" else logging.WARNING
    LOG.log(level, "%s at t = %.9g s: %s", name, message.time, shown(str(message)))


def _execute(
    timetable: Timetable,
    engine: Engine,
    recorder: Recorder,
    progress: Progress | None,
    keeper: Keeper | None,
    pacer: Pacer | None,
    warm: Warm | None,
) -> tuple[Timing, End | None]:
    """Carry out all instants, or those until an FMU ends the run."""
    begun = told = perf_counter()
    stop = timetable.wiring.system.stop
    begin, before = (warm.instant, warm.before) if warm else (0, 0)
    if keeper:
        begun -= keeper.begin(engine, recorder, begin)
    if pacer:
        engine.until = pacer.first()
    reached, ended = float(stop), None
    try:
        for k in engine.run():
            rest()
            if keeper and engine.until is not None and k >= engine.until:
                keeper.write(k, engine, perf_counter() - begun, recorder)
            if pacer:
                engine.until = pacer.reached(k)
            if (now := perf_counter()) - told > BETWEEN:
                told = now
                recorder.flush()
                if progress:
                    progress(k * timetable.schedule.tick)
    except Ended as end:
        reached, ended = end.at, End(end.by, end.at, end.reason)
    else:
        if progress:
            progress(stop)
    paced, wall = pacer.told() if pacer else None, perf_counter() - begun
    done, simulated = engine.count - before, reached - timetable.schedule.seconds(begin)
    timing = Timing(wall, done, simulated, engine.name, paced=paced)
    return timing, ended
