"""Rows and columns: those that are written, and those of a variable."""

from collections.abc import Sequence
from math import prod

from orchestrator.errors import WiringError
from orchestrator.fmu.ports import Port, indices_of
from orchestrator.system import Rows, Value


def refuse_other_shape(where: str, value: Value, found: Sequence[Port]) -> None:
    """Raise ``WiringError`` if rows are written of another shape than what they set.

    A flat list is taken row by row, whatever the shape.
    """
    if not isinstance(value, Rows) or value.shape == (shape := _shape(found)):
        return
    is_one = f"it is {_in_words(shape)}" if shape else "it is no array of one shape"
    raise WiringError(
        f"{where}: {is_one}, and {_in_words(value.shape)} values are given; give them "
        f"in the shape it has, or as one flat list, row by row"
    )


def _shape(found: Sequence[Port]) -> tuple[int, ...]:
    """Return the shape of what a name stands for, () if it is no array of numbers."""
    indices = [indices_of(port.label) for port in found]
    each = [index for index in indices if index is not None]
    if len(each) < len(found) or len({len(index) for index in each}) != 1:
        return ()
    shape = tuple(len(set(along)) for along in zip(*each, strict=True))
    return shape if prod(shape) == len(found) else ()


def _in_words(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape))
