"""Parameter sets and mappings that are bound to an element, inside or by a source."""

import re
from collections.abc import Iterator, Mapping
from math import isfinite
from pathlib import Path
from typing import Any

from lxml import etree

from fmus.unit_names import BASE
from fmus.units import BaseUnit, UnitError
from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.package import inside
from orchestrator.exchange.ssp.records import (
    Binding,
    Given,
    Looked,
    Mapped,
    Transformation,
)
from orchestrator.exchange.ssp.xml import NAMESPACES, local
from orchestrator.quantities.unit import Unit, unit_of_fmu


def parse(file: Path) -> Any:
    """Return the root of an XML file, which may neither fetch nor expand anything.

    Raises:
        ScenarioError: it is no XML.
    """
    parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=False)
    try:
        return etree.fromstring(file.read_bytes(), parser)
    except etree.XMLSyntaxError as error:
        raise ScenarioError(f"{file.name}: is no XML: {error}") from None


class Bindings:
    """What is bound to elements of one description.

    ``faults`` and ``notes`` are the reader's, which grow.
    """

    def __init__(
        self, file: Path, root: Path, document: Any, faults: list[str], notes: list[str]
    ) -> None:
        self.file, self.root, self.document = file, root, document
        self.faults, self.notes = faults, notes

    def of(self, element: Any, where: str, fmu: Path | None) -> tuple[Binding, ...]:
        found = []
        listed = element.iterfind(
            "ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES
        )
        for one in listed:
            try:
                if binding := self.binding(one, where, fmu):
                    found.append(binding)
            except ScenarioError as error:
                self.faults.append(f"{where}: parameters: {error}")
        return tuple(found)

    def binding(self, element: Any, where: str, fmu: Path | None) -> Binding | None:
        type_ = element.get("type") or "application/x-ssp-parameter-set"
        if type_ != "application/x-ssp-parameter-set":
            raise ScenarioError(f"a binding of type {type_} is not read")
        held = element.find("ssd:ParameterValues/ssv:ParameterSet", NAMESPACES)
        found = self.content(element, held, "ParameterSet", fmu)
        if found is None:
            self.notes.append(f"{where}: a binding without parameters")
            return None
        given = self.all_given(found, element.get("prefix", ""))
        of_map = element.find("ssd:ParameterMapping", NAMESPACES)
        if of_map is None:
            return Binding(where, given)
        held = of_map.find("ssm:ParameterMapping", NAMESPACES)
        mapping = self.content(of_map, held, "ParameterMapping", fmu)
        if mapping is None:
            return Binding(where, given)
        entries = tuple(self.entries(mapping, where))
        return Binding(where, given, entries)

    def of_file(self, file: Path, where: str) -> Binding:
        """Return a parameter set that somebody names beside the description.

        Raises:
            ScenarioError: it is none.
        """
        try:
            document = parse(file)
        except OSError as error:
            raise ScenarioError(f"{where}: cannot be read ({error.strerror})") from None
        if local(document) != "ParameterSet":
            raise ScenarioError(f"{where}: is no ParameterSet but {local(document)!r}")
        return Binding(where, self.all_given(document, ""))

    def all_given(self, document: Any, prefix: str) -> tuple[Given, ...]:
        units = {**unit_definitions(self.document), **unit_definitions(document)}
        return tuple(self.given(one, prefix, units) for one in _parameters(document))

    def content(
        self, element: Any, held: Any, wanted: str, fmu: Path | None
    ) -> Any | None:
        """Return the document that stands inside, or that a source names."""
        source = element.get("source") or ""
        if not source:
            return held
        if element.get("sourceBase") == "component":
            raise ScenarioError(
                f"source {source!r} lies inside the component; put it "
                f"beside the description"
            )
        document = parse(inside(self.root, self.file.parent, source))
        if local(document) != wanted:
            raise ScenarioError(f"source {source!r} is no {wanted}")
        return document

    def given(self, one: Any, prefix: str, units: Mapping[str, BaseUnit]) -> Given:
        name = prefix + one.get("name", "")
        for child in one:
            kind = local(child)
            if kind in ("", "Annotations", "Dimension"):
                continue
            inner = [v.get("value", "") for v in child if local(v) == "Value"]
            text = child.get("value")
            words = tuple(inner) if text is None else (text,)
            if text is not None and kind not in ("String", "Enumeration", "Binary"):
                words = tuple(text.split())
            return Given(name, kind, words, unit_named(child.get("unit"), units))
        raise ScenarioError(f"{name}: has no value")

    def entries(self, mapping: Any, where: str) -> Iterator[Mapped]:
        empty = 0
        for one in mapping.iterfind("ssm:MappingEntry", NAMESPACES):
            source, target = one.get("source", ""), one.get("target", "")
            if not source or not target:
                empty += 1
                continue
            told = f"{where}: {source} -> {target}"
            yield Mapped(
                source, target, transformation(one, told, self.faults), suppresses(one)
            )
        if empty:
            self.notes.append(
                f"{where}: {empty} entries of the mapping have no source: nothing is "
                f"set by them"
            )


def transformation(
    element: Any, where: str, faults: list[str]
) -> Transformation | None:
    """Return the transformation of a connection or of an entry of a mapping."""
    for child in element:
        kind = local(child)
        if kind == "LinearTransformation":
            words = child.get("factor", "1"), child.get("offset", "0")
            if all(map(_is_number, words)):
                return words
            faults.append(f"{where}: {' and '.join(words)} are no numbers")
        elif kind.endswith("MappingTransformation"):
            listed = (e for e in child if local(e) == "MapEntry")
            pairs = tuple((e.get("source", ""), e.get("target", "")) for e in listed)
            if len({source for source, _ in pairs}) < len(pairs) or not pairs:
                faults.append(f"{where}: {kind} maps a value twice, or none")
            return Looked(kind.removesuffix("MappingTransformation"), pairs)
        elif kind.endswith("Transformation"):
            faults.append(f"{where}: {kind} is none of SSP's; remove it")
    return None


def unit_named(name: str | None, units: Mapping[str, BaseUnit]) -> Unit | None:
    """Return a unit with its definition; "[m]" is read as "m" where it has none."""
    if not name:
        return None
    bare = name
    if name not in units and (match := re.fullmatch(r"\[(.*)\]", name)):
        bare = match[1]
    try:
        return unit_of_fmu(bare, units.get(bare))
    except UnitError:
        return Unit(bare)


def _parameters(document: Any) -> Iterator[Any]:
    yield from document.iterfind("ssv:Parameters/ssv:Parameter", NAMESPACES)


def suppresses(element: Any) -> bool:
    return element.get("suppressUnitConversion", "false") in ("true", "1")


def _is_number(word: str) -> bool:
    try:
        return isfinite(float(word))
    except ValueError:
        return False


def unit_definitions(document: Any) -> dict[str, BaseUnit]:
    """Return the units that a document defines; a factor of zero defines nothing.

    Raises:
        ScenarioError: a definition is none of numbers.
    """
    found = {}
    for unit in document.iterfind("{*}Units/{*}Unit"):
        base = unit.find("{*}BaseUnit")
        if base is None:
            continue
        try:
            exponents = {name: int(base.get(name, "0")) for name in BASE}
            factor = float(base.get("factor", "1"))
            offset = float(base.get("offset", "0"))
        except ValueError as error:
            raise ScenarioError(f"the unit {unit.get('name')!r}: {error}") from None
        if factor and isfinite(factor) and isfinite(offset):
            found[unit.get("name")] = BaseUnit(
                **exponents, factor=factor, offset=offset
            )
    return found
