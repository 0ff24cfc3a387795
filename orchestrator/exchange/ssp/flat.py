"""A tree of systems as components and edges between their connectors.

An edge is turned so that the signal flows along it, by the kinds of its ends: seen
from the system in which it is written, an input of an element and an output of the
system itself are fed, the rest feed.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from orchestrator.exchange.ssp.records import Connection, Connector, End, Nested, Part

Path: TypeAlias = tuple[str, ...]
Node: TypeAlias = tuple[Path, str]  # an element and one of its connectors


@dataclass(frozen=True)
class Edge:
    """A connection in the direction of its signal."""

    source: Node
    sink: Node
    written: Connection


@dataclass
class Flat:
    """Components by their path, systems likewise, and what feeds each connector."""

    parts: dict[Path, Part] = field(default_factory=dict)
    systems: dict[Path, Nested] = field(default_factory=dict)
    fed: dict[Node, Edge] = field(default_factory=dict)
    feeds: dict[Node, list[Edge]] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    def connector(self, node: Node) -> Connector | None:
        """Return what is declared of a connector, None if nothing is."""
        path, name = node
        owner = self.parts.get(path) or self.systems.get(path)
        return None if owner is None else owner.connectors.get(name)

    def way(self, sink: Node) -> list[Edge]:
        """Return the edges that lead to a connector, from their source on."""
        edges: list[Edge] = []
        while (edge := self.fed.get(sink)) is not None and edge not in edges:
            edges.append(edge)
            sink = edge.source
            if sink[0] in self.parts:
                break
        return edges[::-1]

    def ends(self, node: Node) -> Iterator[list[Edge]]:
        """Yield every way from a connector of a system on to one of a component."""
        for edge in self.feeds.get(node, ()):
            if edge.sink[0] in self.parts:
                yield [edge]
            else:
                for way in self.ends(edge.sink):
                    yield [edge, *way]


def flatten(system: Nested) -> Flat:
    """Return the components and edges of a system and of all inside it."""
    flat = Flat()
    _collect(flat, system, ())
    for path, one in flat.systems.items():
        for connection in one.connections:
            _add(flat, path, one, connection)
    return flat


def _collect(flat: Flat, system: Nested, path: Path) -> None:
    flat.systems[path] = system
    for name, element in system.elements.items():
        place = (*path, name)
        if isinstance(element, Nested):
            _collect(flat, element, place)
        else:
            flat.parts[place] = element


def _add(flat: Flat, path: Path, system: Nested, written: Connection) -> None:
    roles = []
    for end in (written.start, written.end):
        if end.element is not None and end.element not in system.elements:
            flat.faults.append(f"{written.where}: there is no element {end.element!r}")
            return
        connector = flat.connector(_node(path, end))
        if connector is None:
            flat.faults.append(
                f"{written.where}: there is no connector {end.connector!r}"
            )
            return
        roles.append(_role(connector.kind, end))
    first, last = _node(path, written.start), _node(path, written.end)
    if "" in roles:
        flat.faults.append(
            f"{written.where}: connectors of kind inout belong to signal dictionaries, "
            f"which are not carried out"
        )
        return
    if roles == ["both", "both"]:
        roles = ["feeds", "fed"]
    other = {"feeds": "fed", "fed": "feeds"}
    roles = [
        other[roles[1 - n]] if role == "both" else role for n, role in enumerate(roles)
    ]
    if roles[0] == roles[1]:
        both = "feed" if roles[0] == "feeds" else "are fed"
        flat.faults.append(f"{written.where}: both ends {both}")
        return
    backwards = roles[0] == "fed"
    if backwards and written.linear is not None:
        flat.faults.append(
            f"{written.where}: is written against its signal and has a "
            f"transformation, which may be meant either way; turn it round"
        )
        return
    edge = Edge(last, first, written) if backwards else Edge(first, last, written)
    if (earlier := flat.fed.get(edge.sink)) is not None:
        flat.faults.append(
            f"{written.where}: feeds what {earlier.written.where} feeds already"
        )
        return
    flat.fed[edge.sink] = edge
    flat.feeds.setdefault(edge.source, []).append(edge)


def _node(path: Path, end: End) -> Node:
    return (path if end.element is None else (*path, end.element)), end.connector


def _role(kind: str, end: End) -> str:
    """Return whether an end feeds a connection or is fed by it, "" for neither.

    The parameter of an element is fed by whatever feeds, else it feeds another.
    """
    if end.element is None:
        inner = {"input": "feeds", "parameter": "feeds"}
        outer = {"output": "fed", "calculatedParameter": "fed"}
    else:
        inner = {"output": "feeds", "calculatedParameter": "feeds"}
        outer = {"input": "fed", "parameter": "both"}
    return {**inner, **outer}.get(kind, "")
