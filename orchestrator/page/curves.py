"""What the page draws, as frames: a JSON header and the numbers behind it.

A frame is the length of the header (uint32, little endian), the header (UTF-8, filled
up with spaces to a multiple of eight bytes), then doubles.  A curve says where in them
its times and values lie.  Of a stretch with more points than the screen is wide the
least and the largest of each part are sent, so that no peak is lost; when the page
zooms in it asks again, and gets every recorded point as soon as they fit.
"""

import json
import struct
from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

import numpy as np

from orchestrator.outcome import Run
from orchestrator.quantities.quantity import NoValue
from orchestrator.report.figure import decimate
from orchestrator.report.panels import Array, Curve, Panel, panels

PER_PIXEL = 2  # points


def board_of(run: Run) -> "Board":
    """Return the panels of a run, as its report has them."""
    with np.errstate(all="ignore"):  # what diverges may overflow here
        return Board(list(panels([run])))


class Board:
    """Panels that are drawn, with every point."""

    def __init__(self, panels: Sequence[Panel]) -> None:
        self.panels = panels
        curves = [c for panel in self.panels for c in panel.curves if len(c.time)]
        self.span = (
            min((float(c.time[0]) for c in curves), default=0.0),
            max((float(c.time[-1]) for c in curves), default=0.0),
        )

    def frame(
        self, head: Mapping[str, Any], width: int, window: Sequence[float] | None = None
    ) -> bytes:
        """Return a frame of all curves for a width in pixels.

        ``window`` (s) is what is shown of the time, all by default.
        """
        numbers = _Numbers()
        told = [self._panel(panel, numbers, width, window) for panel in self.panels]
        whole = {**head, "span": self.span, "window": window, "panels": told}
        return numbers.behind(whole)

    def _panel(
        self,
        panel: Panel,
        numbers: "_Numbers",
        width: int,
        window: Sequence[float] | None,
    ) -> dict[str, Any]:
        return {
            "title": panel.title,
            "unit": panel.unit,
            "limits": [[v, text] for v, text in dict.fromkeys(panel.limits)],
            "windows": list(dict.fromkeys(panel.windows)),
            "curves": [_curve(c, numbers, width, window) for c in panel.curves],
        }


def _curve(
    curve: Curve, numbers: "_Numbers", width: int, window: Sequence[float] | None
) -> dict[str, Any]:
    time, values = curve.time, np.asarray(curve.values, dtype=np.float64)
    first, last = 0, len(time)
    if window is not None:  # and a neighbour on either side, where lines lead to
        first = max(0, int(np.searchsorted(time, window[0])) - 1)
        last = int(np.searchsorted(time, window[1], side="right")) + 1
    inside = time[first:last], values[first:last]
    shown = decimate(*inside, PER_PIXEL * max(width, 100))
    return {
        "label": curve.label,
        "run": curve.run,
        "reference": curve.is_reference,
        "points": len(inside[0]),
        "x": numbers.place(shown[0]),
        "y": numbers.place(shown[1]),
    }


class _Numbers:
    """Arrays one behind the other; one that is given twice is stored once."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._known: dict[bytes, tuple[int, int]] = {}
        self._count = 0

    def place(self, values: Array) -> tuple[int, int]:
        """Store an array; return where it begins and how many numbers it has."""
        part = np.ascontiguousarray(values, dtype="<f8").tobytes()
        if part not in self._known:
            self._known[part] = self._count, len(values)
            self._parts.append(part)
            self._count += len(values)
        return self._known[part]

    def behind(self, head: Mapping[str, Any]) -> bytes:
        """Return the frame."""
        text = json.dumps(finite(head), allow_nan=False).encode()
        text += b" " * (-(len(text) + 4) % 8)
        return b"".join((struct.pack("<I", len(text)), text, *self._parts))


def finite(value: Any) -> Any:
    """Return it as JSON can hold it: numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {key: finite(v) for key, v in value.items()}
    if isinstance(value, list | tuple):
        return [finite(v) for v in value]
    return None if isinstance(value, float) and not isfinite(value) else value


def figures(run: Run) -> list[dict[str, Any]]:
    """Return the figures of a run with what is expected of them."""
    checks = {one.figure: one for one in run.checks}
    found = []
    for name, figure in run.metrics.items():
        check = checks.get(name)
        found.append(
            {
                "name": name,
                "value": None if isinstance(figure, NoValue) else float(figure.value),
                "unit": str(figure.unit),
                "why": figure.why if isinstance(figure, NoValue) else "",
                "met": check and check.met,
                "expected": check.text.partition("expected ")[2] if check else "",
            }
        )
    return found
