"""The fused executor: components of ours as equations, the others as calls.

It is the kernel with another loop: the same structures for FMUs that stay calls,
for rows and failures, and the same bits.  All FMUs are initialised as for any
executor; then the values of ours are taken over and their instances rest.

Ours are inlined where they run in this process, take and give numbers only and
nothing but inputs is driven; a system without any is refused.
"""

import zipfile
from collections.abc import Iterator, Mapping
from ctypes import byref
from time import perf_counter
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fmus.equations import Equations, Unreadable, read_equations
from fmus.native_source import MODEL_DATA
from fmus.trust import is_trusted
from orchestrator.errors import SimulationError
from orchestrator.fmu.description import FmuDescription
from orchestrator.instances.instance import LocalInstance
from orchestrator.instances.protocol import Instance
from orchestrator.master.fused.library import load
from orchestrator.master.fused.memory import Memory
from orchestrator.master.fused.own import Own
from orchestrator.master.fused.source import Source
from orchestrator.master.kernel import CHUNK_S, FIRST, Kernel
from orchestrator.master.layout import Part
from orchestrator.master.recorder import Table
from orchestrator.master.schedule import Stretch
from orchestrator.master.timetable import Program, Timetable

NOT_FINITE, APART, LINE_FULL = 1, 2, 3
_read: dict[tuple[str, float], Equations | None] = {}


class Fused(Kernel):
    """Runs a timetable on initialised instances; ``count`` instants are done.

    Raises:
        SimulationError: no component can be fused; the message says why.
    """

    name: Literal["kernel", "python", "fused"] = "fused"

    def __init__(
        self,
        timetable: Timetable,
        instances: Mapping[str, Instance],
        vector: NDArray[np.float64],
        tables: Mapping[str, Table],
    ) -> None:
        super().__init__(timetable, instances, vector, tables)
        found, whys = fusible(timetable.wiring.parts, instances)
        if not found:
            raise SimulationError(
                "executor fused: no component can become part of one function: "
                + "; ".join(f"{name} {why}" for name, why in whys.items())
            )
        self._source = Source(timetable, found, {})
        self._loop = load(self._source.text(), 1)
        self._memory = Memory(self._source, 1, vector, {}, self._kernel)
        for own in self._source.own.values():
            taken_over(own, instances[own.part.name], self._memory)
        self._loop.engine_adopt(byref(self._memory.engine))

    def run(self) -> Iterator[int]:
        """Carry out all instants; yield the one reached after every chunk.

        Raises:
            SimulationError: an FMU failed or gave a value that is not finite.
        """
        chunk = FIRST
        for stretch in self._timetable.stretches():
            self._stretch(stretch)
            offsets, programs = self._numbered(stretch)
            length = len(offsets)
            done, total = 0, length * stretch.repeats
            while done < total:
                begun = perf_counter()
                room = min(chunk, total - done)
                if self.until is not None:
                    room = min(room, max(1, stretch.before(self.until) + 1 - done))
                n = self._loop.engine_run(
                    byref(self._memory.engine),
                    stretch.first,
                    stretch.length,
                    offsets.ctypes.data,
                    programs.ctypes.data,
                    length,
                    done,
                    room,
                )
                took = perf_counter() - begun
                done, self.count = done + n, self.count + n
                if self._memory.engine.failure:
                    raise self._failed()
                if self._kernel.failure:
                    raise self._error()
                self._flush_full()
                if n == chunk or took > CHUNK_S:
                    chunk = max(1, min(2 * chunk, int(n * CHUNK_S / took)))
                r, i = divmod(done - 1, length)
                yield stretch.first + r * stretch.length + stretch.offsets[i]

    def _numbered(
        self, stretch: Stretch[Program]
    ) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
        numbers = [self._source.programs[program] for program in stretch.entries]
        return np.array(stretch.offsets, np.int64), np.array(numbers, np.int32)

    def _failed(self) -> SimulationError:
        engine = self._memory.engine
        name = self._source.parts[engine.part]
        t = self._timetable.schedule.seconds(engine.instant)
        own = self._source.own[name]
        if engine.failure == LINE_FULL:
            return SimulationError(
                f"{name} at t = {t:.9g} s: a delayed input changed too often within "
                f"its dead time; steps of {own.equations.numbers['h_max']:g} s and "
                f"more always fit"
            )
        return not_finite(own, self._memory.values[name][:, 0], t)


def not_finite(own: Own, values: NDArray[np.float64], t: float) -> SimulationError:
    """Return the error for the first state or output that is not finite."""
    y, end = own.equations["y"], own.equations["x"] + own.equations["n_x"]
    bad = next((i for i in range(y, end) if not np.isfinite(values[i])), None)
    file = own.part.fmu.path.name
    if bad is None:
        return SimulationError(f"{own.part.name} ({file}) at t = {t:.9g} s failed")
    variable = next(
        v
        for v in own.part.fmu.variables.values()
        if v.reference <= bad < v.reference + v.size
    )
    return SimulationError(
        f"{own.part.name} ({file}): {variable.name} is {values[bad]:g} at "
        f"t = {t:.9g} s; finite values were expected"
    )


def fusible(
    parts: Mapping[str, Part], instances: Mapping[str, Instance] | None = None
) -> tuple[dict[str, Equations], dict[str, str]]:
    """Return the equations of the components that can be inlined; why others cannot.

    Without ``instances``, all that isolation does not keep apart count as here.
    """
    found: dict[str, Equations] = {}
    whys: dict[str, str] = {}
    for name, part in parts.items():
        here = part.component.isolation.process is not True
        if instances is not None:
            here = isinstance(instances[name], LocalInstance)
        ours = is_trusted(part.fmu.path)
        equations = equations_of(part.fmu) if here and ours else None
        if not ours:
            whys[name] = "is no FMU of ours"
        elif not here:
            whys[name] = "runs in a process of its own"
        elif equations is None:
            whys[name] = "has no equations that can be read (a Python FMU, or too old)"
        elif why := _unfit(part):
            whys[name] = why
        else:
            found[name] = equations
    return found, whys


def _unfit(part: Part) -> str | None:
    if not part.fmu.co_simulation:
        return "is integrated by model exchange"
    driven = next((v for v in part.inputs if v.causality != "input"), None)
    if driven is not None:
        return f"has its {driven.causality} {driven.name} driven by a connection"
    if not all(c.is_exact or c.is_of_doubles for c in part.copies):
        return "feeds an integer of 64 bits, or one that a map rounds"
    return None


def equations_of(fmu: FmuDescription) -> Equations | None:
    """Return the equations inside an FMU of ours; None if it has none to read."""
    key = str(fmu.path), fmu.path.stat().st_mtime
    if key not in _read:
        try:
            with zipfile.ZipFile(fmu.path) as archive:
                text = archive.read(f"sources/{MODEL_DATA}").decode()
            _read[key] = read_equations(text)
        except (KeyError, Unreadable):
            _read[key] = None
    return _read[key]


def taken_over(own: Own, instance: Instance, memory: Memory) -> None:
    """Copy an initialised instance's values into those of the loop."""
    values = memory.values[own.part.name]
    for variable in own.part.fmu.variables.values():
        if variable.reference < own.equations["size"] - 1:
            place = slice(variable.reference, variable.reference + variable.size)
            values[place, 0] = instance.read([variable])
    memory.make_lines(own)
