"""Names of SSP's documents, and how they are written so that bytes repeat.

Both versions have the namespaces of the first; attributes stand in the order in
which they are given.
"""

from pathlib import Path
from typing import Any, Literal, TypeAlias

import fmpy
from lxml import etree

Version: TypeAlias = Literal["1.0", "2.0"]
NAMESPACES = {
    part: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for part, name in (
        ("ssd", "Description"),
        ("ssc", "Common"),
        ("ssv", "ParameterValues"),
        ("ssm", "ParameterMapping"),
    )
}
OURS = "org.feeddrive.timing"  # the type of our annotation
FEEDDRIVE = "urn:feeddrive:ssp:1"
OSP = "com.opensimulationplatform"  # read by libcosim, Vico and Ecos
OSP_URI = "http://opensimulationplatform.com/SSP/OSPAnnotations"
DEFAULT = "SystemStructure.ssd"
FMU_TYPE = "application/x-fmu-sharedlibrary"
_ALL = {**NAMESPACES, "fd": FEEDDRIVE, "osp": OSP_URI}
_SCHEMAS = {
    "1": Path(fmpy.__file__).parent / "ssp" / "schema",
    "2": Path(__file__).parent / "schema_2_0",
}
_FILES = {
    "SystemStructureDescription": "SystemStructureDescription.xsd",
    "ParameterSet": "SystemStructureParameterValues.xsd",
    "ParameterMapping": "SystemStructureParameterMapping.xsd",
}


def root(tag: str, /, *parts: str, **attributes: str) -> Any:
    """Return a document's root ``prefix:Name`` that declares the prefixes of parts."""
    made = etree.Element(_tag(tag), nsmap={part: _ALL[part] for part in parts})
    return _with(made, attributes)


def add(parent: Any, tag: str, /, **attributes: str) -> Any:
    """Append ``prefix:Name`` to an element; its attributes as they are given."""
    prefix = tag.partition(":")[0]
    made = etree.SubElement(parent, _tag(tag), nsmap={prefix: _ALL[prefix]})
    return _with(made, attributes)


def _tag(name: str) -> str:
    prefix, _, local = name.partition(":")
    return f"{{{_ALL[prefix]}}}{local}"


def _with(made: Any, attributes: dict[str, str]) -> Any:
    for key, value in attributes.items():
        made.set(key, value)
    return made


def document(made: Any) -> bytes:
    """Return the bytes of a document."""
    etree.indent(made, "  ")
    text: bytes = etree.tostring(made, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def local(element: Any) -> str:
    """Return an element's name without namespace, "" of comments."""
    return etree.QName(element).localname if isinstance(element.tag, str) else ""


def against_schema(made: Any) -> list[str]:
    """Return where a document does not follow the schema of its version."""
    version, name = made.get("version", ""), local(made)
    folder = _SCHEMAS.get(version[:1])
    if folder is None:
        return [f"version {version!r} is neither 1.0 nor 2.0"]
    if name not in _FILES:
        return [f"{name!r} is no document of SSP"]
    schema = etree.XMLSchema(etree.parse(str(folder / _FILES[name])))
    # a part of a document is checked as a document of its own
    whole = etree.fromstring(etree.tostring(made))
    if schema.validate(whole):
        return []
    base = (made.sourceline or 1) - 1 if made.getparent() is not None else 0
    return [f"line {base + fault.line}: {fault.message}" for fault in schema.error_log]
