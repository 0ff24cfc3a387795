"""What an FMU brings to prove itself: a step of all inputs, and the response.

The experiment lies in ``extra/`` as FMI-LS-REF has it (1.0.0-alpha.1), for tools
that compute it once more; the same response is drawn in the documentation.  It is
computed by the NumPy equations, hence not by what it is to prove.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from lxml import etree
from lxml.builder import E

from fmus.description import suggested_step
from fmus.layout import Variable
from fmus.model import FloatArray
from fmus.quantities import nominal
from fmus.simulation import Simulation
from fmus.subject import Subject

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
STEPS = 100
WIDTH, HEIGHT, LEFT = 640, 220, 90
COLOURS = ("#1b6ca8", "#c8553d", "#588157", "#6d597a")
MANIFEST = """\
<?xml version="1.0" encoding="UTF-8"?>
<fmiReferences xmlns:ls="http://fmi-standard.org/fmi-ls-manifest"
    ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref" ls:fmi-ls-version="1.0.0-alpha.1"
    ls:fmi-ls-description="A step of all inputs and the response">
  <Related source="step.exp" role="experiment/validation"/>
</fmiReferences>
"""
EXPERIMENT = """\
<?xml version="1.0" encoding="UTF-8"?>
<Experiments name="step">
  <Experiment name="step" stopTime="{stop!r}" stepSize="{step!r}">
    {stimuli}<References source="response.csv"/>
  </Experiment>
</Experiments>
"""


@dataclass(frozen=True)
class Response:
    """Outputs (steps + 1, outputs) at times (s) while inputs hold their values."""

    inputs: dict[str, float]
    names: tuple[str, ...]
    times: FloatArray
    rows: FloatArray


def response(subject: Subject) -> Response | None:
    """Return the response of the scalar outputs; None if it is not finite."""
    model, layout = subject.model, subject.layout
    simulation, h = Simulation(model), suggested_step(model)
    inputs = {v.name: v for v in layout.block("input") if _is_number(v)}
    steps = {n: v.start[0] + (nominal(v) or 1.0) for n, v in inputs.items()}
    for name, value in steps.items():
        simulation.put(inputs[name].reference, value, "input")
    outputs = [v for v in layout.block("output") if _is_number(v)]
    places = [v.reference for v in outputs]
    with np.errstate(all="ignore"):
        simulation.refresh()
        simulation.begin()
        rows = [simulation.values[places]]
        for k in range(STEPS):
            simulation.step(k * h, h)
            rows.append(simulation.values[places])
    if not outputs or not np.isfinite(rows).all():
        return None
    times: FloatArray = np.arange(STEPS + 1, dtype=float) * h
    return Response(steps, tuple(v.name for v in outputs), times, np.array(rows))


def _is_number(variable: Variable) -> bool:
    return not variable.boolean and not variable.shape


def reference_files(found: Response) -> dict[str, bytes]:
    """Return the files of the layered standard by archive name."""
    stop, step = float(found.times[-1]), float(found.times[1])
    stimuli = '<Stimuli source="step.csv"/>\n    ' if found.inputs else ""
    files = {
        "fmi-ls-manifest.xml": MANIFEST,
        "step.exp": EXPERIMENT.format(stop=stop, step=step, stimuli=stimuli),
        "response.csv": _csv(("time", *found.names), found.times, found.rows),
    }
    if found.inputs:
        held = np.tile(list(found.inputs.values()), (2, 1))
        files["step.csv"] = _csv(("time", *found.inputs), np.array([0.0, stop]), held)
    return {f"{FOLDER}/{name}": text.encode() for name, text in files.items()}


def _csv(names: tuple[str, ...], times: FloatArray, rows: FloatArray) -> str:
    lines = [",".join(f'"{name}"' for name in names)]
    for time, row in zip(times, rows, strict=True):
        lines.append(",".join(repr(float(value)) for value in (time, *row)))
    return "\n".join(lines) + "\n"


def block(subject: Subject) -> Any:
    """Return a picture of the model as a block with its inputs and outputs."""
    layout = subject.layout
    sides = [[v.name for v in layout.block(side)] for side in ("input", "output")]
    height = 24 * max(3, *map(len, sides)) + 20
    svg = E.svg(viewBox=f"0 0 {WIDTH} {height}", width=str(WIDTH))
    svg.append(_box(200, 10, WIDTH - 400, height - 20))
    svg.append(_text(WIDTH / 2, height / 2, subject.model.name, "middle"))
    for side, names in enumerate(sides):
        for i, name in enumerate(names):
            y = 26 + 24 * i
            at = 150 if side == 0 else WIDTH - 200
            svg.append(_line(f"{at},{y} {at + 50},{y}", "#444"))
            tip = f"{at + 44},{y - 4} {at + 50},{y} {at + 44},{y + 4}"
            svg.append(_line(tip, "#444"))
            place = (at - 8, "end") if side == 0 else (at + 58, "start")
            svg.append(_text(place[0], y + 4, name, place[1]))
    return svg


def curves(found: Response) -> Any:
    """Return a picture of up to four outputs, each over its own range."""
    moving = [i for i in range(len(found.names)) if np.ptp(found.rows[:, i]) > 0]
    shown = (moving or list(range(len(found.names))))[: len(COLOURS)]
    svg = E.svg(viewBox=f"0 0 {WIDTH} {HEIGHT}", width=str(WIDTH))
    svg.append(_box(LEFT, 10, WIDTH - LEFT - 10, HEIGHT - 50))
    for n, i in enumerate(shown):
        y = found.rows[:, i]
        low, span = float(np.min(y)), float(np.ptp(y)) or 1.0
        x = LEFT + (WIDTH - LEFT - 10) * found.times / found.times[-1]
        down = HEIGHT - 45 - (HEIGHT - 60) * (y - low) / span
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, down, strict=True))
        svg.append(_line(points, COLOURS[n]))
        text = f"{found.names[i]}: {np.min(y):.3g} … {np.max(y):.3g}"
        svg.append(_text(LEFT + 140 * n, HEIGHT - 4, text, "start", COLOURS[n]))
    ends = f"0 … {1e3 * found.times[-1]:g} ms"
    svg.append(_text(WIDTH - 10, HEIGHT - 24, ends, "end"))
    return svg


def _box(x: float, y: float, width: float, height: float) -> Any:
    size = {"x": f"{x:g}", "y": f"{y:g}", "width": f"{width:g}"}
    return E.rect(size, height=f"{height:g}", fill="none", stroke="#444")


def _line(points: str, colour: str) -> Any:
    return E.polyline(points=points, fill="none", stroke=colour)


def _text(x: float, y: float, text: str, anchor: str, colour: str = "#222") -> Any:
    where = {"x": f"{x:g}", "y": f"{y:g}", "text-anchor": anchor, "fill": colour}
    return E.text(text, where, {"font-size": "12"})


def icon(subject: Subject) -> bytes:
    """Return the model's block as an SVG file."""
    svg = block(subject)
    svg.set("xmlns", "http://www.w3.org/2000/svg")
    document: bytes = etree.tostring(svg, xml_declaration=True, encoding="UTF-8")
    return document
