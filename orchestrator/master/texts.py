"""Texts and bytes on connections: String to String, Binary to Binary, as they are.

A text is published with the numbers of its component and given to a reader with the
numbers that are written to it; between, it is held.  Texts are not recorded, and no
latency, fault or map acts on them.
"""

from collections.abc import Iterator, Mapping, Sequence

from orchestrator.errors import WiringError
from orchestrator.fmu.typed import Held
from orchestrator.instances.protocol import Instance
from orchestrator.master.layout import Link, Said, Wiring
from orchestrator.system import System


def texts_of(system: System, links: Sequence[Link]) -> Iterator[Said]:
    """Yield the texts that travel.

    Raises:
        WiringError: only a part of an array is connected, or a latency or an iterated
            group would act on a text.
    """
    found: dict[Said, list[tuple[int, int]]] = {}
    for source, sink, _ in links:
        if source.variable.is_text:
            ends = source.component, source.variable, sink.component, sink.variable
            pairs = found.setdefault(Said(*ends), [])
            pairs.append((source.element, sink.element))
    for said, pairs in found.items():
        every = [(i, i) for i in range(said.input.size)]
        if pairs != every or said.output.size != said.input.size:
            raise WiringError(
                f"{said.ends}: connects some of several texts; connect arrays of texts "
                f"as a whole"
            )
        if said.input.causality != "input":
            raise WiringError(
                f"{said.ends}: {said.input.name} is a {said.input.causality}, and "
                f"texts travel to inputs only; set it under parameters"
            )
        if system.components[said.source].latency:
            raise WiringError(
                f"{said.ends}: {said.source} has a latency, which holds no texts back; "
                f"remove the latency or the connection"
            )
        for name, group in system.groups.items():
            if {said.source, said.sink} <= set(group.components):
                raise WiringError(
                    f"{said.ends}: lies inside groups.{name}, which iterates numbers "
                    f"only; leave the group or the connection out"
                )
        yield said


def publish(wiring: Wiring, instances: Mapping[str, Instance], name: str) -> None:
    """Hand what a component says, while all initialise, to those that read it."""
    for said in wiring.texts:
        if said.source == name:
            values = instances[name].read([said.output])
            instances[said.sink].write([said.input], values)


class Texts:
    """The texts of a run: what was published last, held until it is given."""

    def __init__(self, wiring: Wiring, instances: Mapping[str, Instance]) -> None:
        self._instances = instances
        self._out: dict[str, list[Said]] = {}
        self._in: dict[str, list[Said]] = {}
        for said in wiring.texts:
            self._out.setdefault(said.source, []).append(said)
            self._in.setdefault(said.sink, []).append(said)
        self._held: dict[str, list[Held]] = {}
        for name in self._out:
            self.publish(name)

    def leave(self, name: str) -> bool:
        """Tell whether a component has texts that others read."""
        return name in self._out

    def reach(self, name: str) -> bool:
        """Tell whether a component reads texts of others."""
        return name in self._in

    def publish(self, name: str) -> None:
        """Take what a component says now."""
        for said in self._out[name]:
            self._held[said.ends] = self._instances[name].read([said.output])

    def give(self, name: str) -> None:
        """Give a component what was last said to it."""
        for said in self._in[name]:
            self._instances[name].write([said.input], self._held[said.ends])
