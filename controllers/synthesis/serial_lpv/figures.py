"""Figures of the serial machine's designs, from the shipped tables."""

from controllers.synthesis.lpv.frozen import frozen_optima
from controllers.synthesis.serial_lpv import designs, single


def frozen(x_c: float, disturbance: float = 1.0) -> float:
    """Return the H-infinity optimum of the plant that stands at x_c (m)."""
    plant = single.plant(disturbance)
    return float(frozen_optima(plant, ((x_c,),), single.TIME)[0])


def certified(name: str = "k_undisturbed") -> dict[str, float]:
    """Return γ on the grid, dense γ and the table's certificate of a design."""
    verdict = designs.verdict(designs.read(name))
    return {
        "gamma": verdict.gamma,
        "dense": verdict.dense[0],
        "table": verdict.table[0],
    }
