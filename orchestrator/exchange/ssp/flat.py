"""A tree of systems as components and edges between their connectors.

An edge is turned so that the signal flows along it, by the kinds of its ends: seen
from the system in which it is written, an input of an element and an output of the
system itself are fed, the rest feed.  All references to a signal dictionary are one
place, whose signals are fed by whatever feeds and feed the rest.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from orchestrator.exchange.ssp.records import (
    Connection,
    Connector,
    End,
    Nested,
    Part,
    Reference,
)

Path: TypeAlias = tuple[str, ...]
Node: TypeAlias = tuple[Path, str]  # an element and one of its connectors

DICTIONARY = "signal dictionary"


@dataclass(frozen=True)
class Edge:
    """A connection in the direction of its signal."""

    source: Node
    sink: Node
    written: Connection


@dataclass
class Flat:
    """Components by their path, systems likewise, and what feeds each connector.

    A signal dictionary is a system too, at a path that no element has; ``references``
    lead there.
    """

    parts: dict[Path, Part] = field(default_factory=dict)
    systems: dict[Path, Nested] = field(default_factory=dict)
    fed: dict[Node, Edge] = field(default_factory=dict)
    feeds: dict[Node, list[Edge]] = field(default_factory=dict)
    references: dict[Path, Path] = field(default_factory=dict)
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
    _collect(flat, system, (), {})
    for path, one in flat.systems.items():
        for connection in one.connections:
            _add(flat, path, one, connection)
    return flat


def _collect(flat: Flat, system: Nested, path: Path, known: Mapping[str, Path]) -> None:
    """Take a system; ``known`` are the dictionaries of those around it."""
    flat.systems[path] = system
    for name, signals in system.dictionaries.items():
        place = (*path, f"{DICTIONARY} {name}")
        flat.systems[place] = Nested(name, signals, (), {}, (), None)
        known = {**known, name: place}
    for name, element in system.elements.items():
        place = (*path, name)
        if isinstance(element, Nested):
            _collect(flat, element, place, known)
        elif isinstance(element, Reference):
            _refer(flat, element, place, known)
        else:
            flat.parts[place] = element


def _refer(
    flat: Flat, reference: Reference, place: Path, known: Mapping[str, Path]
) -> None:
    where, dictionary = "/".join(place), reference.dictionary
    if dictionary not in known:
        flat.faults.append(
            f"{where}: there is no signal dictionary {dictionary!r} in its system or "
            f"around it"
        )
        return
    target = flat.references[place] = known[dictionary]
    signals = flat.systems[target].connectors
    for name, connector in reference.connectors.items():
        signal = signals.get(name)
        if signal is None:
            flat.faults.append(
                f"{where}: {dictionary} has no signal {name!r}; it has "
                f"{', '.join(signals) or 'none'}"
            )
        elif "" not in (signal.type, connector.type) and signal.type != connector.type:
            flat.faults.append(
                f"{where}: {name} is {connector.type} here and {signal.type} in "
                f"{dictionary}"
            )


def unfed(flat: Flat) -> list[str]:
    """Return the signals of dictionaries that are read and that nothing feeds."""
    return [
        f"{path[-1]}: nothing feeds its signal {name!r}, what reads it keeps what it "
        f"starts with"
        for path, name in flat.feeds
        if path in flat.references.values() and (path, name) not in flat.fed
    ]


def _add(flat: Flat, path: Path, system: Nested, written: Connection) -> None:
    roles = []
    for end in (written.start, written.end):
        if end.element is not None and end.element not in system.elements:
            flat.faults.append(f"{written.where}: there is no element {end.element!r}")
            return
        node = _node(flat, path, end)
        connector = flat.connector(node)
        if connector is None and end.element in _unknown(flat, path, system):
            return  # which is said already
        if connector is None:
            flat.faults.append(
                f"{written.where}: there is no connector {end.connector!r}"
            )
            return
        of_dictionary = node[0] in flat.references.values()
        roles.append("both" if of_dictionary else _role(connector.kind, end))
    first, last = (_node(flat, path, end) for end in (written.start, written.end))
    if "" in roles:
        flat.faults.append(
            f"{written.where}: connectors of kind inout are those of references to "
            f"signal dictionaries; give it one of input or output"
        )
        return
    if roles == ["both", "both"]:
        if any(node[0] in flat.references.values() for node in (first, last)):
            flat.faults.append(
                f"{written.where}: both ends could feed or be fed, and SSP does not "
                f"say which does; connect the elements directly"
            )
            return
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
    if backwards and written.how is not None:
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


def _node(flat: Flat, path: Path, end: End) -> Node:
    place = path if end.element is None else (*path, end.element)
    return flat.references.get(place, place), end.connector


def _unknown(flat: Flat, path: Path, system: Nested) -> set[str]:
    """Return the references of a system to dictionaries that are not there."""
    return {
        name
        for name, element in system.elements.items()
        if isinstance(element, Reference) and (*path, name) not in flat.references
    }


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
