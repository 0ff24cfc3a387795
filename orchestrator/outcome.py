"""A finished run with its figures and checks."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from orchestrator.evaluation.expectation import Check
from orchestrator.quantities.quantity import NoValue, Quantity
from orchestrator.result import Result
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.reading import Scenario
from orchestrator.shown import Shown


class Run(Result, Shown):
    """A finished run: recorded signals by name, and what was made of them.

    ``metrics`` are the figures of the scenario, ``checks`` its expectations;
    ``diverged`` says which signal diverges and when, if one does, ``unlike`` what is
    not as in the baseline;
    ``composition`` is the system that ran, with its design results; ``warnings``
    are what its user has to know of it, ``number`` is that of its folder if it has
    one.
    """

    PAGE = "orchestrator.report.notebook:write_run"

    def __init__(
        self,
        result: Result,
        composition: Composition,
        metrics: Mapping[str, Quantity],
        checks: list[Check],
        diverged: str | None = None,
        warnings: tuple[str, ...] = (),
        number: int | None = None,
        unlike: Sequence[str] = (),
    ) -> None:
        super().__init__(result.folder, result.timing, result.ended)
        self.composition = composition
        self.metrics = metrics
        self.checks = checks
        self.diverged = diverged
        self.warnings = warnings
        self.number = number
        self.unlike = unlike

    @property
    def scenario(self) -> Scenario:
        return self.composition.scenario

    def summary(self) -> dict[str, Any]:
        """Return the object that ``run --json`` prints."""
        timing = self.timing
        return {
            "scenario": self.scenario.name,
            "number": self.number,
            "stop": float(self.composition.system.stop),
            "metrics": {
                name: _summed_up(figure) for name, figure in self.metrics.items()
            },
            "diverged": self.diverged,
            "unlike": list(self.unlike),
            "ended": self.ended and asdict(self.ended),
            "values": {
                f"{name}.{key}": list(value) if isinstance(value, tuple) else value
                for name, component in self.composition.system.components.items()
                for key, value in component.values.items()
            },
            "warnings": list(self.warnings),
            "undriven": [asdict(one) for one in self.composition.undriven],
            "not_taken_over": [asdict(o) for o in self.composition.not_taken_over],
            "executor": timing and timing.executor,
            "timing": timing
            and {
                "wall_s": timing.wall_s,
                "real_time_factor": timing.real_time_factor,
                "us_per_instant": timing.us_per_instant,
            }
            | ({"profile": timing.profile.as_json()} if timing.profile else {})
            | ({"paced": asdict(timing.paced)} if timing.paced else {}),
            "result": str(self.folder),
        }


def _summed_up(figure: Quantity) -> dict[str, Any]:
    if isinstance(figure, NoValue):
        return {"value": None, "unit": figure.unit, "why": figure.why}
    return {"value": figure.value, "unit": figure.unit}
