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

MOST = 6_000_000  # numbers in a page, about 60 MB at the worst
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
    kept = max(4, share([len(curve.time) for curve in curves.values()], most))
    stored, coarse = [], {}
    for trace, curve in curves.items():
        time, values = decimate(curve.time, curve.values, kept)
        if len(time) > 1:
            stored.append({"trace": trace, **embedded(time, values)})
        if len(time) < len(curve.time):
            coarse[curve.label] = curve
    content = {"curves": stored, "coarse": _honest(coarse, kept)}
    text = json.dumps(content).replace("<", "\\u003c")
    drawn = "The curves are thinned to 3,000 points each, no peak is lost."
    return (
        f"<p class=about id=drawn>{drawn}</p>"
        f'<script type="application/json" id="recorded">{text}</script>'
        f"<script>{SCRIPT.read_text(encoding='utf-8')}</script>"
    )


def _honest(coarse: Mapping[str, Curve], kept: int) -> str:
    """Say down to which stretch of time thinned curves are what was recorded."""
    if not coarse:
        return ""
    spans = (float(c.time[-1] - c.time[0]) for c in coarse.values())
    stretch = max(spans) / (kept // 2 - 1)
    points = max(len(c.time) for c in coarse.values())
    return (
        f" The page holds up to {kept:,} points of a curve, not all {points:,} of "
        f"{', '.join(coarse)}: of each stretch of {stretch:.2g} s the least and the "
        f"greatest. Zoomed further these are not what was recorded; result/ holds "
        f"every point."
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
