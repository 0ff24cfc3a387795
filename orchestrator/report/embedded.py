"""Recorded curves inside a page: every number, compressed, to be thinned there.

A page opened from disk can fetch nothing, so that what zooming is to show lies in
it.  Values are 64-bit floats; each is xored with the one before, the bytes of
equal weight are put together, deflated, and written in base64: lossless.
``zoom.js`` undoes it.
"""

import json
import zlib
from base64 import b64encode
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.report.figure import decimate
from orchestrator.report.panels import Array, Curve

MOST = 4_000_000  # numbers in a page, about 30 MB at the worst
SCRIPT = Path(__file__).parent / "zoom.js"
EVEN = 1e-6  # of a step; how evenly spaced times are given by two numbers


def encoded(values: Array) -> str:
    """Return the base64 text of the values (n,)."""
    bits = np.ascontiguousarray(values, dtype="<f8").view("<u8")
    bits = np.concatenate([bits[:1], bits[1:] ^ bits[:-1]])
    planes = bits.view(np.uint8).reshape(-1, 8).T
    return b64encode(zlib.compress(planes.tobytes(), 6)).decode("ascii")


def embedded(time: Array, values: Array) -> dict[str, Any]:
    """Return a curve as ``zoom.js`` reads it; ``time`` (s), ``values``, both (n,)."""
    curve: dict[str, Any] = {"n": len(time), "y": encoded(values)}
    step = float(time[-1] - time[0]) / (len(time) - 1)
    even = time[0] + step * np.arange(len(time))
    if np.max(np.abs(time - even)) <= EVEN * step:
        return {**curve, "first": float(time[0]), "step": step}
    return {**curve, "x": encoded(time)}


def recorded(curves: Mapping[int, Curve], most: int = MOST) -> str:
    """Return the part of a page that holds all points of its curves, by trace.

    Where they are more than ``most`` in all, the largest curves are thinned, and
    the page says down to which stretch they are honest.
    """
    kept = share([len(curve.time) for curve in curves.values()], most)
    stored = []
    for trace, curve in curves.items():
        time, values = decimate(curve.time, curve.values, max(4, kept))
        if len(time) < 2:
            continue
        written = {"trace": trace, "of": len(curve.time), **embedded(time, values)}
        if len(time) < len(curve.time):
            span = float(curve.time[-1] - curve.time[0])
            written["said"] = (
                f"Of {curve.label}, {len(curve.time):,} points, the page holds the "
                f"least and the greatest of stretches of {2 * span / len(time):.3g} s: "
                f"zoomed further it is not what was recorded; the tables in result/ "
                f"hold every point."
            )
        stored.append(written)
    text = json.dumps(stored).replace("<", "\\u003c")
    drawn = "The curves are thinned to 5,000 points each, no peak is lost."
    return (
        f"<p class=about id=drawn>{drawn}</p>"
        f'<script type="application/json" id="recorded">{text}</script>'
        f"<script>{SCRIPT.read_text(encoding='utf-8')}</script>"
    )


def share(sizes: Sequence[int], most: int = MOST) -> int:
    """Return how many points each curve may keep so that all fit into a page."""
    kept = most // max(1, len(sizes))
    for _ in sizes:
        large = [n for n in sizes if n > kept]
        if not large:
            break
        kept = (most - sum(n for n in sizes if n <= kept)) // len(large)
    return kept
