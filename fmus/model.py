"""The contract every plant and controller fulfils.

A model is its records and its equations, written once as pure functions of
them.  The same lines are read as NumPy, traced to CasADi and compiled as C.

    continuous   ẋ = f(x, u, p),      y = h(x, u, p)
    sampled      (x⁺, y) = s(x, u, p, T_s)      at every t = k T_s

Records are ``NamedTuple`` classes whose fields are floats, on/off switches
(``bool``), arrays of floats, or records again; a field of a nested record is
called ``outer.inner``, or ``inner`` where the record is ``Included``.
Optional: ``prepare`` computes once per parameter change what is handed to the
equations as their last argument; ``advance`` replaces one Runge-Kutta substep;
``delay`` is exact dead time of an input.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias, TypeVar, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
Record: TypeAlias = Any  # an instance of a NamedTuple class with annotated fields
R = TypeVar("R")


@dataclass(frozen=True)
class Var:
    """Unit (as ``V.s2/rad``; ``1`` if none), meaning and bounds of a field.

    ``constant`` bakes the value into the FMU; ``fixed`` forbids changing a
    parameter once the simulation has started.
    """

    unit: str
    description: str
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    constant: bool = False
    fixed: bool = False


class Included:
    """Marks a record whose fields are named as if they stood in the outer one.

    ``drive: Annotated[Drive, Included()] = Drive()`` gives ``m_1``, not
    ``drive.m_1``, at this place in the order.
    """


class Leaf(NamedTuple):
    """One field of a record, nested names joined by dots."""

    name: str
    var: Var
    value: Any
    boolean: bool


@dataclass(frozen=True)
class Continuous:
    """A plant: ordinary differential equations with outputs.

    ``h_max`` (s) is the longest Runge-Kutta substep; ``delay`` names, per
    delayed input, the parameter that holds its dead time (s).
    """

    name: str
    derivative: Callable[..., Any]
    output: Callable[..., Any]
    state: Record
    input: Record
    parameters: Record
    h_max: float = 1e-5
    prepare: Callable[..., Any] | None = None
    advance: Callable[..., Any] | None = None
    delay: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Sampled:
    """A controller: difference equations run every ``period`` seconds.

    ``period_fixed``: its numbers hold for this period alone, another is refused.
    """

    name: str
    step: Callable[..., Any]
    state: Record
    input: Record
    parameters: Record
    period: Fraction = Fraction(1, 1000)
    prepare: Callable[..., Any] | None = None
    period_fixed: bool = False


Model: TypeAlias = Continuous | Sampled


def leaves(record: Record, prefix: str = "") -> Iterator[Leaf]:
    """Yield every field of a record and of the records nested in it, in order.

    Raises:
        TypeError: a field is neither a record nor annotated with a ``Var``.
    """
    hints = get_type_hints(type(record), include_extras=True)
    for name, value in zip(record._fields, record, strict=True):
        if is_record(value):
            yield from leaves(value, inner_prefix(hints[name], prefix, name))
            continue
        kind, *metadata = get_args(hints[name]) or (None,)
        var = next((m for m in metadata if isinstance(m, Var)), None)
        if var is None:
            raise TypeError(
                f"{type(record).__name__}.{name} has no Var: annotate it as "
                f'Annotated[float, Var("unit", "description")]'
            )
        yield Leaf(prefix + name, var, value, kind is bool)


def inner_prefix(hint: Any, prefix: str, name: str) -> str:
    """Return what stands before the names of a nested record's fields."""
    included = any(isinstance(m, Included) for m in get_args(hint)[1:])
    return prefix if included else f"{prefix}{name}."


def is_record(value: Any) -> bool:
    """Tell a nested record from a number or an array."""
    return isinstance(value, tuple) and hasattr(value, "_fields")


def size(record: Record) -> int:
    """Count the numbers in a record."""
    return sum(int(np.size(leaf)) for leaf in flat(record))


def flat(record: Record) -> Iterator[Any]:
    """Yield the values of a record, nested records opened, in order."""
    for value in record:
        if is_record(value):
            yield from flat(value)
        else:
            yield value


def pack(record: Record) -> FloatArray:
    """Flatten a record into a vector, field after field, rows first; shape (n,)."""
    values = [np.ravel(np.asarray(v, dtype=float)) for v in flat(record)]
    return np.concatenate(values) if values else np.zeros(0)


def unpack(like: R, vector: FloatArray) -> R:
    """Rebuild a record shaped as ``like`` from a vector of shape (n,)."""
    numbers = iter(np.asarray(vector, dtype=float))

    def build(shape: Any) -> Any:
        if is_record(shape):
            return shape._make(build(value) for value in shape)
        if np.ndim(shape):
            taken = [next(numbers) for _ in range(np.size(shape))]
            return np.array(taken).reshape(np.shape(shape))
        return next(numbers)

    rebuilt: R = build(like)
    if next(numbers, None) is not None:
        raise ValueError(f"{type(like).__name__} has {size(like)} numbers, not more")
    return rebuilt


def add(x: R, steps: Sequence[tuple[float, R]]) -> R:
    """Return x + Σ c k, field by field, for records of one shape."""

    def combine(value: Any, *slopes: Any) -> Any:
        if is_record(value):
            pairs = zip(value, *slopes, strict=True)
            return value._make(combine(*parts) for parts in pairs)
        total = value
        for (c, _), slope in zip(steps, slopes, strict=True):
            total = total + c * slope
        return total

    result: R = combine(x, *(k for _, k in steps))
    return result
