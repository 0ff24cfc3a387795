"""In which order sampled components run at one instant.

A component that some output of which depends directly on an input must run
after the component driving that input: a circle of such edges is refused.  An
input that feeds no output through is ordered likewise where possible, else it
waits for its source's next tick, which is reported.  A latency cuts its edges.
"""

from collections.abc import Iterable
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise

from orchestrator.errors import WiringError
from orchestrator.master.layout import Edge, Wiring


def running_order(wiring: Wiring) -> tuple[tuple[str, ...], frozenset[Edge]]:
    """Return the sampled components in order, and the edges that must wait.

    Raises:
        WiringError: sampled components feed through in a circle.
    """
    sampled = [n for n, p in wiring.parts.items() if p.kind == "sampled"]
    edges = [
        e
        for e in wiring.edges
        if e.source in sampled
        and e.sink in sampled
        and not wiring.parts[e.source].component.latency
    ]
    hard = [e for e in edges if wiring.parts[e.sink].fmu.feeds_through(e.input)]
    try:
        order = _sorted(sampled, hard)
    except CycleError as error:
        raise WiringError(_loop(error.args[1], hard)) from None
    kept, waiting = list(hard), []
    for edge in edges:
        if edge in hard:
            continue
        try:
            order = _sorted(sampled, [*kept, edge])
            kept.append(edge)
        except CycleError:
            waiting.append(edge)
    return order, frozenset(waiting)


def _sorted(names: Iterable[str], edges: Iterable[Edge]) -> tuple[str, ...]:
    before: dict[str, set[str]] = {name: set() for name in names}
    for edge in edges:
        before[edge.sink].add(edge.source)
    return tuple(TopologicalSorter(before).static_order())


def _loop(cycle: list[str], edges: Iterable[Edge]) -> str:
    """Describe a circle; graphlib lists it source first, its first name twice."""
    steps = set(pairwise(cycle))
    around = [e for e in edges if (e.source, e.sink) in steps]
    listed = ", ".join(f"{e.source}.{e.output} -> {e.sink}.{e.input}" for e in around)
    return (
        f"sampled components feed through in a circle within one instant: {listed}; "
        f"give one of them latency = 1 (what it computes is then published one sample "
        f"later), for instance components.{cycle[0]}.latency = 1"
    )


def initial_order(wiring: Wiring) -> tuple[tuple[str, ...], tuple[Edge, ...]]:
    """Return an order of all components for initialisation, and the edges left out.

    Only edges into inputs that feed an initial output through count.  Circles
    are opened at one edge each; those edges are unknowns to be solved for.
    """
    edges = [
        e
        for e in wiring.edges
        if wiring.parts[e.sink].fmu.feeds_through_initially(e.input)
    ]
    opened: list[Edge] = []
    while True:
        try:
            return _sorted(wiring.parts, edges), tuple(opened)
        except CycleError as error:
            steps = set(pairwise(error.args[1]))
            first = next(e for e in edges if (e.source, e.sink) in steps)
            again = [
                e for e in edges if (e.source, e.sink) == (first.source, first.sink)
            ]
            opened += again
            edges = [e for e in edges if e not in again]
