"""How numbers lie in the master's vector: as doubles, 64-bit integers as themselves.

Every place has 8 bytes, and a view of the whole vector by each type.  Between two
types a value passes exactly or not at all, unless a gain or offset is asked for.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.fmu.description import Dtype, FmuVariable
from orchestrator.fmu.ports import Affine
from orchestrator.fmu.typed import Held
from orchestrator.fmu.whole import Listed, Whole

Views: TypeAlias = Mapping[Dtype, Any]
RANGES = {"int64": (-(2**63), 2**63 - 1), "uint64": (0, 2**64 - 1)}


def views(vector: NDArray[np.float64]) -> Views:
    """Return the vector's places seen by each type."""
    return {
        "float64": vector.data,
        "int64": vector.view(np.int64).data,
        "uint64": vector.view(np.uint64).data,
    }


def store(
    vector: NDArray[np.float64],
    first: int,
    variables: Sequence[FmuVariable],
    values: Sequence[Held],
) -> None:
    """Put the numbers of variables, one after the other, into the vector."""
    seen, taken = views(vector), iter(values)
    places = (v.dtype for v in variables for _ in range(v.size))
    for place, dtype in enumerate(places, first):
        seen[dtype][place] = next(taken)


def fitted(
    value: float, affine: Affine, to: Dtype, whole: Whole | Listed | None = None
) -> float:
    """Return gain * value + offset as a number of another type, or in its range.

    Raises:
        ValueError: it would lose digits, or does not fit; the message says which.
    """
    if affine.converts:
        value = affine.gain * float(value) + affine.offset
    if whole is not None:
        found = whole.of(float(value))
        return found if to == "float64" else int(found)
    if to == "float64":
        if isinstance(value, int) and int(float(value)) != value:
            raise ValueError(
                f"{value} has more digits than a number of 64 bits with a point can "
                f"hold; connect it to a 64-bit integer, or give a map with a gain"
            )
        return float(value)
    if value != value // 1:
        raise ValueError(f"{value} is no whole number")
    low, high = RANGES[to]
    if not low <= value <= high:
        raise ValueError(f"{value} does not fit into {to}")
    return int(value)


@dataclass(frozen=True)
class Copy:
    """vector[sink] = gain * vector[source] + offset; ``ends`` names both.

    With ``whole`` the result is rounded and kept in its range, or looked up.

    ``from_`` and ``to`` are the types of the two places.
    """

    source: int
    sink: int
    affine: Affine
    from_: Dtype
    to: Dtype
    ends: str
    whole: Whole | Listed | None = None

    @property
    def is_exact(self) -> bool:
        """Tell whether the bits of the place are copied."""
        same = self.from_ == self.to and self.whole is None
        return same and not self.affine.converts

    @property
    def is_of_doubles(self) -> bool:
        """Whether nothing but gain and offset acts between two doubles."""
        return self.from_ == self.to == "float64" and self.whole is None


def carry(copy: Copy, views: Views, t: float) -> None:
    """Copy a number into a place of another type.

    Raises:
        SimulationError: it would lose digits there.
    """
    try:
        value = fitted(views[copy.from_][copy.source], copy.affine, copy.to, copy.whole)
    except ValueError as error:
        raise SimulationError(f"{copy.ends} at t = {t:.9g} s: {error}") from None
    views[copy.to][copy.sink] = value
