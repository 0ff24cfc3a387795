"""How a response is printed, and the page it gets."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from orchestrator.cli.output import print_table
from orchestrator.report.responded import (
    Curve,
    Style,
    Trace,
    write_responded,
    write_transfers,
)
from orchestrator.response.figures import latencies, words
from orchestrator.response.measured import Measured, Response, Transfer
from orchestrator.response.traced import Traced

if TYPE_CHECKING:
    from orchestrator.response.expected import Responded
    from orchestrator.scenario.compose import Composition

LATENCY = ["samples more", ">phase margin (deg)", ">gain margin (dB)", ">s_max"]
LOOPS = ["loop", "at (Hz)", ">margin"]
WAYS = ["from", "to", ">largest", "unit", ">at (Hz)", ">bandwidth (Hz)"]
Table = tuple[Sequence[str], Sequence[Sequence[str]]]


def title(one: Measured) -> str:
    """Return what was measured, in short."""
    excited = ", ".join(one.breaks)
    if isinstance(one, Transfer):
        return f"{excited} to {', '.join(one.observed)}"
    return excited


def print_response(
    composition: "Composition", name: str, one: Measured, found: "Responded"
) -> None:
    """Print a response's figures, margins and words."""
    rows = [
        [key.rpartition(".")[2], f"{q.value:.5g}", "" if q.unit == "1" else str(q.unit)]
        for key, q in found.figures.items()
        if key.rpartition(".")[0] == name
    ]
    heading = f"{composition.scenario.name}: {title(one)}"
    if rows:
        print_table(["figure", ">value", "unit"], rows, heading)
    for head, cells in _tables(one):
        print_table(head, cells)
    for line in words(one):
        typer.echo(line)


def _tables(one: Measured) -> Iterator[Table]:
    if isinstance(one, Transfer):
        yield WAYS, list(_ways(one))
    if isinstance(one, Response):
        yield LOOPS, list(_margin_rows(one))
        if len(one.breaks) == 1:
            yield LATENCY, _latency_rows(one)


def _ways(one: Transfer) -> Iterator[list[str]]:
    for j, excited in enumerate(one.breaks):
        for i, observed in enumerate(one.observed):
            size, hz = one.peak(i, j)
            bandwidth = f"{one.bandwidth_hz(i, j):.4g}"
            unit = str(one.unit(i, j))
            yield [excited, observed, f"{size:.5g}", unit, f"{hz:.4g}", bandwidth]


def _margin_rows(one: Response) -> Iterator[list[str]]:
    named = list(zip(one.breaks, one.loops, strict=True))
    if len(named) > 1:
        named += [
            (f"all alike, eigenvalue {i}", locus)
            for i, locus in enumerate(one.together, 1)
        ]
    for name, loop in named:
        for c in loop.crossovers:
            yield [name, f"{c.hz:.4g}", f"{c.phase_margin_deg:.4g} deg"]
        for g in loop.gain_margins:
            yield [name, f"{g.hz:.4g}", f"{g.db:.4g} dB"]


def _latency_rows(one: Response) -> list[list[str]]:
    return [
        [
            f"{row['samples']:+d}",
            f"{row['phase_margin_deg']:.4g}",
            f"{row['gain_margin_db']:.4g}",
            f"{row['s_max']:.4g}" if row["s_max"] < float("inf") else "unstable",
        ]
        for row in latencies(one)
    ]


def write_page(
    composition: "Composition",
    name: str,
    one: Measured,
    before: "Responded | None",
    beside: tuple[Traced | None, str],
    path: Path,
) -> None:
    """Write the page of a response; ``before`` is the one without a swap."""
    heading = f"{composition.scenario.name}: {title(one)}"
    told = [*words(one), beside[1]]
    tables = [
        ([h.removeprefix(">") for h in head], cells) for head, cells in _tables(one)
    ]
    found: list[tuple[str, Measured, Style]] = [("", one, "own")]
    if before:
        found = [("after ", one, "own"), ("before ", before.responses[name], "other")]
    if isinstance(one, Transfer):
        traces = _traces(found, beside[0], one)
        write_transfers(heading, told, tables, traces, path)
    if isinstance(one, Response):
        write_responded(
            heading,
            told,
            tables,
            _curves(found, beside[0], one),
            dict(_borders(composition, name)),
            path,
            _loci(one) if len(one.breaks) > 1 else [],
        )


def _traces(
    found: Sequence[tuple[str, Measured, Style]], traced: Traced | None, one: Transfer
) -> list[Trace]:
    ways = [
        (f"{excited} to {observed}", i, j)
        for j, excited in enumerate(one.breaks)
        for i, observed in enumerate(one.observed)
    ]
    traces = [
        Trace(label + way, r.hz, r.G[:, i, j], style)
        for label, r, style in found
        if isinstance(r, Transfer)
        for way, i, j in ways
    ]
    if traced:
        G = traced.G
        traces += [
            Trace(f"equations, {way}", one.hz, G[:, i, j], "traced")
            for way, i, j in ways
        ]
    return traces


def _curves(
    found: Sequence[tuple[str, Measured, Style]], traced: Traced | None, one: Response
) -> list[Curve]:
    curves = [
        Curve.of(f"{label}{broken}", r.hz, 1 / r.S[:, i, i] - 1, style)
        for label, r, style in found
        if isinstance(r, Response)
        for i, broken in enumerate(r.breaks)
    ]
    if traced:
        for i, broken in enumerate(one.breaks):
            S = 1 + traced.G[:, i, i]
            curves.append(Curve.of(f"equations, {broken}", one.hz, 1 / S - 1, "traced"))
    return curves


def _loci(one: Response) -> list[Trace]:
    return [
        Trace(f"eigenvalue {i}", one.hz, locus) for i, locus in enumerate(one.loci.T, 1)
    ]


def _borders(composition: "Composition", name: str) -> Iterator[tuple[str, float]]:
    expect = composition.scenario.spec.expect
    for figure, turned in ((f"{name}.s_max", False), (f"{name}.modulus_margin", True)):
        if figure in expect:
            e = expect[figure]
            for level in (e.above, e.below):
                if level:
                    yield f"{figure} {level:g}", 1 / level if turned else level
