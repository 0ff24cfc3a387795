"""Figures of the serial machine's designs, from the shipped tables."""

from controllers.synthesis.lpv import smooth_file
from controllers.synthesis.lpv.design import verify
from controllers.synthesis.lpv.frozen import frozen_optima
from controllers.synthesis.serial_lpv import designs, single, smooth


def frozen(x_c: float, disturbance: float = 1.0) -> float:
    """Return the H-infinity optimum of the plant that stands at x_c (m)."""
    plant = single.plant(disturbance)
    return float(frozen_optima(plant, ((x_c,),), single.TIME)[0])


def certified(name: str = "k_undisturbed") -> dict[str, float]:
    """Return γ on the grid, and the dense γ of inequalities and table: the worse."""
    verdict = designs.verdict(designs.read(name))
    return {
        "gamma": verdict.gamma,
        "dense": max(verdict.dense[0], verdict.table[0]),
    }


def hysteresis(case: str = "") -> dict[str, float]:
    """Return γ, and the worst dense γ of both regions, tables included."""
    verdict = verify(designs.read_hysteresis(case), designs.hysteresis_dense())
    return {
        "gamma": verdict.gamma,
        "dense": max(*verdict.dense, *verdict.table),
    }


def smooth_switching(case: str = "") -> dict[str, float]:
    """Return the dense γ of a smooth design and of its table, η before and after."""
    content, begun = designs.smooth_content(case), designs.smooth_start(case)
    return smooth_file.verified(content, begun, designs.NAMES, smooth.dense())
