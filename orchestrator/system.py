"""What is simulated: components, connections, rates.  Frozen data, no behaviour.

A variable is written ``component.variable``; the component ends at the first
dot, the rest is the FMU's own name (or the name its ``map`` gives it).
All times are exact fractions of a second.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Literal, TypeAlias

Scalar: TypeAlias = float | bool | str


class Rows(tuple[Scalar, ...]):
    """An array that is written as rows: its values in their order, and its shape."""

    shape: tuple[int, ...]

    def __new__(cls, values: Iterable[Scalar], shape: tuple[int, ...] = ()) -> "Rows":
        made = super().__new__(cls, values)
        made.shape = shape
        return made


Value: TypeAlias = Scalar | tuple[Scalar, ...]
Kind: TypeAlias = Literal["continuous", "sampled"]
Interface: TypeAlias = Literal["co_simulation", "model_exchange"]
Range: TypeAlias = Literal["saturate", "wrap"]
FaultKind: TypeAlias = Literal[
    "stuck", "bias", "gain", "delay", "quantisation", "override"
]


@dataclass(frozen=True)
class Mapped:
    """A foreign FMU's variable under our name.

    In the direction of the signal: what reaches the FMU's input or parameter is
    gain * ours + offset, what we read of its output is gain * theirs + offset.
    ``unit`` is that of our side; without it the FMU's own unit is kept.  With a unit
    and no gain the FMU's unit is converted to it.  ``range`` is for integer inputs:
    what reaches them is rounded to the nearest whole number (half a one upwards) and
    held at the end of their range, or counted on from its other end.  ``table`` are the
    whole numbers (or 0 and 1) that an input may be given, and what it gets for each.
    """

    name: str
    gain: float | None = None
    offset: float | None = None
    unit: str | None = None
    range: Range | None = None
    table: tuple[tuple[int, int], ...] | None = None


@dataclass(frozen=True)
class Isolation:
    """Whether an FMU runs in a process of its own, and what it may take there.

    ``process`` None means: if it is not ours or needs an execution tool.  A process
    in a ``sandbox`` may read programs and write in the folder of its FMU, no more; one
    that does not answer within ``answer_within`` seconds is killed; ``memory_limit``
    (bytes) is what it may take besides Python (not enforced on Windows and macOS).
    """

    process: bool | None = None
    answer_within: float = 60.0
    memory_limit: float | None = None
    sandbox: bool = False


@dataclass(frozen=True)
class Experiment:
    """What of the experiment an FMU is told besides its start: the stop time of the
    run, a relative tolerance; what it does not need it is not told unasked.
    """

    stop: bool = False
    tolerance: float | None = None


@dataclass(frozen=True)
class Component:
    """One FMU instance and when it is stepped.

    ``kind`` None means: as the FMU says, or continuous if it says nothing.
    ``latency`` (whole samples) is for sampled components only.  ``split`` False
    holds the inputs of a continuous component over its own step, whatever is
    published inside; None means: split it there, if the FMU allows that.
    ``interface`` None means: co-simulation where the FMU has it.
    """

    name: str
    fmu: Path
    period: Fraction
    offset: Fraction = Fraction(0)
    latency: int = 0
    kind: Kind | None = None
    parameters: Mapping[str, Value] = field(default_factory=dict)
    start: Mapping[str, Value] = field(default_factory=dict)
    map: Mapping[str, Mapped] = field(default_factory=dict)
    isolation: Isolation = Isolation()
    experiment: Experiment = Experiment()
    split: bool | None = None
    interface: Interface | None = None

    @property
    def values(self) -> Mapping[str, Value]:
        """Parameters and start values together."""
        return {**self.parameters, **self.start}


@dataclass(frozen=True)
class Fault:
    """What goes wrong on a connection while start <= t < end (s; None: for ever).

    ``value``, in the unit of the input, is what is added (bias) or given instead
    (override), the factor (gain) or the quantum (quantisation); ``samples`` of the
    source are what ``delay`` waits.
    """

    kind: FaultKind
    value: float = 0.0
    samples: int = 0
    start: Fraction = Fraction(0)
    end: Fraction | None = None


@dataclass(frozen=True)
class Injection:
    """What is added to an input, in its unit: value i mod n at publication i.

    Publications are those of the source of its connection, after a latency, counted
    from its offset; of an input that no connection drives its component's own
    instants, and the values are added to what it starts with.
    """

    values: tuple[float, ...]


@dataclass(frozen=True)
class Iterated:
    """Components whose inputs from one another are made to agree at every instant, up
    to ``tolerance`` of a number, or of 1 if that is more.
    """

    components: tuple[str, ...]
    tolerance: float = 1e-9


@dataclass(frozen=True)
class System:
    """A composition of FMUs over the closed interval [0, stop].

    ``connections`` are keyed by the sink, so that no input is driven twice.
    ``record`` gives the row periods of every recorded variable.  ``faults``, by the
    sink of a connection, act in the order they are written.  ``injections``, by the
    input, are added before faults act.  ``groups`` are iterated, by their names.
    """

    name: str
    stop: Fraction
    components: Mapping[str, Component]
    connections: Mapping[str, str]
    record: Mapping[str, tuple[Fraction, ...]]
    faults: Mapping[str, tuple[Fault, ...]] = field(default_factory=dict)
    injections: Mapping[str, Injection] = field(default_factory=dict)
    groups: Mapping[str, Iterated] = field(default_factory=dict)


def split_name(variable: str) -> tuple[str, str]:
    """Split ``component.variable`` at its first dot."""
    component, _, name = variable.partition(".")
    return component, name
