"""One linear H-infinity controller as a data file.

Its norm is found anew over frequency, in the loop with the continuous system whose
Tustin transform the file holds.  (The matrix of the bounded real lemma proves nothing
here: controller and weight share slow poles, which makes it singular to rounding.)
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from controllers.synthesis.lpv.norm import peak
from controllers.synthesis.lpv.shipped import sampled, versions
from controllers.synthesis.lpv.systems import (
    GeneralisedPlant,
    System,
    continuous,
    transformed,
    tustin,
)
from controllers.synthesis.lpv.table import balancing_states


@dataclass(frozen=True)
class Linear:
    """A controller sampled every ``T_s`` (s)."""

    system: System
    T_s: float

    @property
    def K(self) -> System:
        """The continuous controller, SI."""
        return continuous(self.system, self.T_s)

    def norm(self, plant: GeneralisedPlant) -> float:
        """Return the norm of the loop; inf if it is unstable."""
        try:
            return peak(plant.close(self.K))[0]
        except ValueError:
            return float("inf")


def linear(K: System, T_s: float) -> Linear:
    """Return a stable continuous controller, sampled, in balanced states."""
    plain = tustin(K, T_s)
    return Linear(transformed(plain, balancing_states([plain])), T_s)


def contents(
    design: Linear, plant: GeneralisedPlant, gamma: float, weights: Mapping[str, Any]
) -> dict[str, Any]:
    """Return what the file holds; ``gamma`` is what the synthesis stopped at."""
    about = {
        "gamma": gamma,
        "norm": design.norm(plant),
        "weights": dict(weights),
        "versions": versions(),
    }
    return sampled(design.system, design.T_s) | {"design": about}


def read(file: Mapping[str, Any]) -> Linear:
    """Return the design in a file."""
    system = System(*(np.array(file[name]) for name in "ABCD"))
    return Linear(system, float(Fraction(file["period"])))
