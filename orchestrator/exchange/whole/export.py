"""A composition as one FMU (FMI 2.0 or 3.0, co-simulation) with its exact timetable.

Inside is the loop of the fused executor with our models as equations, behind the
adapters of our FMUs, which take it for one model: any rates, offsets, latencies,
faults, initial circles.  What an output shows is what ``run`` records at that time,
bit for bit.

An outside input is read by a continuous component at the step it drives, by a sampled
one an outer step later: its tick at the end of a step sees what was set before that
step.  The description says of each input which it is.  In event mode (FMI 3) sampled
components wait for the clock at the end of a step, and nothing is late.

FMUs of others are carried along in ``resources`` and called; their states are part of
the whole's where all of them serialise theirs, else there are none.
Refused in words: those that are sampled, for model exchange or to be isolated, Python
FMUs, whole numbers of 64 bits.
"""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from hashlib import sha256
from itertools import takewhile
from math import lcm
from pathlib import Path
from uuid import UUID

from lxml import etree

from fmus.archive import EXTRA, write_archive
from fmus.cache import cache_folder
from fmus.compile import host_platform
from fmus.documentation import license_text
from fmus.native_source import MODEL_DATA, adapter_sources
from fmus.package import binaries
from fmus.subject import Fmi
from fmus.trust import is_trusted
from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.exchange.whole.describe import Told, describe, page
from orchestrator.exchange.whole.ends import Ends
from orchestrator.exchange.whole.foreign import (
    WholeSource,
    carried,
    foreign_parts,
    states_of,
)
from orchestrator.exchange.whole.model import model_table
from orchestrator.exchange.whole.tables import Halves, Tables, base_values
from orchestrator.fmu.ports import ports
from orchestrator.master.fused.executor import fusible
from orchestrator.master.fused.library import FAULTS, HEADERS
from orchestrator.master.groups import only_python
from orchestrator.master.layout import kind_of
from orchestrator.master.schedule import Stretch, rational_gcd
from orchestrator.master.simulate import plan
from orchestrator.master.timetable import Program, Timetable
from orchestrator.scenario.compose import Composition
from orchestrator.system import Injection, System, split_name

NATIVE = Path(__file__).with_name("native")
ADAPTER = ("simulation.c", "all.c")  # what the adapters have otherwise
FAR = Fraction(10**6)  # s, behind which the pattern of the rates repeats in any case
MOST_INSTANTS = 100_000  # stored as a table
BEFORE_TICKS = ("advance", "read", "copy", "fault")
QUIET = """\
#define _GNU_SOURCE /* dladdr, where FMUs of others are inside */
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
#pragma GCC diagnostic ignored "-Wmacro-redefined"
#define W 1
"""


def export_whole(
    composition: Composition,
    target: Path,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    platforms: Sequence[str] = (),
    fmi: Fmi = 2,
    *,
    clock: bool = True,
) -> Path:
    """Write a composition as one FMU; without ``outputs`` it has what is recorded.

    Without ``clock`` FMI 3 is as late as FMI 2, for tools that know no clocks.

    Raises:
        ScenarioError: something of it cannot be compiled in, or there is no such
            input or output; the message says which.
        BuildError: C does not compile.
    """
    system = _endless(composition, inputs, outputs)
    timetable = plan(system)
    if why := only_python(timetable.wiring):
        raise ScenarioError(
            f"{why}, which no exported FMU does; only `run` does, by the executor "
            f"python"
        )
    timetable = Timetable(replace(timetable.wiring, injected=()))
    whole = _Whole(composition, timetable, inputs, clocked=clock)
    contents = whole.contents(fmi, tuple(platforms) or (host_platform(),))
    target.parent.mkdir(parents=True, exist_ok=True)
    return write_archive(target, contents)


