"""TOML of others, read within bounds: the one way in which TOML is read here.

A file may be hostile or broken: what is larger, nested deeper or has longer numbers
than anything a scenario could want is refused before it takes time or memory.
"""

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

LARGEST = 16_000_000  # characters of a file
DEEPEST = 32  # tables and arrays inside each other
DIGITS = 1000  # of one number
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+"""
_LONG_KEY = re.compile(rf"(?<![\w-])(?:{_PART}){{{DEEPEST}}}")
_LONG_NUMBER = re.compile(rf"[0-9_]{{{DIGITS}}}")


def read_toml_text(file: Path) -> str:
    """Return the text of a file.

    Raises:
        OSError: it cannot be read.
        ValueError: it is too large, or no UTF-8.
    """
    if file.stat().st_size > LARGEST:
        raise ValueError(f"larger than {LARGEST:,} bytes")
    if not file.is_file():
        raise ValueError("no regular file")
    return file.read_text(encoding="utf-8")


def toml(text: str, parse_float: Callable[[str], Any] = float) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises:
        ValueError: it is no TOML, or out of bounds.
    """
    if len(text) > LARGEST:
        raise ValueError(f"longer than {LARGEST:,} characters")
    if _LONG_KEY.search(text):
        raise ValueError(f"a key has {DEEPEST} parts or more")
    if _LONG_NUMBER.search(text):
        raise ValueError(f"a number has {DIGITS} digits or more")
    try:
        tables = tomllib.loads(text, parse_float=parse_float)
    except RecursionError:
        raise ValueError("tables or arrays are nested too deeply") from None
    _check(tables)
    return tables


def _check(tables: dict[str, Any]) -> None:
    """Refuse deep nesting and texts that no system call takes."""
    level: list[Any] = [tables]
    for _ in range(DEEPEST):
        below: list[Any] = []
        for value in level:
            if isinstance(value, dict):
                below += value.keys()
                below += value.values()
            elif isinstance(value, list):
                below += value
            elif isinstance(value, str) and "\0" in value:
                raise ValueError(f"the text {value[:40]!r} has a NUL in it")
        level = below
        if not level:
            return
    raise ValueError(f"tables or arrays are nested more than {DEEPEST} deep")
