"""ModelVariables and ModelStructure of a model description.

FMI 2 lists every element of an array as a scalar, whose index is its value
reference + 1; FMI 3 lists the array under the reference of its first element,
and the independent variable ``time`` after all others (reference
``layout.size``).
"""

from collections.abc import Iterable, Mapping

from lxml import etree

from fmus.layout import Layout, Variable
from fmus.model import Sampled
from fmus.quantities import bounds, nominal, quantity, shown
from fmus.structure import Kind, Structure, initial, stepping, strongest
from fmus.subject import CLOCK, Subject, role


def scalars(root: etree._Element, subject: Subject) -> None:
    """Write ModelVariables and ModelStructure of FMI 2."""
    layout = subject.layout
    parent = etree.SubElement(root, "ModelVariables")
    for variable in layout.variables:
        shared = _attributes(variable, subject)
        for offset, (name, reference) in enumerate(variable.elements()):
            head = {"name": name, "valueReference": str(reference)} | shared
            scalar = etree.SubElement(parent, "ScalarVariable", given(head))
            kind = "Boolean" if variable.boolean else "Real"
            real = _bounds(variable)
            if variable.start:
                real["start"] = _number(variable.start[offset], variable.boolean)
            if variable.of_state is not None:
                real["derivative"] = str(variable.of_state + offset + 1)
            etree.SubElement(scalar, kind, given(real))

    outputs = _elements(layout.block("output"))
    derivatives = _elements(layout.block("derivative"))
    structure = etree.SubElement(root, "ModelStructure")
    while_stepping = stepping(subject.traced, layout)
    at_start = initial(subject.traced, layout)
    for name, unknowns, table in (
        ("Outputs", outputs, while_stepping),
        ("Derivatives", derivatives, while_stepping),
        ("InitialUnknowns", outputs + derivatives, at_start),
    ):
        if not unknowns:
            continue
        group = etree.SubElement(structure, name)
        for unknown in sorted(unknowns):
            row = table.get(unknown, {})
            attributes = {"index": str(unknown + 1)} | _dependencies(
                {known + 1: kind for known, kind in row.items()},
                with_kinds=table is while_stepping,
            )
            etree.SubElement(group, "Unknown", attributes)


def _elements(variables: Iterable[Variable]) -> list[int]:
    return [reference for v in variables for _, reference in v.elements()]


def arrays(root: etree._Element, subject: Subject) -> None:
    """Write ModelVariables and ModelStructure of FMI 3."""
    layout = subject.layout
    parent = etree.SubElement(root, "ModelVariables")
    for variable in layout.variables:
        attributes = {"name": variable.name, "valueReference": str(variable.reference)}
        attributes |= given(_attributes(variable, subject) | _bounds(variable))
        if variable.start:
            numbers = (_number(v, variable.boolean) for v in variable.start)
            attributes["start"] = " ".join(numbers)
        if variable.of_state is not None:
            attributes["derivative"] = str(variable.of_state)
        kind = "Boolean" if variable.boolean else "Float64"
        element = etree.SubElement(parent, kind, attributes)
        for n in variable.shape:
            etree.SubElement(element, "Dimension", start=str(n))
    time = {"name": "time", "valueReference": str(layout.size), "unit": "s"}
    time |= {"causality": "independent", "variability": "continuous"}
    etree.SubElement(parent, "Float64", time, description="simulation time")
    if subject.clocked and isinstance(subject.model, Sampled):
        _clock(parent, subject.model, layout.size + 1)

    outputs, derivatives = layout.block("output"), layout.block("derivative")
    structure = etree.SubElement(root, "ModelStructure")
    while_stepping = _per_variable(stepping(subject.traced, layout), layout)
    at_start = _per_variable(initial(subject.traced, layout), layout)
    for name, unknowns, table in (
        ("Output", outputs, while_stepping),
        ("ContinuousStateDerivative", derivatives, while_stepping),
        ("InitialUnknown", outputs + derivatives, at_start),
    ):
        for unknown in unknowns:
            row = table.get(unknown.reference, {})
            attributes = {"valueReference": str(unknown.reference)}
            attributes |= _dependencies(row, with_kinds=table is while_stepping)
            etree.SubElement(structure, name, attributes)


