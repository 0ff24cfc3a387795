"""System structures written by hand, as other tools write them."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

URIS = " ".join(
    f'xmlns:{prefix}="http://ssp-standard.org/SSP1/SystemStructure{name}"'
    for prefix, name in (
        ("ssd", "Description"),
        ("ssc", "Common"),
        ("ssv", "ParameterValues"),
        ("ssm", "ParameterMapping"),
    )
)


VERSION = ["1.0"]  # of SSP, in which all is written


def ssd(system: str, rest: str = "", name: str = "plant") -> str:
    """Return a description around the content of its system."""
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><ssd:SystemStructureDescription {URIS} '
        f'version="{VERSION[-1]}" name="{name}"><ssd:System name="root">{system}'
        f"</ssd:System>{rest}</ssd:SystemStructureDescription>"
    )


def experiment(stop: str = "0.01", annotations: str = "") -> str:
    """Return a default experiment that stops at a time (s)."""
    about = f'stopTime="{stop}"'
    return f"<ssd:DefaultExperiment {about}>{annotations}</ssd:DefaultExperiment>"


def connectors(**kinds: str) -> str:
    """Return Real connectors by name; ``name="input mm"`` has a unit."""
    lines = []
    for name, text in kinds.items():
        kind, _, unit = text.partition(" ")
        own = f' unit="{unit}"' if unit else ""
        lines.append(
            f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real{own}/>'
            f"</ssd:Connector>"
        )
    return f"<ssd:Connectors>{''.join(lines)}</ssd:Connectors>"


def component(name: str, source: str, inside: str = "", about: str = "") -> str:
    return (
        f'<ssd:Component name="{name}" source="{source}" {about}>{inside}'
        f"</ssd:Component>"
    )


def connections(*pairs: str) -> str:
    """Return connections written ``a.x -> b.y``, after a bar what stands inside."""
    lines = []
    for pair in pairs:
        ends, _, inside = pair.partition("|")
        about, _, inside = inside.partition("|")
        words = []
        for side, end in zip(("start", "end"), ends.split("->"), strict=True):
            element, dot, connector = end.strip().partition(".")
            if not dot:
                element, connector = "", element
            words += [f'{side}Element="{element}"'] if dot else []
            words += [f'{side}Connector="{connector}"']
        lines.append(
            f"<ssd:Connection {' '.join(words)} {about}>{inside}</ssd:Connection>"
        )
    return f"<ssd:Connections>{''.join(lines)}</ssd:Connections>"


def annotated(type_: str, inside: str) -> str:
    return (
        f'<ssd:Annotations><ssc:Annotation type="{type_}">{inside}</ssc:Annotation>'
        f"</ssd:Annotations>"
    )


def mapping(*entries: str, source: str = "") -> str:
    """Return a mapping of entries ``source target`` and, after a bar, what is inside;
    or one that lies in a file."""
    if source:
        return f'<ssd:ParameterMapping source="{source}"/>'
    return f"<ssd:ParameterMapping>{mapped(*entries)}</ssd:ParameterMapping>"


def mapped(*entries: str) -> str:
    lines = []
    for text in entries:
        ends, _, inside = text.partition("|")
        source, _, target = ends.partition(" ")
        about = f'source="{source}" target="{target}"'
        lines.append(f"<ssm:MappingEntry {about}>{inside}</ssm:MappingEntry>")
    whole = "".join(lines)
    head = f'<ssm:ParameterMapping {URIS} version="{VERSION[-1]}">'
    return f"{head}{whole}</ssm:ParameterMapping>"


def unit(name: str, about: str, kind: str = "ssd") -> str:
    one = f'<ssc:Unit name="{name}"><ssc:BaseUnit {about}/></ssc:Unit>'
    return f"<{kind}:Units>{one}</{kind}:Units>"


def linear(factor: float, offset: float = 0.0) -> str:
    return f'<ssc:LinearTransformation factor="{factor}" offset="{offset}"/>'


def parameter_set(*values: str) -> str:
    """Return a set of parameters written ``name Type attributes``."""
    lines = []
    for text in values:
        name, kind, about = text.split(" ", 2)
        lines.append(
            f'<ssv:Parameter name="{name}"><ssv:{kind} {about}/></ssv:Parameter>'
        )
    return (
        f'<ssv:ParameterSet {URIS} version="{VERSION[-1]}" name="set"><ssv:Parameters>'
        f"{''.join(lines)}</ssv:Parameters></ssv:ParameterSet>"
    )


def binding(
    values: str = "", source: str = "", prefix: str = "", maps: str = ""
) -> str:
    about = f'source="{source}"' if source else ""
    about += f' prefix="{prefix}"' if prefix else ""
    inner = f"<ssd:ParameterValues>{values}</ssd:ParameterValues>" if values else ""
    return (
        f"<ssd:ParameterBindings><ssd:ParameterBinding {about}>{inner}{maps}"
        f"</ssd:ParameterBinding></ssd:ParameterBindings>"
    )


def package(file: Path, members: Mapping[str, str | bytes | Path]) -> Path:
    """Write an archive of texts and files."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in members.items():
            if isinstance(content, Path):
                archive.write(content, name)
            else:
                archive.writestr(name, content)
    return file
