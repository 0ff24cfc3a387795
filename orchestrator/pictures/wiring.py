"""The wiring as a picture: components with their FMUs, connections, what is free.

Boxes are laid out in layers, so that signals run one way but for feedback: to the
right where they are few, else down, as a page and a narrow screen have room.  A line
stands for all connections between two components and says their units, gains and
age.  What nothing drives stands in the box, with the value that holds.
"""

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from html import escape
from typing import Any

from orchestrator.master.layout import Part
from orchestrator.master.timetable import Timetable
from orchestrator.master.undriven import Undriven, undriven
from orchestrator.pictures.bundles import Bundle, bundles
from orchestrator.pictures.layered import laid_out
from orchestrator.pictures.svg import (
    LINE,
    arrow_heads,
    box,
    head,
    line,
    picture,
    shortened,
    text,
    width_of,
)
from orchestrator.quantities.quantity import rate

SMALL = 11.5
PAD = 10.0
HELD = 5  # inputs that nothing drives in a box
LETTERS = 34
LEGEND = 30.0
ACROSS = 4  # components that still stand beside each other on a page
OPTIONS = {
    "elk.algorithm": "layered",
    "elk.edgeRouting": "ORTHOGONAL",
    "elk.layered.cycleBreaking.strategy": "MODEL_ORDER",
    "elk.layered.considerModelOrder.strategy": "NODES_AND_EDGES",
    "elk.layered.nodePlacement.strategy": "NETWORK_SIMPLEX",
    "elk.layered.spacing.nodeNodeBetweenLayers": "26",
    "elk.layered.spacing.edgeNodeBetweenLayers": "14",
    "elk.spacing.nodeNode": "28",
    "elk.spacing.edgeNode": "16",
    "elk.spacing.edgeEdge": "12",
}


def wiring_picture(timetable: Timetable) -> str:
    """Return the wiring of a system as SVG.

    Raises:
        RuntimeError: it cannot be laid out.
    """
    system, parts = timetable.wiring.system, timetable.wiring.parts
    found = bundles(timetable)
    free: dict[str, list[Undriven]] = {}
    for one in undriven(system, {name: part.fmu for name, part in parts.items()}):
        free.setdefault(one.input.partition(".")[0], []).append(one)
    said = {name: _words(part, free.get(name, ())) for name, part in parts.items()}
    placed = laid_out(_graph(said, found))
    shapes = [
        *(p for e in placed["edges"] for p in _edge(e, found[int(e["id"][1:])])),
        *(p for b in placed["children"] for p in _box(b, said[b["id"]])),
    ]
    width, height = max(420.0, placed["width"]), placed["height"] + LEGEND
    legend = "a line: all connections between two; orange: older than 0 when taken; "
    legend += "○ nothing drives it, its value holds"
    shapes.append(text(12, height - 10, legend, "soft small"))
    heads = arrow_heads("edge", "aged")
    width = max(width, 24 + width_of(legend, SMALL))
    title = f"Wiring of {', '.join(parts)}"
    return picture(width, height, title, [heads, *shapes])


def _words(part: Part, free: Sequence[Undriven]) -> list[tuple[str, str, str]]:
    """Return the lines of a box: text, look, and what is told of it."""
    component = part.component
    about = f"{rate(component.period)}, {part.kind}"
    told = [
        (shortened(component.name, LETTERS), "name", component.name),
        (shortened(part.fmu.model_name, LETTERS), "soft small", str(component.fmu)),
        (about, "soft small", ""),
    ]
    if component.latency:
        samples = f"latency {component.latency} sample{'s' * (component.latency > 1)}"
        told.append((samples, "aged small", "published so many samples later"))
    if component.offset:
        told.append((f"offset {component.offset} s", "soft small", ""))
    for one in free[:HELD]:
        look = "soft small" if one.given else "held small"
        by = "the scenario" if one.given else "its FMU"
        named = str(one).partition(".")[2]
        tip = f"nothing drives {one}, as {by} says"
        told.append((f"○ {shortened(named, LETTERS)}", look, tip))
    if len(free) > HELD:
        rest = ", ".join(map(str, free[HELD:]))
        told.append((f"○ and {len(free) - HELD} more", "held small", rest))
    return told


