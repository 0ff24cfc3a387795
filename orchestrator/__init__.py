"""Co-simulation of FMU files at exact mixed rates.

from orchestrator import load_scenario, run
result = run(load_scenario("drive.toml", ["plant.m_2=0.5e-3"]))
result["plant.x_2"].values, result.metrics["tracking.peak"]
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orchestrator.result import Result as Result
    from orchestrator.scenario.reading import load_scenario as load_scenario
    from orchestrator.session import run as run
    from orchestrator.system import System as System

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