def _endless(
    composition: Composition, inputs: Sequence[str], outputs: Sequence[str]
) -> System:
    """Return the system with the outputs as its only record, and no end in sight."""
    system = composition.system
    _refuse_driven(composition, inputs)
    record = {}
    for name in outputs or system.record:
        component, _ = split_name(name)
        if component not in system.components:
            remedy = did_you_mean(component, system.components)
            raise ScenarioError(
                f"--outputs {name}: no component {component!r}; {remedy}"
            )
        record[name] = (system.components[component].period,)
    # an input of a foreign FMU gets a place, as if something were added to it
    free = {
        name: Injection((0.0,))
        for name in inputs
        if (of := system.components.get(split_name(name)[0])) and not is_trusted(of.fmu)
    }
    periods = [c.period for c in system.components.values()]
    scale = lcm(*(p.denominator for p in periods))
    length = Fraction(lcm(*(int(p * scale) for p in periods)), scale)
    stop = -(-FAR // length) * length
    return replace(system, record=record, stop=stop, injections=free)


def _refuse_driven(composition: Composition, inputs: Sequence[str]) -> None:
    """Refuse inputs from outside that are driven inside, or given twice."""
    sinks = composition.system.connections
    driven = {key: sink for sink in sinks for key in _numbers(composition, sink)}
    variables = {key[:2] for key in driven}
    given: dict[tuple[str, str, int], str] = {}
    for name in inputs:
        for key in _numbers(composition, name):
            where = f"--inputs {name}"
            if sink := driven.get(key):
                raise ScenarioError(
                    f"{where}: {sinks[sink]} drives it; leave that out with --set "
                    f"connections.{sink}=false"
                )
            array = composition.fmus[key[0]].variables[key[1]].shape
            if array and key[:2] in variables:
                raise ScenarioError(
                    f"{where}: other elements of {key[1]} are connected, and an array "
                    f"of FMI 3 is given as a whole; build {key[0]} as fmi = 2, or "
                    f"connect all elements or none"
                )
            if key in given:
                raise ScenarioError(f"{where}: is the same input as {given[key]}")
            given[key] = name


def _numbers(composition: Composition, full: str) -> list[tuple[str, str, int]]:
    """Return the numbers that an input's name stands for; none of what is not there."""
    owner, name = split_name(full)
    part = composition.system.components.get(owner)
    if part is None or not name:
        return []
    found = ports(part, composition.fmus[owner], name)
    return [(owner, port.variable.name, port.element) for port in found]


class _Whole:
    def __init__(
        self,
        composition: Composition,
        timetable: Timetable,
        inputs: Sequence[str],
        *,
        clocked: bool,
    ) -> None:
        self.composition, self.timetable = composition, timetable
        self.clocked = clocked
        wiring = timetable.wiring
        found, whys = fusible(wiring.parts)
        ends: dict[str, set[str]] = {}
        for name in inputs:
            for owner, variable, _ in _numbers(composition, name):
                ends.setdefault(owner, set()).add(variable)
        source = WholeSource(timetable, found, {})
        source.foreign = foreign_parts(timetable, whys, ends)
        self.foreign = source.foreign
        stretches = _for_ever(timetable)
        source.programs.clear()
        for stretch in stretches:
            for program in (half for halves in stretch.entries for half in halves):
                source.programs.setdefault(program, len(source.programs))
        starts = {n: base_values(own) for n, own in source.own.items()}
        starts |= {n: one.starts() for n, one in source.foreign.items()}
        outside = Ends(source, starts, inputs, clocked=clocked).outside()
        self.tables = Tables(source, stretches, starts, outside)

    def contents(self, fmi: Fmi, platforms: Sequence[str]) -> dict[str, bytes]:
        """Return the files of the FMU by name."""
        adapters = adapter_sources()
        without = {"snapshot_absent.c", "snapshot_foreign.c"}
        if self.foreign:
            has = states_of(self.foreign)
            used = "snapshot_foreign.c" if has else "snapshot_absent.c"
            without = (without | {"snapshot.c"}) - {used}
        snapshot = adapters["snapshot.c"]
        taken = {n for n in adapters if n not in (*ADAPTER, *without)}
        adapters = {n: adapters[n] for n in sorted(taken)}
        text = "\n".join([QUIET, self.tables.source.text(), self.tables.text()])
        own = {file.name: file for file in (*HEADERS.glob("*.h"), FAULTS)}
        native = NATIVE.glob("*.[ch]")
        own |= {file.name: file for file in native if file.name not in without}
        sources = {name: own[name].read_text(encoding="utf-8") for name in sorted(own)}
        if "snapshot_foreign.c" in sources:
            sources["snapshot_own.h"] = snapshot
        described = [describe(self._told(), version, "") for version in (2, 3)]
        whole = sha256(b"".join(described) + text.encode())
        for name, code in sorted((sources | adapters).items()):
            whole.update(f"{name}\0{code}\0".encode())
        token = f"{{{UUID(bytes=whole.digest()[:16])}}}"
        table = model_table(self.tables, self.identifier, token, self.clock)
        sources[MODEL_DATA] = "\n".join([text, table, '#include "running.h"', ""])
        licences = "license.txt" if fmi == 2 else "licenses/license.txt"
        found = {
            "modelDescription.xml": describe(self._told(), fmi, token),
            "documentation/index.html": page(self.composition, self.tables.outside),
            f"documentation/{licences}": license_text(),
            EXTRA: self._kind(fmi),
        }
        found |= carried(self.foreign, platforms)
        place = cache_folder() / "whole"
        parts = (self.identifier, sources, fmi, platforms, place, adapters)
        return found | binaries(*parts, ("dl",) if self.foreign else ())

    @property
    def identifier(self) -> str:
        name = self.composition.system.name.rpartition("/")[2]
        plain = "".join(c if c.isalnum() and c.isascii() else "_" for c in name)
        return plain if plain[:1].isalpha() else f"_{plain}"

    @property
    def clock(self) -> Fraction | None:
        """The base period (s) of the sampled components, if there are any."""
        if not self.clocked:
            return None
        sampled = [
            part.component
            for part in self.timetable.wiring.parts.values()
            if kind_of(part.component, part.fmu) == "sampled"
        ]
        times = [t for c in sampled for t in (c.period, c.offset) if t]
        return rational_gcd(*times) if times else None

    def _told(self) -> Told:
        size = len(self.tables.outside) + len(self.tables.source.parts) + 2
        parts = (self.composition, self.identifier, self.tables.outside, size)
        return Told(*parts, self.clock, states_of(self.foreign))

    def _kind(self, fmi: Fmi) -> bytes:
        """Return what our own master reads, and the standard has no attribute for."""
        facts = {"kind": "continuous"}
        if fmi == 3 and self.clock:
            num, den = self.clock.as_integer_ratio()
            facts = {"kind": "sampled", "period": f"{num}/{den}"}
        return bytes(etree.tostring(etree.Element("Model", facts)))


def _for_ever(timetable: Timetable) -> list[Stretch[Halves]]:
    """Return the stretches up to the one that repeats, every instant in two halves.

    Raises:
        ScenarioError: it is too long.
    """
    found, count = list[Stretch[Halves]](), 0
    for stretch in timetable.stretches():
        count += len(stretch.offsets)
        if count > MOST_INSTANTS:
            raise ScenarioError(
                f"the pattern of the rates (and faults) repeats after more than "
                f"{MOST_INSTANTS:,} instants only, which do not go into an FMU; choose "
                f"rates that meet sooner, and faults that begin and end sooner"
            )
        halves = tuple(_halves(program) for program in stretch.entries)
        first, length, repeats = stretch.first, stretch.length, stretch.repeats
        found.append(Stretch(first, length, repeats, stretch.offsets, halves))
        if stretch.repeats > 1:
            break
    return found


def _halves(program: Program) -> Halves:
    """Return what happens to the continuous components, then the rest."""
    before = len(list(takewhile(lambda op: op.code in BEFORE_TICKS, program)))
    return program[:before], program[before:]
