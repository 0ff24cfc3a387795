"""What is wrong with a file's keys and values, in our words instead of pydantic's."""

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from pydantic import ValidationError

from orchestrator.errors import did_you_mean

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

_EXPECTED = {
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
    "string": "a text in quotes",
    "dict": "a table",
    "model": "a table",
    "model_attributes": "a table",
    "list": "a list",
    "tuple": "a list",
}
_BOUNDS = {
    "greater_than": ("gt", "greater than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}


def complaints(error: ValidationError) -> Iterator[str]:
    """Yield each complaint once, with its key path, in plain words."""
    told: dict[str, list[str]] = {}  # a value of several types is refused by each
    for detail in error.errors(include_url=False):
        where = list(detail["loc"])
        if where[:1] == ["metrics"] and len(where) > 2:
            del where[2]  # pydantic's name for the kind of metric
        if _expected(detail) and where[-1] in ("float", "str"):
            del where[-1]  # and for one type of several
        path = ".".join(f'"{p}"' if "." in str(p) else str(p) for p in where)
        expected = _expected(detail)
        known = told.setdefault(path, [])
        if not expected:
            known.append(_in_our_words(detail))
        elif known and "is not" in known[-1]:
            known[-1] += f" or {expected}"
        else:
            known.append(f"{detail['input']!r} is not {expected}")
    for path, found in told.items():
        for message in found:
            yield f"{path}: {message}" if path else message


def _expected(detail: "ErrorDetails") -> str:
    """Return the type that was expected, where a complaint is about that alone."""
    return _EXPECTED.get(re.sub(r"_(type|from_float)$", "", detail["type"]), "")


def _in_our_words(detail: "ErrorDetails") -> str:
    what, given, context = detail["type"], detail["input"], detail.get("ctx", {})
    if what == "missing":
        return "is missing"
    if what in _BOUNDS:
        key, words = _BOUNDS[what]
        return f"{given} is refused; it must be {words} {context[key]:g}"
    if what == "literal_error":
        known = re.split(", | or ", context["expected"].replace("'", ""))
        if not isinstance(given, str) or given in known:
            return f"{given!r} is refused; write {' or '.join(known)}"
        return f"there is no {given!r} here; {did_you_mean(str(given), known)}"
    if what == "union_tag_invalid":
        known = context["expected_tags"].replace("'", "").split(", ")
        wrong = context["tag"]
        return f"there is no kind {wrong!r}; {did_you_mean(wrong, known)}"
    if what == "union_tag_not_found":
        return 'kind is missing, such as kind = "peak"'
    if what == "string_pattern_mismatch":
        return f'{given!r} names no function; write "module:function"'
    if what == "too_short":
        return "there must be at least one"
    return detail["msg"].removeprefix("Value error, ")
