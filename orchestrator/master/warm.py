"""A run that begins where another was: at a checkpoint of it that was kept.

What is simulated has to be what the other run had: the same FMU files, rates,
latencies, connections and recorded signals, as states, vector and lines are taken from
there.  What may differ: tunable parameters, inputs that nothing drives, faults that
begin later, the periods of rows, what is evaluated, and the stop.  The first rows are
those of the other run at that time; without a difference all later ones have its bits.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ScenarioError
from orchestrator.fmu.description import FmuVariable
from orchestrator.fmu.start_values import Written, declared
from orchestrator.instances.protocol import Instance
from orchestrator.instances.saving import restore
from orchestrator.master.layout import Part
from orchestrator.master.recorder import Recorder
from orchestrator.master.remembered import Words
from orchestrator.master.saved import Saved, as_text, described, kept_times, read
from orchestrator.master.timetable import Timetable, table_name

Key: TypeAlias = tuple[str, ...]
REASONS = {
    "fmu": "its FMU is another file, and a state is that of one FMU",
    "connections": "its connections, or the gains and offsets of their maps, differ",
    "inputs": "other inputs of it are connected",
    "read": "other signals of it are connected or recorded",
    "places": "other signals are connected or recorded",
}


@dataclass(frozen=True)
class Origin:
    """Where a run begins: a checkpoint of ``run``, as the user names it."""

    run: str
    file: Path
    saved: Saved

    @property
    def time(self) -> Fraction:
        """The time (s) at which it begins."""
        return self.saved.time

    def __str__(self) -> str:
        return f"{self.run} at {_s(self.time)}"


def origin(run: str, folder: Path, time: Fraction) -> Origin:
    """Return the checkpoint that the run in a folder keeps of a time (s).

    Raises:
        ScenarioError: there is none; the message names the nearest.
    """
    times = kept_times(folder)
    if not times:
        raise ScenarioError(
            f"--from {run}: keeps no checkpoints; run it with --checkpoint S "
            f"--keep-checkpoints"
        )
    if time not in times:
        near = [t for t in times if t < time][-1:] + [t for t in times if t > time][:1]
        raise ScenarioError(
            f"--from {run}: has no checkpoint at {_s(time)}; the nearest of "
            f"{len(times)} {'are' if len(near) > 1 else 'is'} at "
            f"{' and '.join(_s(t) for t in near)}"
        )
    return Origin(run, times[time], read(times[time]))


class Warm:
    """Brings a system to where its origin was.

    Raises:
        ScenarioError: it is not that system; the message names the first difference.
    """

    def __init__(self, origin: Origin, timetable: Timetable) -> None:
        self._origin, self._saved = origin, origin.saved
        self._timetable, self._wiring = timetable, timetable.wiring
        schedule = timetable.schedule
        self.instant = int(origin.time // schedule.tick)
        if origin.time >= self._wiring.system.stop:
            raise ScenarioError(
                f"--from {origin}: the run is to stop at "
                f"{_s(self._wiring.system.stop)}; give a later stop"
            )
        self._now = described(self._wiring)
        self._refuse_another_system()
        self._changed = {n: list(self._values(p)) for n, p in self._parts()}
        self._refuse_faults_that_have_begun()

    def __str__(self) -> str:
        changed = [
            f"{name}.{variable.name} = {', '.join(str(value) for value in values)}"
            for name, written in self._changed.items()
            for variable, values in written
        ]
        since = f"; from then on {', '.join(changed)}" if changed else ""
        return f"begins with the state of {self._origin}{since}"

    @cached_property
    def before(self) -> int:
        """How many instants are done, that of the origin included."""
        count = 0
        for stretch in self._timetable.stretches():
            done = stretch.before(self.instant + 1)
            count += done
            if done < stretch.repeats * len(stretch.offsets):
                break
        return count

    def restore(
        self, instances: Mapping[str, Instance], vector: NDArray[np.float64]
    ) -> None:
        """Bring initialised instances and the vector into the state of the origin, and
        set what differs.
        """
        vector[:] = self._saved.vector
        for name, instance in instances.items():
            restore(instance, self._saved.states[name])
            written = self._changed[name]
            variables = [variable for variable, _ in written]
            instance.write(variables, [v for _, values in written for v in values])

    def begin(self, engine: Any, recorder: Recorder) -> None:
        """Let an engine, made since, go on behind the instant of the origin."""
        known = engine.remembered()
        faults = self._faults(known.faults)
        engine.remember(type(known)(self._saved.remembered.lines, faults))
        engine.count = self.before
        for period in self._wiring.tables:
            if self._origin.time % period == 0:
                recorder.tables[table_name(period)].row(float(self._origin.time))

    def _parts(self) -> Iterator[tuple[str, Part]]:
        yield from self._wiring.parts.items()

    def _refuse_another_system(self) -> None:
        there, here = self._saved.about["components"], self._now["components"]
        if list(there) != list(here):
            raise self._refusal(
                f"it has the components {', '.join(there)}, the run {', '.join(here)}"
            )
        for name, now in here.items():
            for key, value in now.items():
                if value == there[name][key]:
                    continue
                told = f"{key} = {there[name][key]} there, {value} here"
                file = self._wiring.parts[name].fmu.path.name
                raise self._refusal(
                    f"components.{name} ({file}): {REASONS.get(key, told)}"
                )

    def _values(self, part: Part) -> Iterator[Written]:
        """Yield the variables whose values differ, as they are here."""
        there = self._saved.about["start"][part.name]
        here = self._now["start"][part.name]
        given = {v.name: values for v, values in part.start}
        for name in dict.fromkeys([*there, *here]):
            if there.get(name) == here.get(name):
                continue
            variable = part.fmu.variables[name]
            own = tuple(v for v in declared(variable) if v is not None)
            values = given.get(name) or own
            if as_text(variable, values) != there.get(name, as_text(variable, own)):
                self._refuse_what_stays(part, variable, bool(values))
                yield variable, values

    def _refuse_what_stays(
        self, part: Part, variable: FmuVariable, known: bool
    ) -> None:
        tunable = variable.variability == "tunable"
        free = variable.causality == "input" and variable not in part.inputs
        if not known:
            why = "has no value here, and its FMU declares none"
        elif free or (variable.causality == "parameter" and tunable):
            return
        elif variable.causality == "input":
            why = "is driven, and a start value means nothing later"
        elif variable.causality == "parameter":
            why = "is fixed when the run is initialised"
        else:
            why = "is a state, which comes from there"
        raise self._refusal(
            f"components.{part.name}.{variable.name} differs, and {why}; leave it as "
            f"it was"
        )

    def _refuse_faults_that_have_begun(self) -> None:
        time = self._origin.time
        there = dict(self._saved.about["faults"])
        for faulty in self._wiring.faulty:
            before = there.pop(faulty.place, [])
            here = [[str(x) for x in vars(fault).values()] for fault in faulty.faults]
            where = f"faults.{faulty.edge.sink}.{faulty.edge.input}"
            if _begun(before, time) != _begun(here, time):
                raise self._refusal(
                    f"{where}: what begins up to {_s(time)} has to be as it was there"
                )
            period = self._wiring.parts[faulty.edge.source].component.period
            known = set(_keys(before, time))
            for fault, told in zip(faulty.faults, _keys(here, time), strict=True):
                filled = time + (fault.samples + 1) * period
                remembers = fault.kind in ("delay", "stuck")
                if told not in known and remembers and fault.start < filled:
                    raise self._refusal(
                        f"{where}: a new fault ({fault.kind}) knows what was published "
                        f"before it from {_s(filled)} on; let it begin then or later"
                    )
        if left := [chain for chain in there.values() if _begun(chain, time)]:
            raise self._refusal(
                f"a fault ({left[0][0][0]}) that had begun there is left out"
            )

    def _faults(self, fresh: Words) -> Words:
        """Return what faults remember: those that were there as they do, others what
        they begin with.
        """
        there, rest = {}, self._saved.remembered.faults
        for place, chain in self._saved.about["faults"]:
            clean, rest = rest[:1], rest[1:]
            held: dict[Key, list[Words]] = {}
            for fault, key in zip(chain, _keys(chain, self._origin.time), strict=True):
                size = int(fault[2]) + 1
                held.setdefault(key, []).append(rest[:size])
                rest = rest[size:]
            there[place] = clean, held
        found, at = fresh.copy(), 0
        for faulty in self._wiring.faulty:
            clean, held = there.get(faulty.place, (fresh[at : at + 1], {}))
            found[at : at + 1], at = clean, at + 1
            here = [[str(x) for x in vars(fault).values()] for fault in faulty.faults]
            for fault, key in zip(here, _keys(here, self._origin.time), strict=True):
                size = int(fault[2]) + 1
                if held.get(key):
                    found[at : at + size] = held[key].pop(0)
                at += size
        return found

    def _refusal(self, why: str) -> ScenarioError:
        return ScenarioError(f"--from {self._origin}: {why}")


def _keys(chain: list[list[str]], time: Fraction) -> Iterator[Key]:
    """Yield each fault with what acted before it up to a time (s), by count: what it
    remembers is the same where both are.
    """
    begun = 0
    for fault in chain:
        yield (str(begun), *fault)
        begun += Fraction(fault[3]) <= time


def _begun(chain: list[list[str]], time: Fraction) -> list[list[str]]:
    return [fault for fault in chain if Fraction(fault[3]) <= time]


def _s(time: Fraction) -> str:
    return f"{float(time):.9g} s"
