"""What an FMU says of itself, for FMI 2.0 and 3.0 alike.

Read with fmpy; from our own FMUs also the exact sample period and whether the
model is continuous or sampled (``extra/org.feeddrive``; before, an annotation).
Units come from the FMU's own definitions.
"""

import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Literal

from fmus.units import BaseUnit
from orchestrator.errors import FmuError, did_you_mean
from orchestrator.fmu.archive import checked_members, read_member
from orchestrator.fmu.clocks import Clock, clocks_of, ticked
from orchestrator.fmu.declared import (
    Declared,
    declared,
    refuse_ambiguous,
    refuse_other_fmi,
    refuse_two_descriptions,
    refuse_vast,
    units,
)
from orchestrator.fmu.own import kind_and_period
from orchestrator.quantities.quantity import exact
from orchestrator.quantities.unit import Unit, unit_of_fmu
from orchestrator.system import Kind

Sort = Literal["real", "integer", "boolean", "string", "binary"]
Dtype = Literal["float64", "int64", "uint64"]

_TYPES = {
    2: {"Real", "Integer", "Boolean", "String", "Enumeration"},
    3: {"Float32", "Float64", "Boolean", "String", "Binary", "Enumeration", "Clock"}
    | {f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)},
}
_SORTS: dict[str, Sort] = {
    "Real": "real",
    "Float64": "real",
    "Float32": "real",
    "Boolean": "boolean",
    "String": "string",
    "Binary": "binary",
}
_WORDS: dict[str, Dtype] = {
    "Int64": "int64",
    "UInt64": "uint64",
    "Enumeration": "int64",
}


@dataclass(frozen=True)
class FmuVariable:
    """One variable; ``references`` has one entry per FMI 2 scalar or FMI 3 array.

    ``size`` counts its numbers; ``unit`` is the FMU's own, ``base_unit`` its
    definition as written (None where the FMU gives none).  ``declared`` is what it or
    its type says besides.
    """

    name: str
    fmi_type: str
    reference: int
    shape: tuple[int, ...]
    causality: str
    variability: str
    initial: str | None
    unit: Unit | None
    base_unit: BaseUnit | None
    start: str | None
    min: str | None
    max: str | None
    description: str
    declared: Declared
    dtype: Dtype = "float64"  # by which its numbers lie in the master's vector

    @property
    def sort(self) -> Sort:
        return _SORTS.get(self.fmi_type, "integer")

    @property
    def is_text(self) -> bool:
        """Whether its values are no numbers: they are set and travel, no more."""
        return self.sort in ("string", "binary")

    @property
    def kind(self) -> str:
        """What it is in words, for messages."""
        return f"{'an' if self.fmi_type[0] in 'EIU' else 'a'} {self.fmi_type}"

    @property
    def size(self) -> int:
        count = 1
        for n in self.shape:
            count *= n
        return count


@dataclass(frozen=True)
class FmuDescription:
    """An FMU's model description, as far as a co-simulation needs it.

    ``dependencies`` maps every output to the inputs it depends on directly
    while stepping, ``initial_dependencies`` in initialisation; None means all.
    ``internal_step`` (s) is what communication steps should be a multiple of.
    ``gets_state``: its state can be got and set, ``saves_state``: written down too.
    ``kind`` and ``period`` are None where the FMU does not say.  ``clock`` is the
    reference of the input clock with that period, by which it is ticked.  ``units`` are
    definitions of all units it names.
    """

    path: Path
    fmi_major: int
    model_name: str
    model_identifier: str
    token: str
    tool: str
    description: str
    variables: Mapping[str, FmuVariable]
    clocks: Mapping[str, Clock]
    units: Mapping[str, BaseUnit]
    dependencies: Mapping[str, frozenset[str] | None]
    initial_dependencies: Mapping[str, frozenset[str] | None]
    variable_step: bool
    internal_step: Fraction | None
    needs_execution_tool: bool
    gets_state: bool
    saves_state: bool
    once_per_process: bool
    co_simulation: bool
    model_exchange: bool
    platforms: tuple[str, ...]
    clock: int | None
    kind: Kind | None
    period: Fraction | None
    default_step: float | None
    default_start: float | None
    log_categories: tuple[str, ...]

    def __getitem__(self, name: str) -> FmuVariable:
        try:
            return self.variables[name]
        except KeyError:
            raise FmuError(
                f"{self.path}: has no variable {name!r}; "
                f"{did_you_mean(name, self.variables)}"
            ) from None

    @property
    def says_it_is_ours(self) -> bool:
        """Whether it has what our exporter writes; anybody can write that."""
        return self.kind is not None

    @cached_property
    def inputs(self) -> tuple[str, ...]:
        return tuple(n for n, v in self.variables.items() if v.causality == "input")

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        return tuple(n for n, v in self.variables.items() if v.causality == "output")

    def feeds_through(self, name: str) -> bool:
        """Tell whether some output depends directly on this input while stepping;
        dependencies on parameters are not declared and count as there."""
        return self._feeds(name, self.dependencies)

    def feeds_through_initially(self, name: str) -> bool:
        """Tell the same of initialisation; unlisted outputs depend on everything."""
        return self._feeds(name, self.initial_dependencies)

    def _feeds(self, name: str, said: Mapping[str, frozenset[str] | None]) -> bool:
        declared = [said.get(output) for output in self.outputs]
        is_input = self.variables[name].causality == "input"
        return not is_input or any(d is None or name in d for d in declared)


def read_fmu(path: str | Path) -> FmuDescription:
    """Read the model description of an FMU file.

    Raises:
        FmuError: the file is missing, damaged, unsafe, or not FMI 2.0 or 3.0.
    """
    file = Path(path)
    try:
        stamp = file.stat()
    except (OSError, ValueError):
        raise FmuError(f"{file}: no such file; give the path of an .fmu file") from None
    return _read(file, stamp.st_mtime_ns, stamp.st_size)


