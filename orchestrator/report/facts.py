"""What a report says of a run besides its curves, as HTML.

Before the figures: what was changed, every parameter with its value and unit, and
the connections.  After the curves: components, rates, latencies, faults, design
results, FMU digests, and how the variables of foreign FMUs were mapped.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from html import escape
from typing import TYPE_CHECKING

from orchestrator.errors import ScenarioError
from orchestrator.fmu.description import FmuDescription
from orchestrator.fmu.laid import numbers
from orchestrator.fmu.ports import Port, ports
from orchestrator.fmu.whole import Listed
from orchestrator.master.faults import describe
from orchestrator.master.layout import kind_of
from orchestrator.master.simulate import plan
from orchestrator.master.undriven import in_words
from orchestrator.pictures.bundles import wires
from orchestrator.quantities.quantity import rate
from orchestrator.system import Component

if TYPE_CHECKING:
    from orchestrator.outcome import Run

MOST = 300  # parameters of one FMU that are listed though nobody has set them


def what_ran(run: "Run", label: str) -> str:
    """Return what was changed, all parameters and all connections of a run."""
    of = f" of {escape(label)}" if label else ""
    scenario = run.scenario
    changed = [*(f"swap {swap}" for swap in scenario.swapped), *scenario.overrides]
    told = ", ".join(f"<code>{escape(text)}</code>" for text in changed)
    rows = [
        row for name in run.composition.system.components for row in _set(run, name)
    ]
    head = ["parameter", "value", "unit", "from", "description"]
    links = [[escape(cell) for cell in row] for row in _connections(run)]
    taking = ["input", "takes", "unit, gain, fault", "age when taken (us)"]
    return (
        (f"<p>Changed{of}: {told}.</p>" if told else "")
        + _folded(f"Parameters{of}", table(head, rows))
        + _folded(f"Connections{of}", table(taking, links))
    )


def _folded(title: str, content: str) -> str:
    return f"<details><summary>{title}</summary>{content}</details>"


def _connections(run: "Run") -> Iterator[list[str]]:
    """Yield every connection with units, what is done to the value, and its age."""
    for wire in wires(plan(run.composition.system)):
        low, high = (f"{float(t * 10**6):g}" for t in (wire.youngest, wire.oldest))
        age = low if low == high else f"{low} to {high}"
        yield [wire.sink, wire.source, wire.conversion, age]
    for sink, source in run.scenario.spec.connections.items():
        if isinstance(source, int | float):
            held = source
            with suppress(ScenarioError):  # of a star, or what is no number
                held = run.composition.parameter(sink).value
            shown = source if held == source else held
            yield [sink, _short(shown), _unit(run, sink), ""]


def _set(run: "Run", name: str) -> Iterator[list[str]]:
    """Yield the parameters of a component: those set, then those left as they are."""
    composition = run.composition
    component, fmu = composition.system.components[name], composition.fmus[name]
    given = {**component.start, **component.parameters}
    for key, value in given.items():
        known = fmu.variables.get(
            component.map[key].name if key in component.map else key
        )
        yield _row(
            f"{name}.{key}",
            _short(value),
            _unit(run, f"{name}.{key}"),
            _origin(run, name, key),
            known.description if known else "",
        )
    held = {one for key in given for one in numbers(component, fmu, key)}
    left = [
        v
        for v in fmu.variables.values()
        if v.causality in ("parameter", "structuralParameter")
        and not all((v.name, element) in held for element in range(v.size))
    ]
    for v in left[:MOST]:
        words = (v.start or "").split()
        start = words[0] if len(words) == 1 else f"{len(words)} numbers"
        unit = "" if v.unit in (None, "1") else str(v.unit)
        yield _row(f"{name}.{v.name}", start, unit, "FMU", v.description)
    if len(left) > MOST:
        more = f"{len(left) - MOST} more as the FMU has them"
        yield _row(f"{name}: {more}", "", "", "FMU", "")


def _row(*cells: str) -> list[str]:
    return [escape(cell) for cell in cells]


def _unit(run: "Run", name: str) -> str:
    with suppress(ScenarioError):
        unit = run.composition.unit(name)
        return "" if unit == "1" else str(unit)
    return ""


def _origin(run: "Run", component: str, key: str) -> str:
    """Say who gave a value."""
    spec, nominal = run.scenario.spec, run.scenario.nominal
    for table_ in ("parameters", "start"):
        given = getattr(spec.components[component], table_)
        if key in given:
            before = nominal.components.get(component)
            same = before and getattr(before, table_).get(key) == given[key]
            return "scenario" if same else "changed"
    if any(key in found.values for found in run.composition.designs.values()):
        return "design"
    return "scenario"


def computed(run: "Run", label: str) -> str:
    """Return how a run was computed: components, times, faults, designs, maps."""
    system, composition = run.composition.system, run.composition
    rows = [
        [
            escape(c.name),
            f"<code>{escape(composition.sources[c.name])}</code>",
            kind_of(c, composition.fmus[c.name]),
            rate(c.period) + (f", offset {c.offset} s" if c.offset else ""),
            f"{c.latency} sample{'s' * (c.latency != 1)}" if c.latency else "",
            "<br>".join(
                f"{escape(k)} = {escape(_short(v))}" for k, v in c.parameters.items()
            ),
            f"<code>{composition.digests[c.name][:12]}</code>",
        ]
        for c in system.components.values()
    ]
    head = ["component", "model", "kind", "step", "latency", "set", "SHA-256"]
    lines = [f"Simulated {system.stop} s (exactly)."]
    if run.timing is not None:
        lines.append(
            f"Took {run.timing.wall_s:.3g} s for {run.timing.instants:,} instants: "
            f"{run.timing.real_time_factor:.3g} times real time, "
            f"{run.timing.us_per_instant:.3g} us per instant."
        )
    for sink, faults in system.faults.items():
        lines.append(f"Faults of {sink}: {', '.join(map(describe, faults))}.")
    for name, found in composition.designs.items():
        values = ", ".join(f"{k} = {_short(v)}" for k, v in found.values.items())
        lines.append(f"Design {name} ({found.call}): {values}.")
    if held := in_words(composition.undriven):
        lines.append(f"{held[0].upper()}{held[1:]}.")
    lines += [f"{one}." for one in composition.not_taken_over]
    paragraphs = "".join(f"<p>{escape(line)}</p>" for line in lines)
    heading = f"<h2>How it was computed: {escape(label)}</h2>"
    maps = "".join(
        f"<h3>Map of {escape(c.name)} to {escape(composition.sources[c.name])}</h3>"
        f"{_map(c, composition.fmus[c.name])}"
        for c in system.components.values()
        if c.map
    )
    return f"{heading}{table(head, rows)}{paragraphs}{maps}"


def _map(component: Component, fmu: FmuDescription) -> str:
    """Return what passes between our names and a foreign FMU's, each with its unit."""
    rows = []
    for ours in component.map:
        for port in ports(component, fmu, ours):
            theirs = port.variable
            inward = theirs.causality == "input"
            taken, given = (port.name, theirs.name)[:: 1 if inward else -1]
            row = [
                port.name,
                port.unit or "",
                theirs.causality,
                theirs.name,
                theirs.unit or "",
                f"{given} = {_affine(port.gain, taken, port.offset)}{_kept(port)}",
            ]
            rows.append([escape(cell) for cell in row])
    return table(["ours", "unit", "is", "theirs", "unit", "what passes"], rows)


def _kept(port: Port) -> str:
    """Return how a map keeps a whole number in its range."""
    if isinstance(port.whole, Listed):
        pairs = ", ".join(f"{one} → {other}" for one, other in port.whole.pairs)
        return f", looked up: {pairs}"
    if port.whole is None:
        return ""
    law = {"saturate": "held at", "wrap": "counted on from"}[port.whole.law]
    return f", rounded, {law} {port.whole.low:.0f} and {port.whole.high:.0f}"


def _affine(gain: float, name: str, offset: float) -> str:
    """Return gain * name + offset as it is written by hand."""
    term = name if gain == 1 else f"-{name}" if gain == -1 else f"{gain:.9g} {name}"
    return f"{term} {'-' if offset < 0 else '+'} {abs(offset):.9g}" if offset else term


def _short(value: object) -> str:
    if isinstance(value, tuple):
        return f"{len(value)} numbers"
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; cells are HTML, the head is text."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    lines = ("".join(f"<td>{cell}</td>" for cell in row) for row in rows)
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    rows_ = f"<thead><tr>{top}</tr></thead><tbody>{body}</tbody>"
    return f"<div class=wide><table>{rows_}</table></div>"
