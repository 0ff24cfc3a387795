"""The one place that writes modelDescription.xml, for FMI 2.0 and FMI 3.0.

Native and Python FMUs are described alike; what each version says of variables
is in ``fmus.variables``.  Nothing but the token depends on when or where the
description is written.
"""

from fractions import Fraction
from importlib.metadata import version

from lxml import etree

from fmus.layout import Layout
from fmus.model import Continuous, Model, Sampled
from fmus.quantities import FACTORS
from fmus.subject import Fmi, Subject, check_start
from fmus.tangent import tangent
from fmus.units import base_unit
from fmus.variables import arrays, given, scalars, types

DISTRIBUTION = "feeddrive-cosim"
TOOL = "feeddrive"
SUBSTEPS = 5  # of h_max in the suggested communication step: 5 x 10 us = 20 kHz
STEPS = 20_000  # of the default experiment: 1 s at 20 kHz
LOG_CATEGORIES = {
    "logAll": "all messages",
    "logStatusError": "why something was refused",
}
PYTHON_LOG_CATEGORIES = LOG_CATEGORIES | {
    "logStatusFatal": "why no instance could be made",
}


def describe(subject: Subject, fmi: Fmi, token: str) -> bytes:
    """Return modelDescription.xml as UTF-8.

    Raises:
        UnitError: a unit of the model cannot be read.
        ValueError: a start value is not finite or out of its bounds, or a
            variable is called ``time``.
    """
    for variable in subject.layout.variables:
        check_start(subject.model, variable)
    root = _root(subject, fmi, token)
    _interfaces(root, subject, fmi)
    _units(root, subject.layout)
    types(root, subject.layout, fmi)
    categories = etree.SubElement(root, "LogCategories")
    told = LOG_CATEGORIES if subject.native else PYTHON_LOG_CATEGORIES
    for name, text in told.items():
        etree.SubElement(categories, "Category", name=name, description=text)
    experiment = {
        "startTime": "0.0",
        "stopTime": repr(STEPS * suggested_step(subject.model)),
    }
    if subject.model_exchange:
        experiment["tolerance"] = "1e-06"
    experiment["stepSize"] = repr(suggested_step(subject.model))
    etree.SubElement(root, "DefaultExperiment", experiment)
    if fmi == 2:
        scalars(root, subject)
    else:
        arrays(root, subject)
    document: bytes = etree.tostring(
        root, xml_declaration=True, encoding="UTF-8", pretty_print=True
    )
    return document


def suggested_step(model: Model) -> float:
    """Return the communication step (s) an importer may start from."""
    if isinstance(model, Continuous):
        return SUBSTEPS * model.h_max
    return float(model.period)


def _root(subject: Subject, fmi: Fmi, token: str) -> etree._Element:
    tool_version = version(DISTRIBUTION)
    attributes = {
        "fmiVersion": "2.0" if fmi == 2 else "3.0",
        "modelName": subject.model.name,
        "guid" if fmi == 2 else "instantiationToken": token,
        "description": subject.summary,
        "author": subject.author,
        "version": tool_version,
        "copyright": subject.copyright,
        "license": subject.license,
        "generationTool": f"{TOOL} {tool_version}",
        "variableNamingConvention": "structured",
    }
    return etree.Element("fmiModelDescription", given(attributes))


def _interfaces(root: etree._Element, subject: Subject, fmi: Fmi) -> None:
    state = "FMUstate" if fmi == 2 else "FMUState"
    common = {
        "modelIdentifier": subject.model.name,
        "needsExecutionTool": "false" if subject.native else "true",
        f"canGetAndSet{state}": "true",
        f"canSerialize{state}": "true",
    }
    if subject.native and tangent(subject.model, subject.traced) is not None:
        known = "providesDirectionalDerivative" + ("" if fmi == 2 else "s")
        common[known] = "true"
    if fmi == 2:
        common["canNotUseMemoryManagementFunctions"] = "true"
    interfaces = []
    if subject.model_exchange:
        unneeded = {"completedIntegratorStepNotNeeded": "true"} if fmi == 2 else {}
        interfaces.append(etree.SubElement(root, "ModelExchange", common | unneeded))
    variable_step = {"canHandleVariableCommunicationStepSize": "true"}
    if fmi == 3 and subject.clocked:
        variable_step["hasEventMode"] = "true"
    interfaces.append(etree.SubElement(root, "CoSimulation", common | variable_step))
    if fmi == 3 or not subject.native:
        return
    for interface in interfaces:
        files = etree.SubElement(interface, "SourceFiles")
        for name in subject.sources:
            etree.SubElement(files, "File", name=name)


def _units(root: etree._Element, layout: Layout) -> None:
    units = {v.var.unit for v in layout.variables if not v.boolean} | {"s"}
    definitions = etree.SubElement(root, "UnitDefinitions")
    for name in sorted(units):
        base = base_unit(name)
        attributes = {n: str(e) for n, e in base.exponents.items()}
        if base.factor != 1.0:
            attributes["factor"] = repr(base.factor)
        if base.offset != 0.0:
            attributes["offset"] = repr(base.offset)
        unit = etree.SubElement(definitions, "Unit", name=name)
        etree.SubElement(unit, "BaseUnit", attributes)
        for shown_in in sorted({s for u, s in FACTORS if u == name}):
            factor = repr(FACTORS[name, shown_in])
            etree.SubElement(unit, "DisplayUnit", name=shown_in, factor=factor)


def extra(subject: Subject) -> bytes:
    """Return what our own master reads and the standard has no attribute for."""
    model = subject.model
    facts = {"module": subject.module, "kind": "continuous"}
    if isinstance(model, Sampled):
        facts |= {"kind": "sampled", "period": exact(model.period)}
    root = etree.Element("Model", facts)
    document: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8")
    return document


def exact(period: Fraction) -> str:
    """Write a fraction as numerator/denominator."""
    return f"{period.numerator}/{period.denominator}"
