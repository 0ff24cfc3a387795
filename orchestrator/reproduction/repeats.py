"""A figure over many runs that differ by the seed of their noise alone.

    repeats = { seeds = ["x_noise.seed", "y_noise.seed"], count = 50, take = "mean" }

Run i (from 1) has the seeds 1000 i + 1, 1000 i + 2, ...: the same runs every time, and
no two noises alike.  ``take`` is the mean of the figure or its standard deviation
(n - 1), as a source gives them of its repeated experiments; rows that differ by it
alone share their runs.
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from pydantic import Field

from orchestrator.evaluation.schema import Strict
from orchestrator.quantities.quantity import NoValue, Quantity


class Repeats(Strict):
    """How often a scenario is run, with which seeds, and what is taken of the runs."""

    seeds: tuple[str, ...] = Field(min_length=1, strict=False)
    count: int = Field(ge=2, le=1000)
    take: Literal["mean", "std"]

    def sets(self) -> list[tuple[str, ...]]:
        """Return what ``--set`` would say for each run."""
        return [
            tuple(f"{key}={1000 * i + n}" for n, key in enumerate(self.seeds, 1))
            for i in range(1, self.count + 1)
        ]

    def of(self, runs: Sequence[Quantity]) -> Quantity:
        """Return mean or standard deviation of the runs' figures, of one unit."""
        unit = runs[0].unit
        for number, one in enumerate(runs, 1):
            if isinstance(one, NoValue):
                return NoValue(unit, why=f"repeat {number}: {one.why}")
        values = [one.value for one in runs]
        if self.take == "mean":
            return Quantity(float(np.mean(values)), unit)
        return Quantity(float(np.std(values, ddof=1)), unit)
