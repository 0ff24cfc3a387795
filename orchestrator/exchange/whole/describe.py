"""What is told of a composition as one FMU: modelDescription.xml and a page."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib.metadata import version
from typing import Any

from lxml import etree

from fmus.description import LOG_CATEGORIES
from fmus.package import OWN_COPYRIGHT
from fmus.subject import CLOCK, Fmi
from orchestrator.exchange.whole.tables import Outside
from orchestrator.scenario.compose import Composition

OURS = ("plants.", "controllers.")  # models of which we are the authors


@dataclass(frozen=True)
class Told:
    """What the description says; references count through ``outside``.

    ``size`` is the reference of time, of the clock the next; ``clock`` its period (s).
    ``states``: FMU states can be got and set.
    """

    composition: Composition
    identifier: str
    outside: Sequence[Outside]
    size: int
    clock: Fraction | None
    states: bool


def describe(told: Told, fmi: Fmi, token: str) -> bytes:
    """Return modelDescription.xml."""
    composition, outside = told.composition, told.outside
    system = composition.system
    root = etree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0" if fmi == 2 else "3.0",
            "modelName": system.name,
            "guid" if fmi == 2 else "instantiationToken": token,
            "description": composition.scenario.spec.title,
            "generationTool": f"feeddrive {version('feeddrive-cosim')}",
            "version": "1.0",
            "variableNamingConvention": "structured",
        },
    )
    if all(s.startswith(OURS) for s in composition.sources.values()):
        root.set("author", OWN_COPYRIGHT)
        root.set("copyright", f"© {OWN_COPYRIGHT}")
        root.set("license", "MIT")
    state = "FMUstate" if fmi == 2 else "FMUState"
    interface = {
        "modelIdentifier": told.identifier,
        f"canGetAndSet{state}": str(told.states).lower(),
        f"canSerialize{state}": str(told.states).lower(),
        "canHandleVariableCommunicationStepSize": "true",
    }
    if fmi == 2:
        interface["canNotUseMemoryManagementFunctions"] = "true"
    elif told.clock:
        interface["hasEventMode"] = "true"
    etree.SubElement(root, "CoSimulation", interface)
    _units(root, outside)
    categories = etree.SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        etree.SubElement(categories, "Category", name=name, description=text)
    step = min(c.period for c in system.components.values())
    etree.SubElement(
        root,
        "DefaultExperiment",
        startTime="0.0",
        stopTime=repr(float(system.stop)),
        stepSize=repr(float(step)),
    )
    variables = etree.SubElement(root, "ModelVariables")
    structure = etree.SubElement(root, "ModelStructure")
    (_scalars if fmi == 2 else _variables)(variables, structure, told)
    etree.indent(root, "  ")
    text = etree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return bytes(text)


def page(composition: Composition, outside: Sequence[Outside]) -> bytes:
    """Return the composition in words: its description, variables and timing."""
    spec, system = composition.scenario.spec, composition.system
    timing = [
        f"{c.name}: every {c.period} s, offset {c.offset} s, latency {c.latency}"
        for c in system.components.values()
    ]
    variables = [f"{v.role} {v.name}: {v.description}" for v in outside]
    html = etree.Element("html", lang="en")
    head = etree.SubElement(html, "head")
    etree.SubElement(head, "meta", charset="utf-8")
    etree.SubElement(head, "title").text = spec.title or system.name
    body = etree.SubElement(html, "body")
    etree.SubElement(body, "h1").text = spec.title or system.name
    etree.SubElement(body, "p").text = spec.description
    for lines in (timing, variables):
        listed = etree.SubElement(body, "ul")
        for line in lines:
            etree.SubElement(listed, "li").text = line
    page: bytes = etree.tostring(
        html, method="html", encoding="utf-8", doctype="<!DOCTYPE html>"
    )
    return page


def _units(root: Any, outside: Sequence[Outside]) -> None:
    found: dict[str, Any] = {
        str(v.unit): v.unit.base
        for v in outside
        if v.unit is not None and v.unit.base is not None and not v.boolean
    }
    seconds = etree.Element("BaseUnit", s="1")
    listed = etree.SubElement(root, "UnitDefinitions")
    for name in sorted({*found, "s"}):
        one = etree.SubElement(listed, "Unit", name=name)
        if name not in found:
            one.append(seconds)
            continue
        base = found[name]
        of = etree.SubElement(
            one, "BaseUnit", {k: str(n) for k, n in base.exponents.items()}
        )
        if base.factor != 1:
            of.set("factor", repr(base.factor))
        if base.offset:
            of.set("offset", repr(base.offset))


def _scalars(variables: Any, structure: Any, told: Told) -> None:
    """Write ModelVariables and ModelStructure of FMI 2."""
    for reference, one in enumerate(told.outside):
        made = etree.SubElement(variables, "ScalarVariable", _about(reference, one))
        etree.SubElement(made, "Boolean" if one.boolean else "Real", _value(one))
    listed = [i for i, v in enumerate(told.outside, 1) if v.role == "output"]
    for tag in ("Outputs", "InitialUnknowns"):
        of_tag = etree.SubElement(structure, tag)
        for i in listed:
            unknown = etree.SubElement(of_tag, "Unknown", index=str(i))
            if tag == "Outputs":  # nothing changes but by a step
                unknown.set("dependencies", "")


def _variables(variables: Any, structure: Any, told: Told) -> None:
    """Write ModelVariables and ModelStructure of FMI 3."""
    for reference, one in enumerate(told.outside):
        facts = _about(reference, one) | _value(one)
        etree.SubElement(variables, "Boolean" if one.boolean else "Float64", facts)
    time = {"name": "time", "valueReference": str(told.size), "unit": "s"}
    time |= {"causality": "independent", "variability": "continuous"}
    etree.SubElement(variables, "Float64", time, description="simulation time")
    if told.clock:
        num, den = told.clock.as_integer_ratio()
        clock = {
            "name": CLOCK,
            "valueReference": str(told.size + 1),
            "description": "ticks the sampled components where event mode is used",
            "causality": "input",
            "intervalVariability": "constant",
            "intervalDecimal": repr(num / den),
            "supportsFraction": "true",
            "resolution": str(den),
            "intervalCounter": str(num),
        }
        etree.SubElement(variables, "Clock", clock)
    references = {one.name: i for i, one in enumerate(told.outside)}
    listed = [(i, v) for i, v in enumerate(told.outside) if v.role == "output"]
    for tag in ("Output", "InitialUnknown"):
        for i, one in listed:
            unknown = etree.SubElement(structure, tag, valueReference=str(i))
            if tag == "Output":
                needed = sorted(references[name] for name in one.needs)
                unknown.set("dependencies", " ".join(map(str, needed)))


def _about(reference: int, one: Outside) -> dict[str, str]:
    facts = {
        "name": one.name,
        "valueReference": str(reference),
        "description": one.description,
        "causality": one.role,
    }
    if one.role == "parameter":
        facts["variability"] = "fixed"
    elif one.boolean or one.role == "local":
        facts["variability"] = "discrete"
    if one.role == "local":
        facts["initial"] = "exact"
    return facts


def _value(one: Outside) -> dict[str, str]:
    facts = {}
    if one.start is not None:
        told = repr(one.start) if not one.boolean else str(bool(one.start)).lower()
        facts["start"] = told
    if one.unit is not None and one.unit.base is not None and not one.boolean:
        facts["unit"] = str(one.unit)
    return facts
