"""Terminals and icon: what a tool draws, and which signals it connects at once.

A terminal ``inputs`` and one ``outputs`` bring all signals together as buses, so
that a reference, a controller and a plant are joined by names.
"""

import struct
import zlib
from typing import Any

import numpy as np
from lxml import etree

from fmus.evidence import icon
from fmus.layout import Block
from fmus.model import Continuous
from fmus.subject import Fmi, Subject

FOLDER = "terminalsAndIcons"
SIZE = 96  # pixels of the icon
SIDES: dict[str, Block] = {"inputs": "input", "outputs": "output"}


def terminal_files(subject: Subject, fmi: Fmi) -> dict[str, bytes]:
    """Return icon and, in FMI 3, terminals by archive name."""
    if fmi == 2:
        return {"model.png": _png(subject)}
    return {
        f"{FOLDER}/terminalsAndIcons.xml": _terminals(subject),
        f"{FOLDER}/icon.png": _png(subject),
        f"{FOLDER}/icon.svg": icon(subject),
    }


def _terminals(subject: Subject) -> bytes:
    root = etree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = etree.SubElement(root, "GraphicalRepresentation")
    corners = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    scale = {"suggestedScalingFactorTo_mm": "0.1"}
    etree.SubElement(picture, "CoordinateSystem", corners | scale)
    etree.SubElement(picture, "Icon", corners)
    parent: Any = etree.Element("Terminals")
    for name, block in SIDES.items():
        variables = subject.layout.block(block)
        if not variables:
            continue
        told = {"name": name, "matchingRule": "bus"}
        terminal = etree.SubElement(parent, "Terminal", told)
        for v in variables:
            member = {"variableName": v.name, "memberName": v.name}
            member["variableKind"] = "signal"
            etree.SubElement(terminal, "TerminalMemberVariable", member)
    if len(parent):
        root.append(parent)
    document: bytes = etree.tostring(
        root, xml_declaration=True, encoding="UTF-8", pretty_print=True
    )
    return document


def _png(subject: Subject) -> bytes:
    """Return the icon: a mass on a screw for a plant, a block for what is sampled."""
    picture = np.full((SIZE, SIZE, 3), 255, dtype=np.uint8)
    ink, fill = (68, 68, 68), (27, 108, 168)
    if isinstance(subject.model, Continuous):
        picture[46:50, 4:92] = ink
        for x in range(6, 92, 8):
            picture[42:54, x : x + 3] = ink
        picture[28:68, 34:62] = fill
    else:
        picture[46:50, 4:92] = ink
        picture[20:76, 22:74] = ink
        picture[24:72, 26:70] = 255
        for step in range(5):
            x, y = 30 + 7 * step, 62 - 8 * step
            picture[y : y + 3, x : x + 10] = fill
            picture[y - 6 : y + 3, x + 7 : x + 10] = fill

    def chunk(kind: bytes, data: bytes) -> bytes:
        whole = kind + data
        return (
            struct.pack(">I", len(data)) + whole + struct.pack(">I", zlib.crc32(whole))
        )

    rows = b"".join(b"\0" + row.tobytes() for row in picture)
    head = struct.pack(">IIBBBBB", SIZE, SIZE, 8, 2, 0, 0, 0)
    parts = [(b"IHDR", head), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts)
