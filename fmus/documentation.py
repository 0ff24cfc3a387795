"""The human-readable part of an FMU: index.html and the licence."""

from collections.abc import Iterator
from importlib.metadata import distribution
from typing import Any

from lxml import etree
from lxml.builder import E

from fmus.description import DISTRIBUTION
from fmus.evidence import Response, block, curves
from fmus.quantities import bounds, nominal, quantity
from fmus.subject import Subject, role

STYLE = """
body { font-family: sans-serif; max-width: 60em; margin: 2em auto }
th, td { text-align: left; padding: 0.1em 1em 0.1em 0; vertical-align: top }
"""
COLUMNS = (
    "Variable",
    "Kind",
    "Quantity",
    "Unit",
    "Start",
    "Usual",
    "Bounds",
    "Meaning",
)
SHOWN = 9  # start values of an array that are written out


def index_html(subject: Subject, found: Response | None) -> bytes:
    """Return a page with the module's docstring, pictures and all variables."""
    rows = [E.tr(*(E.th(name) for name in COLUMNS))]
    for variable in subject.layout.variables:
        causality, variability, _ = role(variable, subject.model)
        start = ", ".join(f"{v:.6g}" for v in variable.start[:SHOWN])
        more = ", …" if len(variable.start) > SHOWN else ""
        usual = nominal(variable)
        size = "×".join(map(str, variable.shape))
        cells = (
            f"{variable.name} ({size})" if size else variable.name,
            f"{variability} {causality}",
            quantity(variable) or "",
            "" if variable.boolean else variable.var.unit,
            start + more,
            "" if usual is None else f"{usual:g}",
            _between(*bounds(variable)),
            variable.var.description,
        )
        rows.append(E.tr(*(E.td(cell) for cell in cells)))
    page = E.html(
        E.head(E.meta(charset="utf-8"), E.title(subject.model.name), E.style(STYLE)),
        E.body(*_pictures(subject, found), E.table(*rows)),
        lang="en",
    )
    document: bytes = etree.tostring(
        page,
        method="html",
        encoding="utf-8",
        doctype="<!DOCTYPE html>",
        pretty_print=True,
    )
    return document


def _pictures(subject: Subject, found: Response | None) -> Iterator[Any]:
    yield E.h1(subject.model.name)
    yield block(subject)
    yield E.pre(subject.text.strip())
    if found is None:
        return
    text = ", ".join(f"{name} = {value:g}" for name, value in found.inputs.items())
    yield E.p(f"Response from the start values{' to ' if text else ''}{text}:")
    yield curves(found)


def _between(low: float | None, high: float | None) -> str:
    if low is None and high is None:
        return ""
    return (
        f"{'' if low is None else f'{low:g}'} … {'' if high is None else f'{high:g}'}"
    )


def license_text() -> bytes:
    """Return the licence of this distribution, hence of the adapters."""
    text = distribution(DISTRIBUTION).read_text("licenses/LICENSE")
    assert text is not None, "the distribution was installed without its licence"
    return text.encode()