def _clock(parent: etree._Element, model: Sampled, reference: int) -> None:
    """Write the input clock by which an importer with event mode ticks a model."""
    num, den = model.period.as_integer_ratio()
    attributes = {
        "name": CLOCK,
        "valueReference": str(reference),
        "causality": "input",
        "intervalVariability": "constant",
        "intervalDecimal": repr(num / den),
        "supportsFraction": "true",
        "resolution": str(den),
        "intervalCounter": str(num),
    }
    text = "ticks the model where event mode is used"
    etree.SubElement(parent, "Clock", attributes, description=text)


def _per_variable(table: Structure, layout: Layout) -> Structure:
    """Merge the dependencies of elements into those of whole arrays."""
    first = {r: v.reference for v in layout.variables for _, r in v.elements()}
    merged: dict[int, dict[int, set[Kind]]] = {}
    for unknown, row in table.items():
        target = merged.setdefault(first[unknown], {})
        for known, kind in row.items():
            target.setdefault(first[known], set()).add(kind)
    return {
        unknown: {known: strongest(kinds) for known, kinds in sorted(row.items())}
        for unknown, row in merged.items()
    }


def _dependencies(row: Mapping[int, Kind], with_kinds: bool) -> dict[str, str]:
    """Write one row; in initialisation, kinds but the default mean nothing."""
    attributes = {"dependencies": " ".join(map(str, row))}
    if with_kinds:
        attributes["dependenciesKind"] = " ".join(row.values())
    return attributes


def _attributes(variable: Variable, subject: Subject) -> dict[str, str | None]:
    """Return what FMI 2 and 3 both say of a variable as such."""
    causality, variability, start = role(variable, subject.model)
    return {
        "description": variable.var.description,
        "causality": causality,
        "variability": variability,
        "initial": start,
    }


def _bounds(variable: Variable) -> dict[str, str | None]:
    """Return unit, bounds and the like; a Boolean has none of them."""
    if variable.boolean:
        return {}
    low, high = bounds(variable)
    size = nominal(variable)
    return {
        "declaredType": type_name(variable),
        "quantity": quantity(variable),
        "unit": variable.var.unit,
        "displayUnit": shown(variable),
        "min": None if low is None else repr(float(low)),
        "max": None if high is None else repr(float(high)),
        "nominal": None if size is None else repr(float(size)),
    }


def type_name(variable: Variable) -> str | None:
    """Return the name of the declared type of a quantity in a unit."""
    named = quantity(variable)
    if named is None:
        return None
    unit = (shown(variable) or variable.var.unit).replace("/", "_per_")
    return f"{named}_{unit}".replace(".", "_")


def types(root: etree._Element, layout: Layout, fmi: int) -> None:
    """Write TypeDefinitions: every quantity with its unit and display unit."""
    declared = {type_name(v): v for v in layout.variables if not v.boolean}
    declared.pop(None, None)
    if not declared:
        return
    parent = etree.SubElement(root, "TypeDefinitions")
    for name, v in sorted(declared.items(), key=str):
        told = {"quantity": quantity(v), "unit": v.var.unit, "displayUnit": shown(v)}
        if fmi == 2:
            simple = etree.SubElement(parent, "SimpleType", name=str(name))
            etree.SubElement(simple, "Real", given(told))
        else:
            etree.SubElement(parent, "Float64Type", given({"name": name} | told))


def _number(value: float, boolean: bool) -> str:
    return str(bool(value)).lower() if boolean else repr(value)


def given(attributes: Mapping[str, str | None]) -> dict[str, str]:
    return {name: text for name, text in attributes.items() if text is not None}
