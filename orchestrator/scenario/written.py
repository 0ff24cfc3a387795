"""Values as a scenario writes them: numbers, switches, arrays, texts."""

from collections.abc import Iterator
from math import isfinite
from typing import Any

import numpy as np

from orchestrator.system import Rows, Value


def parse_value(value: Any) -> Value:
    """Return the value of a parameter or state: number, switch, flat array or rows.

    Whole numbers stay such, of any size.

    Raises:
        ValueError: not a number, or not a finite one.
    """
    if isinstance(value, bool):
        return value
    if isinstance(value, list):
        try:
            array = np.array(value, dtype=float)
        except (TypeError, ValueError, OverflowError):
            raise ValueError(f"{value} is not an array of numbers") from None
        if not np.all(np.isfinite(array)):
            raise ValueError(f"{value} holds a number that is not finite")
        return _array([parse_scalar(v) for v in _flat(value)], array.shape)
    return parse_scalar(value)


def _array(values: list[Any], shape: tuple[int, ...]) -> Value:
    return tuple(values) if len(shape) == 1 else Rows(values, shape)


def in_lists(value: Value) -> Any:
    """Return a value as it is written: an array as a list, rows as lists of lists."""
    if not isinstance(value, Rows):
        return list(value) if isinstance(value, tuple) else value
    lists: list[Any] = list(value)
    for size in value.shape[:0:-1]:
        lists = [lists[i : i + size] for i in range(0, len(lists), size)]
    return lists


def parse_scalar(value: Any) -> float | bool:
    """Return a single value.

    Raises:
        ValueError: not a number, true or false, or not a finite number.
    """
    if isinstance(value, bool):
        return value
    if not isinstance(value, int | float):
        raise ValueError(f"{value!r} is not a number, true, false or an array")
    if isinstance(value, int):
        return value
    if not isfinite(value):
        raise ValueError(f"{value} is not a finite number")
    return float(value)


def _flat(value: Any) -> Iterator[Any]:
    if isinstance(value, list):
        for one in value:
            yield from _flat(one)
    else:
        yield value


def in_floats(value: Value) -> Value:
    """Return a value for a design function, whose whole numbers are floats too."""
    if isinstance(value, tuple):
        return tuple(v if isinstance(v, bool | str) else float(v) for v in value)
    return value if isinstance(value, bool | str) else float(value)


def parse_setting(value: Any) -> Value:
    """Return what a parameter or start is set to: a value, or texts.

    A text may be a quantity (``"8 kg"``), the item of an enumeration, a String.

    Raises:
        ValueError: it is neither.
    """
    if isinstance(value, str):
        return value
    texts = list(_flat(value)) if isinstance(value, list) else []
    if texts and all(isinstance(text, str) for text in texts):
        return _array(texts, np.array(value, dtype=object).shape)
    return parse_value(value)
