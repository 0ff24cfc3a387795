"""Calling a model's own functions: what they are told and what they must return."""

import inspect
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np

from fmus.model import Record, is_record


def called(function: Callable[..., Any], **told: Any) -> Any:
    """Return what a model function returns for these arguments, given in order.

    Raises:
        ValueError: it takes others; the message names its file and line.
    """
    try:
        inspect.signature(function).bind(*told.values())
    except TypeError as error:
        raise ValueError(
            f"{place(function)}: {error}; it is called with ({', '.join(told)})"
        ) from None
    return function(*told.values())


def record_of(function: Callable[..., Any], result: Any, like: Any = None) -> Record:
    """Return a result that is a record, shaped as ``like`` if that is given.

    Raises:
        ValueError: it is none; the message names the function's file and line.
    """
    wanted = "a record such as Output" if like is None else type(like).__name__
    wrong = _wrong(result, like, wanted)
    if wrong:
        raise ValueError(
            f"{place(function)} returned {wrong}; return {wanted}(...) with a number "
            f"or signal for every field"
        )
    return result


def pair_of(function: Callable[..., Any], result: Any) -> tuple[Any, Any]:
    """Return the next state and the outputs that a ``step`` returned.

    Raises:
        ValueError: there are not these two.
    """
    if is_record(result) or not isinstance(result, tuple) or len(result) != 2:
        raise ValueError(
            f"{place(function)} returned {_named(result)}; return two records, the "
            f"next state and the outputs: return State(...), Output(...)"
        )
    return result


def place(function: Callable[..., Any]) -> str:
    """Return file, line and name of a function, as far as it has them."""
    code = getattr(inspect.unwrap(function), "__code__", None)
    name = getattr(function, "__name__", repr(function))
    return f"{code.co_filename}:{code.co_firstlineno}: {name}" if code else name


def _wrong(result: Any, like: Any, wanted: str, name: str = "") -> str:
    """Return what is wrong with a result, or nothing."""
    if not is_record(result):
        return f"{_named(result)}{f' for {name}' if name else ''}"
    if like is not None and result._fields != like._fields:
        return f"{_named(result)} with {', '.join(result._fields)}, not {wanted}"
    likes = [None] * len(result) if like is None else like
    for field, value, pattern in zip(result._fields, result, likes, strict=True):
        full = f"{name}.{field}" if name else field
        if is_record(value) or is_record(pattern):
            if wrong := _wrong(value, pattern, type(pattern).__name__, full):
                return wrong
        elif (count := _count(value)) is None:
            return f"{_named(value)} for {full}"
        elif pattern is not None and count != np.size(pattern):
            return f"{count} numbers for {full}, which has {np.size(pattern)}"
    return ""


def _count(value: Any) -> int | None:
    if isinstance(value, ca.SX):
        return int(value.numel())
    try:
        return int(np.asarray(value, dtype=float).size) if value is not None else None
    except (TypeError, ValueError, RuntimeError):
        return None


def _named(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, type):
        return f"the class {value.__name__} itself"
    if isinstance(value, ca.SX):
        return "a bare signal"
    if is_record(value):
        return f"{type(value).__name__}(...)"
    return f"{value!r}" if isinstance(value, str) else f"a {type(value).__name__}"