def _graph(
    said: Mapping[str, Sequence[tuple[str, str, str]]], found: Sequence[Bundle]
) -> dict[str, Any]:
    """Return the graph for ELK: inputs on one side of a box, outputs on the other."""
    right = len(said) <= ACROSS
    inward, outward = ("WEST", "EAST") if right else ("NORTH", "SOUTH")
    children = []
    for name in _downstream(list(said), found):
        lines = said[name]
        wide = max(
            width_of(t, SMALL if "small" in look else 13.5) for t, look, _ in lines
        )
        ports = [
            {
                "id": f"{name}:{side}{i}",
                "layoutOptions": {"elk.port.side": side},
                "width": 0,
                "height": 0,
            }
            for i, b in enumerate(found)
            for side, end in ((outward, b.source), (inward, b.sink))
            if end == name
        ]
        children.append(
            {
                "id": name,
                "width": wide + 2 * PAD,
                "height": LINE * len(lines) + 2 * PAD - 4,
                "ports": ports,
                "layoutOptions": {
                    "elk.portConstraints": "FIXED_SIDE",
                    "elk.spacing.portPort": "14",
                },
            }
        )
    edges = []
    for i, bundle in enumerate(found):
        beside = _beside(bundle)
        edges.append(
            {
                "id": f"e{i}",
                "sources": [f"{bundle.source}:{outward}{i}"],
                "targets": [f"{bundle.sink}:{inward}{i}"],
                "labels": [
                    {
                        "text": f"{bundle.source} → {bundle.sink}",
                        "width": max(width_of(t, SMALL) for t in beside) + 8,
                        "height": 15 * len(beside) + 4,
                        "layoutOptions": {"elk.edgeLabels.inline": "true"},
                    }
                ],
            }
        )
    options = {**OPTIONS, "elk.direction": "RIGHT" if right else "DOWN"}
    return {
        "id": "root",
        "layoutOptions": options,
        "children": children,
        "edges": edges,
    }


def _downstream(names: Sequence[str], found: Sequence[Bundle]) -> list[str]:
    """Return components by how far they are from those that take nothing."""
    fed = {bundle.sink for bundle in found if bundle.sink != bundle.source}
    far = {name: 0 for name in names if name not in fed} or {names[0]: 0}
    front = list(far)
    while front:
        reached = [b.sink for b in found if b.source in front and b.sink not in far]
        far.update({name: 1 + max(far.values()) for name in reached})
        front = reached or [name for name in names if name not in far][:1]
        far.update({name: 1 + max(far.values()) for name in front if name not in far})
    return sorted(names, key=lambda name: far[name])


def _beside(bundle: Bundle) -> list[str]:
    return [*bundle.lines(), _age(*bundle.ages)]


def _age(youngest: Fraction, oldest: Fraction) -> str:
    low, high = (f"{float(t * 10**6):.6g}" for t in (youngest, oldest))
    return f"age {low} us" if low == high else f"age {low} to {high} us"


def _box(
    placed: Mapping[str, Any], lines: Sequence[tuple[str, str, str]]
) -> Iterator[str]:
    x, y = placed["x"], placed["y"]
    size = placed["width"], placed["height"]
    yield f'<g data-component="{escape(placed["id"])}">'
    yield box(x, y, *size, "box", 'stroke="var(--line)" rx="5"')
    for i, (said, look, tip) in enumerate(lines):
        yield text(x + PAD, y + PAD + 10 + LINE * i, said, look, tip=tip)
    yield "</g>"


def _edge(placed: Mapping[str, Any], bundle: Bundle) -> Iterator[str]:
    colour = "aged" if bundle.ages[1] else "edge"
    for section in placed["sections"]:
        bends = section.get("bendPoints", [])
        points = [section["startPoint"], *bends, section["endPoint"]]
        width = 1.3 + 0.35 * min(4, len(bundle.wires) - 1)
        look = f'stroke-width="{width:.2f}" stroke-linejoin="round" {head(colour)}'
        yield line([(p["x"], p["y"]) for p in points], colour, look)
    label = placed["labels"][0]
    x, y = label["x"], label["y"]
    tip = "; ".join(f"{w.source} → {w.sink} {w.conversion}" for w in bundle.wires)
    yield box(x, y, label["width"], label["height"], "paper", 'rx="3"', tip)
    middle = x + 0.5 * label["width"]
    *names, age = _beside(bundle)
    for i, said in enumerate(names):
        look = "small bad" if "fault:" in said else "small"
        yield text(middle, y + 13 + 15 * i, said, look, "middle", tip)
    last = "small aged" if bundle.ages[1] else "small soft"
    yield text(middle, y + 13 + 15 * len(names), age, last, "middle", tip)
