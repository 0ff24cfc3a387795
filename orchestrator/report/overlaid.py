"""Signals of kept runs over each other, the differences to the first below.

A difference is taken at the instants that both have rows for, in the unit of the
first: nothing is interpolated.
"""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

import numpy as np

from fmus.units import UnitError
from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.quantities.quantity import converter
from orchestrator.report.facts import table
from orchestrator.report.figure import drawn
from orchestrator.report.panels import Curve, Panel
from orchestrator.report.shell import signals, written
from orchestrator.result import Result, Signal

MOST = 16  # signals in a page; more are drawn when they are named

Rows = Sequence[Sequence[str]]


def write_overlaid(
    title: str,
    results: Mapping[str, Result],
    tables: Sequence[tuple[str, Sequence[str], Rows]],
    path: Path,
    wanted: Sequence[str] = (),
) -> Path:
    """Write the page of runs compared and return its path.

    ``tables`` are shown first, each a heading, a head and rows of text; ``wanted``
    are the signals drawn, else those that two runs have.

    Raises:
        ScenarioError: a signal that is wanted was recorded in none.
    """
    parts = []
    for heading, head, rows in tables:
        shown = [[escape(cell) for cell in row] for row in rows]
        parts += [f"<h2>{escape(heading)}</h2>", table(head, shown)]
    panels, left = overlaid(results, wanted)
    if panels:
        parts += ["<h2>Signals</h2>", signals(drawn(panels, overlaid=True))]
    if left:
        told = f"Not drawn: {', '.join(left)}. Name those you want to see."
        parts.append(f"<p>{escape(told)}</p>")
    return written(title, parts, path)


def overlaid(
    results: Mapping[str, Result], wanted: Sequence[str] = ()
) -> tuple[list[Panel], list[str]]:
    """Return the panels of runs over each other, and the signals that have none.

    Raises:
        ScenarioError: a signal that is wanted was recorded in none.
    """
    names, left = _chosen(results, wanted)
    return [p for name in names for p in _panels(name, results)], left


def write_plotted(title: str, result: Result, names: Sequence[str], path: Path) -> Path:
    """Write the page of some signals of a run, a panel per unit; return its path.

    Raises:
        ScenarioError: a signal was not recorded.
    """
    found = [_signal(name, result) for name in names]
    by_unit: dict[str, list[Signal]] = {}
    for signal in found:
        by_unit.setdefault(str(signal.unit), []).append(signal)
    panels = [
        Panel(
            ", ".join(s.name for s in same),
            unit,
            [Curve(s.name, s.time, s.values.astype(float), 0) for s in same],
        )
        for unit, same in by_unit.items()
    ]
    return written(title, [signals(drawn(panels, overlaid=False))], path)


def _signal(name: str, result: Result) -> Signal:
    if name not in result:
        raise ScenarioError(f"{name} was not recorded; {did_you_mean(name, result)}")
    return result[name]


def _chosen(
    results: Mapping[str, Result], wanted: Sequence[str]
) -> tuple[list[str], list[str]]:
    """Return the signals to draw and those left out."""
    counted: dict[str, int] = {}
    for result in results.values():
        for name in result:
            counted[name] = counted.get(name, 0) + 1
    for name in wanted:
        if name not in counted:
            raise ScenarioError(
                f"{name} was recorded in none of these; {did_you_mean(name, counted)}"
            )
    least = min(2, len(results))
    both = list(wanted) or [name for name, n in counted.items() if n >= least]
    return both[: len(wanted) or MOST], both[len(wanted) or MOST :]


def _panels(name: str, results: Mapping[str, Result]) -> list[Panel]:
    having = {label: r[name] for label, r in results.items() if name in r}
    first = next(iter(having.values()))
    over = Panel(name, first.unit)
    below = Panel(f"{name}: difference to {next(iter(having))}", first.unit)
    order, few = list(results), list[int]()
    for label, signal in having.items():
        run = order.index(label)
        values = signal.values.astype(float)
        try:
            values = converter(signal.unit, first.unit)(values)
        except UnitError as error:
            over.title += f" ({label} is not drawn: {error})"
            continue
        over.curves.append(Curve(label, signal.time, values, run))
        if signal is first:
            continue
        time, here, there = np.intersect1d(
            signal.time, first.time, assume_unique=True, return_indices=True
        )
        if not len(time):
            over.title += f" ({label} has no instant in common with the first)"
            continue
        apart = values[here] - first.values.astype(float)[there]
        below.curves.append(Curve(f"{label} - first", time, apart, run))
        if not len(time) == len(signal.time) == len(first.time):
            below.title += f", at {len(time):,} common instants"
            few.append(len(time))
    if below.curves and not any(np.any(curve.values) for curve in below.curves):
        whole = not few and len(below.curves) == len(having) - 1
        over.title += ": all equal" if whole else f": equal{_where(few)}"
        return [over]
    return [over, below] if below.curves else [over]


def _where(common: Sequence[int]) -> str:
    """Say at how few instants signals were compared, where it was not at all."""
    if not common:
        return ""
    few = min(common)
    return f" at {few:,} common {'instant' if few == 1 else 'instants'}, no others"
