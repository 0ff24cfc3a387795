"""In which order sampled components run at one instant.

A component that some output of which depends directly on an input must run
after the component driving that input: a circle of such edges is refused.  An
input that feeds no output through is ordered likewise where possible, else it
waits for its source's next tick, which is reported.  A latency cuts its edges.  The
members of a group that is iterated run as one.
"""

from collections.abc import Iterable, Mapping
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise

from orchestrator.errors import WiringError
from orchestrator.master.layout import Edge, Wiring

ALONE: Mapping[str, str] = {}


def running_order(wiring: Wiring) -> tuple[tuple[str, ...], frozenset[Edge]]:
    """Return the sampled components in order, and the edges that must wait.

    Raises:
        WiringError: sampled components feed through in a circle.
    """
    sampled = [n for n, p in wiring.parts.items() if p.kind == "sampled"]
    first = {n: g.members[0] for g in wiring.groups for n in g.members}
    edges = [
        e
        for e in wiring.edges
        if e.source in sampled
        and e.sink in sampled
        and not wiring.parts[e.source].component.latency
        and (e.source not in first or first[e.source] != first.get(e.sink))
    ]
    hard = [e for e in edges if wiring.parts[e.sink].fmu.feeds_through(e.input)]
    try:
        order = _sorted(sampled, hard, first)
    except CycleError as error:
        raise WiringError(_loop(error.args[1], hard, first)) from None
    kept, waiting = list(hard), []
    for edge in edges:
        if edge in hard:
            continue
        try:
            order = _sorted(sampled, [*kept, edge], first)
            kept.append(edge)
        except CycleError:
            waiting.append(edge)
    members = {g.members[0]: g.members for g in wiring.groups}
    whole = (n for one in order for n in members.get(one, (one,)))
    return tuple(whole), frozenset(waiting)


def _sorted(
    names: Iterable[str], edges: Iterable[Edge], first: Mapping[str, str] = ALONE
) -> tuple[str, ...]:
    """Return the names in an order; ``first`` stands for all members of a group."""
    before: dict[str, set[str]] = {first.get(name, name): set() for name in names}
    for edge in edges:
        sink, source = first.get(edge.sink, edge.sink), edge.source
        before[sink].add(first.get(source, source))
    return tuple(TopologicalSorter(before).static_order())


def _loop(cycle: list[str], edges: Iterable[Edge], first: Mapping[str, str]) -> str:
    """Describe a circle; graphlib lists it source first, its first name twice."""
    steps = set(pairwise(cycle))
    ends = [(first.get(e.source, e.source), first.get(e.sink, e.sink)) for e in edges]
    around = [e for e, pair in zip(edges, ends, strict=True) if pair in steps]
    listed = ", ".join(f"{e.source}.{e.output} -> {e.sink}.{e.input}" for e in around)
    return (
        f"sampled components feed through in a circle within one instant: {listed}; "
        f"give one of them latency = 1 (what it computes is then published one sample "
        f"later), for instance components.{cycle[0]}.latency = 1, or put them into a "
        f"group with iterate = true"
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
