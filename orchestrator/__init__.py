"""Co-simulation of FMU files at exact mixed rates.

from orchestrator import load_scenario, run
result = run(load_scenario("drive.toml", ["plant.m_2=0.5e-3"]))
result["plant.x_2"].values, result.metrics["tracking.peak"]
"""

import sys
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orchestrator.result import Result as Result
    from orchestrator.scenario.reading import load_scenario as load_scenario
    from orchestrator.session import run as run
    from orchestrator.system import System as System

HOME = Path(__file__).resolve().parent.parent


def _import_fmus() -> None:
    """Import our package ``fmus``, whatever else of that name ``sys.path`` has.

    Raises:
        ImportError: Python has already imported another.
    """
    sys.path.insert(0, str(HOME))
    try:
        found = import_module("fmus")
    finally:
        sys.path.remove(str(HOME))
    place = Path(found.__file__ or "").resolve().parent
    if place != HOME / "fmus":
        raise ImportError(
            f"feeddrive needs its own package fmus, but Python has imported {place} "
            f"under that name: rename that folder, or import orchestrator first"
        )


_import_fmus()
_PUBLIC = {
    "Result": "result",
    "System": "system",
    "load_scenario": "scenario.reading",
    "run": "session",
}
__all__ = ["Result", "System", "load_scenario", "run"]


def __getattr__(name: str) -> Any:
    """Import the public names when they are first used: the command starts quickly."""
    if name not in _PUBLIC:
        raise AttributeError(f"module 'orchestrator' has no attribute {name!r}")
    return getattr(import_module(f"orchestrator.{_PUBLIC[name]}"), name)
