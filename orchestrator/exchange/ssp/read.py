"""Reading a system structure description into records, with everything it refers to.

What cannot be run is collected and named at once; only a file that is no such
document ends the reading.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from zipfile import is_zipfile

from lxml import etree

from fmus.units import BaseUnit
from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.bindings import (
    Bindings,
    parse,
    suppresses,
    transformation,
    unit_definitions,
    unit_named,
)
from orchestrator.exchange.ssp.package import description, inside, unpack
from orchestrator.exchange.ssp.records import (
    Connection,
    Connector,
    End,
    Nested,
    Part,
    Reference,
    Structure,
    Timing,
)
from orchestrator.exchange.ssp.xml import FMU_TYPE, NAMESPACES, OURS, local
from orchestrator.quantities.quantity import exact
from orchestrator.quantities.unit import Unit

_STEPS = {  # elements of annotations that say a step, and the attribute that does
    "FixedStepMaster": "stepSize",  # OMSimulator, the earlier OSP
    "FixedStepAlgorithm": "baseStepSize",  # OSP
    "StepSizeHint": "value",  # OSP, Vico, Ecos
}
_DEEPEST = 32  # systems inside one another


def read_structure(
    file: Path, root: Path, unpacked: Path, ssv: Sequence[Path] = ()
) -> Structure:
    """Return what a description says; ``root`` is the folder of its package.

    ``unpacked`` takes packages that lie inside this one.  ``ssv`` are parameter sets
    that are bound to the whole system, after its own.

    Raises:
        ScenarioError: the file is no system structure description, or one of the
            parameter sets is none.
    """
    return _Reader(file, root, unpacked, ()).structure(ssv)


class _Reader:
    def __init__(
        self, file: Path, root: Path, unpacked: Path, outer: tuple[Path, ...]
    ) -> None:
        self.file, self.root, self.unpacked = file, root, unpacked
        self.outer = (*outer, file.resolve())
        self.faults: list[str] = []
        self.notes: list[str] = []
        self.document = parse(file)
        if local(self.document) != "SystemStructureDescription":
            raise ScenarioError(
                f"{file.name}: is no system structure description but "
                f"{local(self.document)!r}"
            )
        self.units = unit_definitions(self.document)
        self.bindings = Bindings(file, root, self.document, self.faults, self.notes)
        self.ids = {e.get("id"): e for e in self.document.iter() if e.get("id")}

    def structure(self, ssv: Sequence[Path]) -> Structure:
        of_system = self.document.find("ssd:System", NAMESPACES)
        if of_system is None:
            raise ScenarioError(f"{self.file.name}: holds no System")
        experiment = self.document.find("ssd:DefaultExperiment", NAMESPACES)
        told = {} if experiment is None else dict(experiment.attrib)
        step = None if experiment is None else self._step(experiment)
        system = self.system(of_system, (), step)
        bound = tuple(self.bindings.of_file(one, f"--ssv {one.name}") for one in ssv)
        system = replace(system, bindings=(*system.bindings, *bound))
        return Structure(
            self.document.get("name") or self.file.stem,
            self.document.get("version", ""),
            system,
            told.get("startTime"),
            told.get("stopTime"),
            self._timing(),
            tuple(self.faults),
            tuple(self.notes),
            root=self.document,
        )

    def _timing(self) -> Timing | None:
        for annotation in self.document.iter("{*}Annotation"):
            if annotation.get("type") == OURS and len(annotation):
                timing = annotation[0]
                each = {c.get("name"): dict(c.attrib) for c in timing}
                return Timing(timing.get("stop"), timing.get("scenario"), each)
        return None

    def _step(self, element: Any) -> str | None:
        """Return the step that an element's own annotations say."""
        for annotation in element.iterfind("ssd:Annotations/*", NAMESPACES):
            for one in annotation.iter():
                key = _STEPS.get(local(one))
                written = one.get(key) if key else None
                if written is None:
                    continue
                try:
                    if exact(written) > 0:
                        return str(written)
                except (ValueError, ZeroDivisionError):
                    pass
                self.faults.append(
                    f"{element.get('name')}: {key} = {written!r} of an annotation is "
                    f"no step"
                )
        return None

    def system(self, element: Any, path: tuple[str, ...], step: str | None) -> Nested:
        step = self._step(element) or step
        where = "/".join(path) or element.get("name", "")
        elements: dict[str, Part | Nested | Reference] = {}
        for child in element.iterfind("ssd:Elements/*", NAMESPACES):
            name, kind = child.get("name", ""), local(child)
            if not kind:
                continue
            place = (*path, name)
            if name in elements:
                self.faults.append(f"{'/'.join(place)}: two elements have this name")
            elif kind == "System":
                elements[name] = self.system(child, place, step)
            elif kind == "Component":
                elements[name] = self.component(child, place, step)
            else:
                about = child.get("dictionary", "")
                connectors = self.connectors(child, "/".join(place))
                elements[name] = Reference(name, about, connectors)
        connections = element.iterfind("ssd:Connections/ssd:Connection", NAMESPACES)
        return Nested(
            element.get("name", ""),
            self.connectors(element, where),
            self.bindings.of(element, where, None),
            elements,
            tuple(self.connection(one, where) for one in connections),
            step,
            element.get("description", ""),
            self.dictionaries(element, where),
        )

    def dictionaries(self, element: Any, where: str) -> dict[str, dict[str, Connector]]:
        """Return the signals of each dictionary of a system."""
        found: dict[str, dict[str, Connector]] = {}
        path = "ssd:SignalDictionaries/ssd:SignalDictionary"
        for one in element.iterfind(path, NAMESPACES):
            name = one.get("name", "")
            held = next((c for c in one if local(c) == "SignalDictionary"), None)
            try:
                document = self.bindings.content(one, held, "SignalDictionary", None)
                if name in found or document is None:
                    raise ScenarioError(
                        "is there twice" if name in found else "is empty"
                    )
            except ScenarioError as error:
                self.faults.append(f"{where}: signal dictionary {name}: {error}")
                continue
            units = {**self.units, **unit_definitions(document)}
            found[name] = {
                entry.get("name", ""): Connector(
                    entry.get("name", ""), "inout", *typed(entry, units)
                )
                for entry in document
                if local(entry) == "DictionaryEntry"
            }
        return found

    def connectors(self, element: Any, where: str) -> dict[str, Connector]:
        found: dict[str, Connector] = {}
        for one in element.iterfind("ssd:Connectors/ssd:Connector", NAMESPACES):
            name, kind = one.get("name", ""), one.get("kind", "")
            if name in found:
                self.faults.append(f"{where}: two connectors have the name {name!r}")
            found[name] = Connector(name, kind, *typed(one, self.units))
        return found

    def component(
        self, element: Any, path: tuple[str, ...], step: str | None
    ) -> "Part | Nested":
        where, source = "/".join(path), element.get("source") or ""
        type_ = element.get("type") or FMU_TYPE
        step = self._step(element) or step
        fmu = None
        base = self.file.parent
        if source.startswith("#"):
            target = self.ids.get(source[1:])
            if target is not None and local(target) == "System" and len(path) < 32:
                return self.instance(element, self.system(target, path, step), where)
            self.faults.append(f"{where}: no system here has the id {source[1:]!r}")
        elif type_ in ("application/x-ssp-package", "application/x-ssp-definition"):
            if (nested := self.referred(element, path, step, source)) is not None:
                return nested
        elif type_ != FMU_TYPE:
            self.faults.append(f"{where}: is of type {type_}, and only FMUs are run")
        elif not source:
            self.faults.append(f"{where}: has no source; name its FMU there")
        else:
            try:
                fmu = inside(self.root, base, source)
            except ScenarioError as error:
                self.faults.append(f"{where}: {error}")
        return Part(
            element.get("name", ""),
            self.connectors(element, where),
            self.bindings.of(element, where, fmu),
            fmu,
            element.get("implementation", "any"),
            step,
            element.get("description", ""),
        )

    def instance(self, element: Any, system: Nested, where: str) -> Nested:
        """Return a system in the place of a component that refers to it."""
        own = self.bindings.of(element, where, None)
        return Nested(
            element.get("name", ""),
            system.connectors,
            (*system.bindings, *own),
            system.elements,
            system.connections,
            system.step,
            element.get("description", "") or system.description,
            system.dictionaries,
        )

    def referred(
        self, element: Any, path: tuple[str, ...], step: str | None, source: str
    ) -> Nested | None:
        where = "/".join(path)
        name, _, variant = source.partition("#")
        try:
            file = inside(self.root, self.file.parent, name)
            root = self.root
            if is_zipfile(file):
                root = self.unpacked / "_".join(path)
                root.mkdir(parents=True, exist_ok=True)
                file = description(file, unpack(file, root), variant or None)
            if file.resolve() in self.outer or len(self.outer) > _DEEPEST:
                raise ScenarioError(f"source {source!r} is a system that holds itself")
            inner = _Reader(file, root, self.unpacked, self.outer)
            of_system = inner.document.find("ssd:System", NAMESPACES)
            if of_system is None:
                raise ScenarioError(f"source {source!r} holds no System")
            found = inner.system(of_system, path, step)
        except ScenarioError as error:
            self.faults.append(f"{where}: {error}")
            return None
        self.faults += inner.faults
        self.notes += inner.notes
        return self.instance(element, found, where)

    def connection(self, element: Any, where: str) -> Connection:
        start = End(element.get("startElement"), element.get("startConnector", ""))
        end = End(element.get("endElement"), element.get("endConnector", ""))
        told = f"{where}: {_told(start)} -> {_told(end)}"
        if element.get("startIndices") or element.get("endIndices"):
            self.faults.append(
                f"{told}: connects elements of arrays, of which SSP does not say from "
                f"which number it counts them"
            )
        how = transformation(element, told, self.faults)
        return Connection(start, end, how, suppresses(element), told)


def typed(element: Any, units: Mapping[str, BaseUnit]) -> tuple[str, Unit | None]:
    """Return the type and unit that an element has inside, "" and None if none."""
    found: tuple[str, Unit | None] = "", None
    for child in element:
        if isinstance(child.tag, str) and (
            etree.QName(child).namespace == NAMESPACES["ssc"]
            and local(child) not in ("Dimension", "Annotations")
        ):
            found = local(child), unit_named(child.get("unit"), units)
    return found


def _told(end: End) -> str:
    return f"{end.element}.{end.connector}" if end.element else end.connector
