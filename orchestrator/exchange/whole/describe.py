"""What is told of a composition as one FMU: modelDescription.xml and a page."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

from lxml import etree

from fmus.package import OWN_COPYRIGHT
from orchestrator.exchange.whole.tables import Outside
from orchestrator.scenario.compose import Composition

OURS = ("plants.", "controllers.")  # models of which we are the authors


def describe(
    composition: Composition, identifier: str, outside: Sequence[Outside], guid: str
) -> bytes:
    """Return modelDescription.xml."""
    system = composition.system
    root = etree.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=system.name,
        guid=guid,
        description=composition.scenario.spec.title,
        generationTool=f"feeddrive {version('feeddrive-cosim')}",
        version="1.0",
        variableNamingConvention="structured",
    )
    if all(s.startswith(OURS) for s in composition.sources.values()):
        root.set("author", OWN_COPYRIGHT)
        root.set("copyright", f"© {OWN_COPYRIGHT}")
        root.set("license", "MIT")
    etree.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=identifier,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
    )
    _units(root, outside)
    categories = etree.SubElement(root, "LogCategories")
    etree.SubElement(
        categories,
        "Category",
        name="logStatusError",
        description="why a call returned Error",
    )
    step = min(c.period for c in system.components.values())
    etree.SubElement(
        root,
        "DefaultExperiment",
        startTime="0",
        stopTime=repr(float(system.stop)),
        stepSize=repr(float(step)),
    )
    variables = etree.SubElement(root, "ModelVariables")
    for reference, one in enumerate(outside):
        variables.append(_variable(reference, one))
    structure = etree.SubElement(root, "ModelStructure")
    listed = [i for i, v in enumerate(outside, 1) if v.role == "output"]
    for tag in ("Outputs", "InitialUnknowns"):
        of_tag = etree.SubElement(structure, tag)
        for i in listed:
            one = etree.SubElement(of_tag, "Unknown", index=str(i))
            if tag == "Outputs":  # nothing changes but by a step
                one.set("dependencies", "")
    etree.indent(root, "  ")
    text: bytes = etree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text


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
    found: Mapping[str, Any] = {
        str(v.unit): v.unit.base
        for v in outside
        if v.unit is not None and v.unit.base is not None and not v.boolean
    }
    listed = etree.SubElement(root, "UnitDefinitions")
    for name in sorted(found):
        base = found[name]
        one = etree.SubElement(listed, "Unit", name=name)
        of = etree.SubElement(
            one, "BaseUnit", {k: str(n) for k, n in base.exponents.items()}
        )
        if base.factor != 1:
            of.set("factor", repr(base.factor))
        if base.offset:
            of.set("offset", repr(base.offset))


def _variable(reference: int, one: Outside) -> Any:
    about = {
        "name": one.name,
        "valueReference": str(reference),
        "description": one.description,
        "causality": one.role,
    }
    if one.role == "parameter":
        about["variability"] = "fixed"
    elif one.boolean:
        about["variability"] = "discrete"
    made = etree.Element("ScalarVariable", about)
    kind = etree.SubElement(made, "Boolean" if one.boolean else "Real")
    if one.start is not None:
        told = repr(one.start) if not one.boolean else str(bool(one.start)).lower()
        kind.set("start", told)
    if one.unit is not None and one.unit.base is not None and not one.boolean:
        kind.set("unit", str(one.unit))
    return made
