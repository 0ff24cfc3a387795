"""How much work something is, by a measure that no machine changes."""

import sys
from collections.abc import Callable
from types import FrameType
from typing import Any


def calls(function: Callable[[], object]) -> int:
    """Return how many functions are called, of Python and of C, while one runs."""
    count = 0

    def one(frame: FrameType, event: str, argument: Any) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(one)
    try:
        function()
    finally:
        sys.setprofile(before)
    return count