@lru_cache(maxsize=256)
def _read(path: Path, _mtime: int, _size: int) -> FmuDescription:
    import fmpy
    from lxml import etree

    refuse_two_descriptions(path)
    text = read_member(path, "modelDescription.xml")
    try:
        # comments may stand anywhere, also where a first child is looked for
        parser = etree.XMLParser(remove_comments=True, remove_pis=True)
        root = etree.fromstring(text, parser)
        refuse_other_fmi(path, root)
        refuse_ambiguous(path, root)
        bare = _only_xml(etree.tostring(root))
        md = fmpy.read_model_description(io.BytesIO(bare), validate=False)
        return _described(path, root, md)
    except Exception as error:  # fmpy raises bare Exception for malformed documents
        if isinstance(error, FmuError):
            raise
        raise FmuError(
            f"{path}: modelDescription.xml cannot be understood ({error}); "
            f"run `fmpy validate` on it and ask its supplier"
        ) from None


def _described(path: Path, root: Any, md: Any) -> FmuDescription:
    major = int(str(md.fmiVersion)[0])
    for v in md.modelVariables:
        if v.type not in _TYPES[major]:
            raise FmuError(
                f"{path}: variable {v.name!r} is of type {v.type}, which is none of "
                f"FMI {major}; ask its supplier for a valid modelDescription.xml"
            )
    refuse_vast(path, md)
    kind, period = kind_and_period(path, root)
    clocks = clocks_of(root)
    clock = None if kind == "continuous" else ticked(clocks, root)
    if clock is not None and kind is None:
        period = clock.period
    cs = md.coSimulation
    interface = cs or md.modelExchange
    names = {v.name for v in md.modelVariables}
    defined, said = dict(units(md.unitDefinitions)), declared(root)
    return FmuDescription(
        path=path,
        fmi_major=major,
        model_name=md.modelName or path.stem,
        model_identifier=interface.modelIdentifier if interface else "",
        token=md.guid,
        tool=md.generationTool or "unknown",
        description=md.description or "",
        variables={
            v.name: _variable(v, defined, said, major)
            for v in md.modelVariables
            if v.type != "Clock"
        },
        clocks=clocks,
        units=defined,
        dependencies=_dependencies(md.outputs, names),
        initial_dependencies=_dependencies(md.initialUnknowns, names),
        variable_step=cs is None or bool(cs.canHandleVariableCommunicationStepSize),
        internal_step=_internal_step(root),
        needs_execution_tool=bool(interface and interface.needsExecutionTool),
        gets_state=bool(cs and cs.canGetAndSetFMUstate),
        saves_state=bool(cs and cs.canSerializeFMUstate),
        once_per_process=bool(
            interface and interface.canBeInstantiatedOnlyOncePerProcess
        ),
        co_simulation=cs is not None,
        model_exchange=md.modelExchange is not None,
        platforms=_platforms(path),
        clock=clock.reference if clock else None,
        kind=kind,
        period=period,
        default_step=_number(getattr(md.defaultExperiment, "stepSize", None)),
        default_start=_number(getattr(md.defaultExperiment, "startTime", None)),
        log_categories=tuple(c.get("name", "") for c in root.iter("Category")),
    )


def _internal_step(root: Any) -> Fraction | None:
    for element in root.iter("CoSimulation"):
        written = element.get("fixedInternalStepSize")
        if written and float(written) > 0:
            return exact(written)
    return None


def _only_xml(text: bytes) -> bytes:
    """Return an archive holding the description alone, as fmpy wants one."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        archive.writestr("modelDescription.xml", text)
    return memory.getvalue()


def _variable(
    v: Any, defined: Mapping[str, BaseUnit], told: Mapping[str, Declared], major: int
) -> FmuVariable:
    """Return a variable, or an alias of one (FMI 3.0), which is read and never set."""
    said = told[v.name] if v.alias is None else replace(told[v.alias.name], starts=())
    type_ = v.declaredType
    name: str | None = v.unit or (type_.unit if type_ is not None else None)
    base = defined.get(name or "") or (BaseUnit() if name == "1" else None)
    unit = unit_of_fmu(name, base, relative=said.relative) if name else None
    return FmuVariable(
        name=v.name,
        fmi_type=v.type,
        reference=int(v.valueReference),
        shape=tuple(v.shape or ()),
        causality=v.causality or "local" if v.alias is None else "local",
        variability=v.variability or "continuous",
        initial=v.initial if v.alias is None else None,
        unit=unit,
        base_unit=base,
        start=v.start if v.alias is None else None,
        min=said.min,
        max=said.max,
        description=v.description or "",
        declared=said,
        dtype=_WORDS.get(v.type, "float64") if major == 3 else "float64",
    )


def _dependencies(
    unknowns: list[Any], names: set[str]
) -> dict[str, frozenset[str] | None]:
    found: dict[str, frozenset[str] | None] = {}
    for unknown in unknowns:
        if unknown.variable is None or unknown.variable.name not in names:
            continue
        declared = unknown.dependencies
        found[unknown.variable.name] = (
            None if declared is None else frozenset(d.name for d in declared)
        )
    return found


def _platforms(path: Path) -> tuple[str, ...]:
    folders = set()
    for member in checked_members(path):
        parts = member.filename.split("/")
        if len(parts) > 2 and parts[0] == "binaries" and parts[2]:
            folders.add(parts[1])
    return tuple(sorted(folders))


def _number(text: Any) -> float | None:
    return None if text in (None, "") else float(text)
