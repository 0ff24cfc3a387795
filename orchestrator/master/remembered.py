"""What an executor remembers from one instant to the next besides the vector.

The same for every executor that can be resumed, as 64-bit words.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Words: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True)
class Remembered:
    """``lines`` by component: what its latency holds back, the oldest first.

    ``faults``: of every number that has faults what it would receive without them,
    then what each fault remembers (a delay its line, any other one word).
    """

    lines: Mapping[str, Words]
    faults: Words


def words(values: list[Any], dtype: str) -> Words:
    """Return numbers of a type as words."""
    return np.array(values, dtype=dtype).view(np.int64)


def numbers(held: Words, dtype: str) -> list[Any]:
    """Return words as the Python numbers of a type."""
    found: list[Any] = held.view(dtype).tolist()
    return found
