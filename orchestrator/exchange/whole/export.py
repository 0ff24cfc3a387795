"""A composition as one FMU (FMI 2.0, co-simulation) that runs its exact timetable.

Inside is the loop of the fused executor with our models as equations: any rates,
offsets, latencies, initial circles that settle by substitution.  What an output shows
is what ``run`` records at that time, bit for bit.

An outside input is read by a continuous component at the step it drives, by a sampled
one an outer step later: its tick at the end of a step sees what was set before that
step.  The description says of each input which it is.

Refused in words: components that are not ours (they cannot be compiled in), faults,
injections, whole numbers of 64 bits.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from hashlib import sha256
from math import lcm
from pathlib import Path
from uuid import UUID

from fmus.archive import write_archive
from fmus.cache import cache_folder
from fmus.compile import PLATFORMS, compile_alone, host_platform, universal_binary
from fmus.documentation import license_text
from fmus.native_source import adapter_sources
from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.exchange.whole.describe import describe, page
from orchestrator.exchange.whole.tables import Outside, base_values, tables
from orchestrator.fmu.ports import Affine, ports
from orchestrator.master.fused.executor import fusible
from orchestrator.master.fused.library import ELEMENTARY, FAULTS, HEADERS, QUIET
from orchestrator.master.fused.source import Source
from orchestrator.master.layout import kind_of
from orchestrator.master.simulate import plan
from orchestrator.master.timetable import Timetable
from orchestrator.scenario.compose import Composition
from orchestrator.system import System, split_name

SHELL = Path(__file__).with_name("fmi2.h")
FMI2 = ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h")
ENOUGH = Fraction(10**6)  # s that the timetable reaches
MOST_INSTANTS = 100_000  # of a hyperperiod, stored as a table


def export_whole(
    composition: Composition,
    target: Path,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    platforms: Sequence[str] = (),
) -> Path:
    """Write a composition as one FMU; without ``outputs`` it has what is recorded.

    Raises:
        ScenarioError: something of it cannot be compiled in, or there is no such
            input or output; the message says which.
        fmus.compile.CompileError: C does not compile.
    """
    system = _endless(composition, inputs, outputs)
    timetable = plan(system)
    whole = _Whole(composition, timetable, inputs, tuple(system.record))
    contents = whole.contents(tuple(platforms) or (host_platform(),))
    target.parent.mkdir(parents=True, exist_ok=True)
    return write_archive(target, contents)


def _endless(
    composition: Composition, inputs: Sequence[str], outputs: Sequence[str]
) -> System:
    """Return the system with the outputs as its only record, and no end in sight."""
    system = composition.system
    if system.faults:
        raise ScenarioError(
            f"faults.{min(system.faults)}: faults are not compiled into an FMU; leave "
            f"them out with --set faults.{min(system.faults)}=false"
        )
    for name in inputs:
        if name in system.connections:
            raise ScenarioError(
                f"--inputs {name}: {system.connections[name]} drives it; leave that "
                f"out with --set connections.{name}=false"
            )
    record = {}
    for name in outputs or system.record:
        component, _ = split_name(name)
        if component not in system.components:
            remedy = did_you_mean(component, system.components)
            raise ScenarioError(
                f"--outputs {name}: no component {component!r}; {remedy}"
            )
        record[name] = (system.components[component].period,)
    periods = [c.period for c in system.components.values()]
    scale = lcm(*(p.denominator for p in periods))
    length = Fraction(lcm(*(int(p * scale) for p in periods)), scale)
    return replace(system, record=record, stop=-(-ENOUGH // length) * length)


class _Whole:
    def __init__(
        self,
        composition: Composition,
        timetable: Timetable,
        inputs: Sequence[str],
        outputs: Sequence[str],
    ) -> None:
        self.composition, self.timetable = composition, timetable
        self.inputs, self.outputs = inputs, outputs
        wiring = timetable.wiring
        found, whys = fusible(wiring.parts)
        if whys:
            told = "; ".join(f"{name} {why}" for name, why in whys.items())
            raise ScenarioError(
                f"only components of ours can be compiled into one FMU: {told}"
            )
        instants = sum(len(s.offsets) for s in timetable.stretches())
        if instants > MOST_INSTANTS:
            raise ScenarioError(
                f"the pattern of the rates repeats after {instants:,} instants only, "
                f"which do not go into an FMU; choose rates that meet sooner"
            )
        self.source = Source(timetable, found, {})
        self.starts = {n: base_values(own) for n, own in self.source.own.items()}
        self.outside = [*self._outputs(), *self._inputs(), *self._parameters()]

    def contents(self, platforms: Sequence[str]) -> dict[str, bytes]:
        """Return the files of the FMU by name."""
        text = (
            self.source.text() + "\n" + tables(self.source, self.starts, self.outside)
        )
        description = self.description("")
        code = text + SHELL.read_text(encoding="utf-8")
        token = sha256(code.encode() + description).digest()
        guid = f"{{{UUID(bytes=token[:16])}}}"
        text += f'#define GUID "{guid}"\n#include "whole.h"\n'
        adapters = adapter_sources()
        sources = {"whole.c": text, "whole.h": SHELL.read_text(encoding="utf-8")}
        for file in (*sorted(HEADERS.glob("*.h")), FAULTS):
            sources[file.name] = file.read_text(encoding="utf-8")
        sources |= {name: adapters[name] for name in (*ELEMENTARY, *FMI2)}
        found = {
            "modelDescription.xml": self.description(guid),
            "documentation/index.html": page(self.composition, self.outside),
            "documentation/license.txt": license_text(),
        }
        slices: dict[str, dict[str, bytes]] = {}
        for name in platforms:
            platform = PLATFORMS[name]
            library = compile_alone(
                self.identifier,
                sources,
                name,
                cache_folder() / "whole",
                flags=["-DW=1", *QUIET],
            )
            place = f"binaries/{platform.fmi2_folder}/{library.name}"
            slices.setdefault(place, {})[name] = library.read_bytes()
        for place, parts in slices.items():
            several = len(parts) > 1
            found[place] = (
                universal_binary(parts) if several else next(iter(parts.values()))
            )
        return found

    def description(self, guid: str) -> bytes:
        return describe(self.composition, self.identifier, self.outside, guid)

    @property
    def identifier(self) -> str:
        name = self.composition.system.name.rpartition("/")[2]
        plain = "".join(c if c.isalnum() and c.isascii() else "_" for c in name)
        return plain if plain[:1].isalpha() else f"_{plain}"

    def _outputs(self) -> Iterator[Outside]:
        for columns in self.timetable.wiring.tables.values():
            for column in columns:
                component, _ = split_name(column.name)
                part = self.timetable.wiring.parts[component]
                found = ports(part.component, part.fmu, column.name.partition(".")[2])
                yield Outside(
                    column.name,
                    "output",
                    f"vector[{column.index}]",
                    column.affine,
                    column.unit,
                    found[0].variable.sort == "boolean",
                    None,
                    found[0].variable.description,
                )

    def _inputs(self) -> Iterator[Outside]:
        for full in self.inputs:
            component, name = split_name(full)
            parts = self.timetable.wiring.parts
            if component not in parts or not name:
                remedy = did_you_mean(component, parts)
                raise ScenarioError(
                    f"--inputs {full}: no component {component!r}; {remedy}"
                )
            part = parts[component]
            (port, *more) = ports(part.component, part.fmu, name)
            if port.variable.causality != "input" or more:
                raise ScenarioError(
                    f"--inputs {full}: is no single input of {component}"
                )
            late = kind_of(part.component, part.fmu) == "sampled"
            when = "read an outer step late" if late else "acts from the step it is set"
            place = port.variable.reference + port.element
            inside = float(self.starts[component][place])
            yield Outside(
                full,
                "input",
                f"values_{self.source.own[component].index}[{place}]",
                port.to_theirs,
                port.unit,
                port.variable.sort == "boolean",
                _outer(inside, port.to_theirs),
                f"{port.variable.description} ({when})",
            )

    def _parameters(self) -> Iterator[Outside]:
        for name, own in self.source.own.items():
            for v in own.part.fmu.variables.values():
                if v.causality != "parameter" or v.variability == "constant":
                    continue
                for i in range(v.size):
                    place = v.reference + i
                    index = f"[{i + 1}]" if v.shape else ""
                    yield Outside(
                        f"{name}.{v.name}{index}",
                        "parameter",
                        f"values_{own.index}[{place}]",
                        Affine(),
                        v.unit,
                        v.sort == "boolean",
                        float(self.starts[name][place]),
                        v.description,
                    )


def _outer(inside: float, affine: Affine) -> float:
    return (inside - affine.offset) / affine.gain if affine.converts else inside
