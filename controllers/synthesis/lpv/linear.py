"""One linear H-infinity controller as a data file with its certificate.

P proves the norm of the closed loop by a Cholesky factor (bounded real lemma), in the
units and the states the file gives; the loop is that of the continuous system whose
Tustin transform the shipped one is.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from controllers.synthesis.lpv.coordinates import Coordinates, suitable
from controllers.synthesis.lpv.h_infinity import bounded_real
from controllers.synthesis.lpv.inequalities import gain_of_loop
from controllers.synthesis.lpv.norm import peak
from controllers.synthesis.lpv.shipped import sampled, versions
from controllers.synthesis.lpv.systems import (
    GeneralisedPlant,
    Matrix,
    System,
    continuous,
    transformed,
    tustin,
)
from controllers.synthesis.lpv.table import balancing_states

ABOVE = 1.002  # γ that P is made for, over the norm: at the norm itself there is none


@dataclass(frozen=True)
class Linear:
    """A sampled controller and what certifies its continuous loop."""

    system: System
    T_s: float
    units: Coordinates
    P: Matrix

    @property
    def K(self) -> System:
        """The continuous controller, SI."""
        return continuous(self.system, self.T_s)

    def certified(self, plant: GeneralisedPlant) -> float:
        """Return the norm that P proves; inf if none."""
        return gain_of_loop(_loop(self.units, plant, self.K), self.P, 0.0 * self.P)


def linear(plant: GeneralisedPlant, K: System, T_s: float, time: float) -> Linear:
    """Return a stable continuous controller in balanced states with its certificate.

    Raises:
        ValueError: the loop is unstable.
    """
    K = transformed(K, balancing_states([tustin(K, T_s)]))
    units = suitable([plant], time)
    loop = _loop(units, plant, K)
    return Linear(tustin(K, T_s), T_s, units, bounded_real(loop, ABOVE * peak(loop)[0]))


def contents(
    design: Linear, plant: GeneralisedPlant, gamma: float, weights: Mapping[str, Any]
) -> dict[str, Any]:
    """Return what the file holds; ``gamma`` is what the synthesis stopped at."""
    norm, _ = peak(plant.close(design.K))
    about = {
        "gamma": gamma,
        "norm": norm,
        "certified": design.certified(plant),
        "weights": dict(weights),
        "versions": versions(),
        "time": design.units.time,
        "u": design.units.u,
        "y": design.units.y,
        "T": np.diag(design.units.T),
        "P": design.P,
    }
    return sampled(design.system, design.T_s) | {"design": about}


def read(file: Mapping[str, Any]) -> Linear:
    """Return the design in a file."""
    about = file["design"]
    units = Coordinates(
        np.diag(about["T"]), about["time"], np.array(about["u"]), np.array(about["y"])
    )
    system = System(*(np.array(file[name]) for name in "ABCD"))
    return Linear(system, float(Fraction(file["period"])), units, np.array(about["P"]))


def _loop(units: Coordinates, plant: GeneralisedPlant, K: System) -> System:
    return units.plant(plant).close(units.scaled(K))
