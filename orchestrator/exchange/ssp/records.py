"""What a system structure description says, as frozen records.

Numbers of a parameter stay text until their variable is known: ``Given.words``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from orchestrator.quantities.unit import Unit

Linear: TypeAlias = tuple[str, str]  # factor and offset, as they are written


@dataclass(frozen=True)
class Looked:
    """A mapping of single values of a ``type``: Boolean, Integer or Enumeration."""

    type: str
    pairs: tuple[tuple[str, str], ...]


Transformation: TypeAlias = Linear | Looked


@dataclass(frozen=True)
class Connector:
    """A connector; ``type`` is "" and ``unit`` None where the file says nothing."""

    name: str
    kind: str
    type: str = ""
    unit: Unit | None = None


@dataclass(frozen=True)
class Given:
    """A parameter of a set: its type, its value as words, its unit."""

    name: str
    type: str
    words: tuple[str, ...]
    unit: Unit | None = None


@dataclass(frozen=True)
class Mapped:
    """An entry of a mapping: which parameter goes where, and how."""

    source: str
    target: str
    how: Transformation | None = None
    suppress: bool = False


@dataclass(frozen=True)
class Binding:
    """Parameters bound to an element, prefix included; ``mapping`` None: by name."""

    where: str
    given: tuple[Given, ...]
    mapping: tuple[Mapped, ...] | None = None


@dataclass(frozen=True)
class End:
    """One end of a connection; ``element`` None is the system's own border."""

    element: str | None
    connector: str


@dataclass(frozen=True)
class Connection:
    """A connection as it is written, whichever way the signal flows."""

    start: End
    end: End
    how: Transformation | None
    suppress: bool
    where: str


@dataclass(frozen=True)
class Part:
    """A component: its FMU, how it is to be run, a step (s) of its own if any."""

    name: str
    connectors: Mapping[str, Connector]
    bindings: tuple[Binding, ...]
    fmu: Path | None
    implementation: str
    step: str | None
    description: str = ""


@dataclass(frozen=True)
class Reference:
    """A place in a system at which the signals of a dictionary are reached."""

    name: str
    dictionary: str
    connectors: Mapping[str, Connector]


@dataclass(frozen=True)
class Nested:
    """A system; ``step`` (s) is that of its master where an annotation says one.

    ``dictionaries`` are the signals of each, which all references to it share.
    """

    name: str
    connectors: Mapping[str, Connector]
    bindings: tuple[Binding, ...]
    elements: "Mapping[str, Part | Nested | Reference]"
    connections: tuple[Connection, ...]
    step: str | None
    description: str = ""
    dictionaries: Mapping[str, Mapping[str, Connector]] = field(default_factory=dict)


@dataclass(frozen=True)
class Timing:
    """Our own annotation: the exact stop, each component's times, the file of the
    rest."""

    stop: str
    scenario: str
    components: Mapping[str, Mapping[str, str]]


@dataclass(frozen=True)
class Structure:
    """A whole description; ``faults`` name what cannot be run, ``notes`` the rest."""

    name: str
    version: str
    system: Nested
    start: str | None
    stop: str | None
    timing: Timing | None
    faults: tuple[str, ...]
    notes: tuple[str, ...] = ()
    others: tuple[str, ...] = field(default_factory=tuple)
    root: Any = None
