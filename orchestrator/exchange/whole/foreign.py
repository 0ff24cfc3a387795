"""FMUs of others inside a composition: which can be, their C, their files.

They are called as the kernel calls them, from C that lies in the library, and loaded
from ``resources/<component>`` beside it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from fmus.compile import PLATFORMS
from fmus.trust import is_trusted
from orchestrator.errors import ScenarioError
from orchestrator.exchange.whole.tables import Outside
from orchestrator.fmu.archive import checked_members, read_member
from orchestrator.fmu.description import FmuVariable
from orchestrator.fmu.ports import Affine
from orchestrator.master.fused.source import Source
from orchestrator.master.layout import Part
from orchestrator.master.timetable import Op, Timetable

TYPES = {
    "Real": "REAL",
    "Integer": "INTEGER",
    "Enumeration": "INTEGER",
    "Boolean": "BOOLEAN",
    "Float64": "FLOAT64",
}
SHOWN = ("Real", "Float64", "Boolean")  # parameters that an importer may set


@dataclass(frozen=True)
class Given:
    """A value of a foreign FMU before initialisation, in its place of the memory."""

    variable: FmuVariable
    start: float
    given: bool


@dataclass(frozen=True)
class Foreign:
    """One of them; ``inputs`` are those that come from outside the composition."""

    index: int
    number: int  # among all components
    part: Part
    folder: str
    inputs: tuple[FmuVariable, ...]

    @property
    def values(self) -> tuple[Given, ...]:
        """Return what is written before initialisation, and what could be."""
        found = {
            variable.name: Given(variable, float(value), True)
            for variable, values in self.part.start
            for value in values
        }
        for v in self.part.fmu.variables.values():
            free = v.causality == "parameter" and v.variability != "constant"
            if free and v.fmi_type in SHOWN and not v.shape and v.start is not None:
                found.setdefault(v.name, Given(v, _number(v), False))
        return tuple(found.values())

    def starts(self) -> NDArray[np.float64]:
        """Return the numbers of its places of the memory."""
        given = {v.name: float(values[0]) for v, values in self.part.start}
        ends = [given.get(v.name, _number(v)) for v in self.inputs]
        return np.array([value.start for value in self.values] + ends, dtype=float)

    def parameters(self) -> Iterator[Outside]:
        """Yield those an importer may set."""
        for i, value in enumerate(self.values):
            v = value.variable
            if v.causality == "parameter" and v.fmi_type in SHOWN:
                yield Outside(
                    f"{self.part.name}.{v.name}",
                    "parameter",
                    f"values_{self.number}[{i}]",
                    Affine(),
                    v.unit,
                    v.sort == "boolean",
                    value.start,
                    v.description,
                )

    def slot(self, name: str) -> int:
        """Return the place of an input from outside."""
        return len(self.values) + [v.name for v in self.inputs].index(name)


def foreign_parts(
    timetable: Timetable, whys: Mapping[str, str], inputs: Mapping[str, set[str]]
) -> dict[str, Foreign]:
    """Return the foreign FMUs among the components that are not compiled in.

    ``inputs`` are the FMU's names of those from outside, by component.

    Raises:
        ScenarioError: one can be neither compiled in nor carried along.
    """
    found: dict[str, Foreign] = {}
    told = []
    folders: dict[str, str] = {}
    for number, (name, part) in enumerate(timetable.wiring.parts.items()):
        if name not in whys:
            continue
        if why := _unfit(part, whys[name]):
            told.append(f"{name} {why}")
            continue
        folder = folders.setdefault(str(part.fmu.path), name)
        of = inputs.get(name, set())
        ends = tuple(v for v in part.inputs if v.name in of)
        found[name] = Foreign(len(found), number, part, folder, ends)
    if told:
        raise ScenarioError(f"this does not go into one FMU: {'; '.join(told)}")
    return found


def _unfit(part: Part, why: str) -> str | None:
    fmu, component = part.fmu, part.component
    if is_trusted(fmu.path):
        return why
    if component.isolation.process:
        return "is to run in a process of its own, which an FMU does not start"
    if not fmu.co_simulation:
        return "is for model exchange only, and inside nothing integrates it"
    if fmu.needs_execution_tool:
        return "needs its tool to run"
    if fmu.once_per_process:
        return "can be instantiated once per process only"
    if part.kind == "sampled":
        return "is sampled and not ours"
    if component.experiment.stop or component.experiment.tolerance is not None:
        return "is to be told a stop time or tolerance, which are the importer's"
    variables = [*part.inputs, *part.read, *(v for v, _ in part.start)]
    odd = next((v for v in variables if v.fmi_type not in TYPES), None)
    if odd is not None:
        return f"has {odd.name} connected, recorded or set, {odd.kind}"
    if any(len(values) > 1 for _, values in part.start):
        return "has an array set"
    if not all(c.is_exact or c.is_of_doubles for c in part.copies):
        return "feeds an integer of 64 bits, or one that a map rounds"
    return None


def states_of(found: Mapping[str, Foreign]) -> bool:
    """Tell whether the states of all can be got, written down and set."""
    return all(one.part.fmu.saves_state for one in found.values())


def carried(found: Mapping[str, Foreign], platforms: Sequence[str]) -> dict[str, bytes]:
    """Return the files of the foreign FMUs, for some platforms.

    Raises:
        ScenarioError: one has no binary for a platform.
    """
    files: dict[str, bytes] = {}
    for name, one in found.items():
        fmu = one.part.fmu
        kept = ["modelDescription.xml", "resources/"]
        for platform in platforms:
            kind = PLATFORMS[platform]
            folder = kind.fmi2_folder if fmu.fmi_major == 2 else kind.fmi3_folder
            if folder not in fmu.platforms:
                raise ScenarioError(
                    f"--platform {platform}: {name} ({fmu.path.name}) has no binary "
                    f"for it; it has {', '.join(fmu.platforms) or 'none'}"
                )
            kept.append(f"binaries/{folder}/")
        files |= {
            f"resources/{one.folder}/{member.filename}": read_member(
                fmu.path, member.filename
            )
            for member in checked_members(fmu.path)
            if member.filename.startswith(tuple(kept)) and member.filename[-1] != "/"
        }
    return files


class WholeSource(Source):
    """The C of a timetable with calls of foreign FMUs, without the kernel."""

    foreign: Mapping[str, Foreign]

    @property
    def whole(self) -> bool:
        return True

    def _models(self) -> Iterator[str]:
        yield f"#define N_FOREIGN {len(self.foreign)}"
        if self.foreign:
            states = states_of(self.foreign)
            yield f"#define FOREIGN_STATES {int(states)}"
            yield '#include "foreign.h"'
            yield '#include "foreign_states.h"'
            for one in self.foreign.values():
                yield from _table(one)
            heads = [_head(one) for one in self.foreign.values()]
            yield f"static const Foreign foreign[] = {{{', '.join(heads)}}};"
        yield from super()._models()

    def _call(self, op: Op) -> str:
        one, back = self.foreign[op.target], op.back
        here = f"foreign + {one.index}"
        if op.code == "advance":
            t = f"seconds_of(e, k - {back})"
            step = _or_fail(f"foreign_step(e, {here}, k, {t}, {op.h.hex()})")
            return "\n    ".join([*self._given(one), step])
        if op.code == "read":
            return _or_fail(f"foreign_read(e, {here}, k)")
        if op.code == "write":
            return "\n    ".join(self._written(one))
        return "\n    ".join(self._copied(one.part.copies))

    def _given(self, one: Foreign) -> Iterator[str]:
        """Write how what was set outside acts from the step on it was set for."""
        for v in one.inputs:
            value = f"e->parts[{one.number}].values + {one.slot(v.name)}"
            what = f"{TYPES[v.fmi_type]}, {v.reference}, {value}"
            yield _or_fail(f"foreign_give(e, foreign + {one.index}, k, {what})")

    def _written(self, one: Foreign, k: str = "k") -> Iterator[str]:
        place = one.part.first_input
        for v in one.part.inputs:
            if v in one.inputs:
                slot = one.slot(v.name)
                yield f"z[{place}] = e->parts[{one.number}].values[{slot}];"
            place += v.size
        yield _or_fail(f"foreign_write(e, foreign + {one.index}, {k})")

    def _entered(self, name: str) -> Iterator[str]:
        if name in self.own:
            yield from super()._entered(name)
        else:
            here = f"foreign + {self.foreign[name].index}"
            yield _or_fail(f"foreign_enter(e, {here})")

    def _evaluated(self, name: str) -> Iterator[str]:
        if name in self.own:
            yield from super()._evaluated(name)
        else:
            for line in (*self._written(self.foreign[name], "0"), *self._told(name)):
                yield line.replace("return 0;", "bad += NAN;")

    def _left(self, name: str) -> Iterator[str]:
        if name in self.own:
            yield from super()._left(name)
        else:
            yield from self._written(self.foreign[name], "0")
            yield _or_fail(f"foreign_leave(e, foreign + {self.foreign[name].index})")

    def _told(self, name: str) -> Iterator[str]:
        if name in self.own:
            yield from super()._told(name)
        else:
            yield _or_fail(f"foreign_read(e, foreign + {self.foreign[name].index}, 0)")


def _or_fail(call: str) -> str:
    return f"if (!{call}) return 0;"


def _table(one: Foreign) -> Iterator[str]:
    for ends, variables, first in (
        ("inputs", one.part.inputs, one.part.first_input),
        ("outputs", one.part.read, one.part.raw),
    ):
        groups = list[str]()
        for type_, same in groupby(variables, key=lambda v: TYPES[v.fmi_type]):
            of = list(same)
            size = sum(v.size for v in of)
            refs = ", ".join(str(v.reference) for v in of)
            name = f"{ends}_{one.index}_{len(groups)}"
            yield f"static const uint32_t {name}[] = {{{refs}}};"
            groups.append(f"{{{type_}, {len(of)}, {size}, {name}, {first}}}")
            first += size
        listed = ", ".join(groups or ["{0, 0, 0, 0, 0}"])
        yield f"static const Group {ends}_{one.index}[] = {{{listed}}};"
    values = [
        f"{{{TYPES[v.variable.fmi_type]}, {int(v.given)}, {v.variable.reference}, "
        f"{v.start.hex()}}}"
        for v in one.values
    ]
    listed = ", ".join(values or ["{0, 0, 0, 0}"])
    yield f"static const Given given_{one.index}[] = {{{listed}}};"


def _head(one: Foreign) -> str:
    fmu, i = one.part.fmu, one.index
    texts = (one.part.name, one.folder, fmu.model_identifier, fmu.token)
    n = [
        len(list(groupby(variables, key=lambda v: TYPES[v.fmi_type])))
        for variables in (one.part.inputs, one.part.read)
    ]
    fields = [
        *(f'"{text}"' for text in texts),
        *(str(number) for number in (fmu.fmi_major, one.number, i)),
        *(f"inputs_{i}", f"outputs_{i}", str(n[0]), str(n[1])),
        *(f"given_{i}", str(len(one.values))),
    ]
    return f"{{{', '.join(fields)}}}"


def _number(v: FmuVariable) -> float:
    if v.sort == "boolean":
        return float(v.start in ("true", "1"))
    return float(v.start or 0)
