"""The page that a response shows in a notebook."""

from pathlib import Path

from orchestrator.report.responded import (
    Curve,
    Trace,
    write_responded,
    write_transfers,
)
from orchestrator.response.figures import words
from orchestrator.response.measured import Measured, Response, Transfer


def write_measured(found: Measured, path: Path) -> Path:
    """Write the loops, or the ways from inputs to outputs, and return the path."""
    title, told = ", ".join(found.breaks), list(words(found))
    if isinstance(found, Transfer):
        traces = [
            Trace(f"{excited} to {observed}", found.hz, found.G[:, i, j])
            for j, excited in enumerate(found.breaks)
            for i, observed in enumerate(found.observed)
        ]
        return write_transfers(title, told, [], traces, path)
    assert isinstance(found, Response)
    curves = [
        Curve.of(broken, found.hz, 1 / found.S[:, i, i] - 1)
        for i, broken in enumerate(found.breaks)
    ]
    return write_responded(title, told, [], curves, {}, path)
