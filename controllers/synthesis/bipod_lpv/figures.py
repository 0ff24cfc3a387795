"""Figures of the bipod's designs, from the shipped tables; none is written down."""

import numpy as np

from controllers.synthesis.bipod_lpv import designs, single, smooth
from controllers.synthesis.lpv import smooth_file
from controllers.synthesis.lpv.design import verify
from controllers.synthesis.lpv.frozen import frozen_optima


def frozen(phi_deg: float, v_1: float) -> float:
    """Return the H-infinity optimum of the plant that stands at φ (deg) and v (m/s)."""
    problem = single.problem()
    at = ((float(np.deg2rad(phi_deg)), v_1),)
    return float(frozen_optima(problem.plant, at, problem.time, problem.gain)[0])


def certified(name: str = "k_single") -> dict[str, float]:
    """Return γ on the grid, dense γ and the table's certificate of a design."""
    verdict = designs.verdict(designs.read(name))
    return {
        "gamma": verdict.gamma,
        "dense": verdict.dense[0],
        "table": verdict.table[0],
    }


def hysteresis() -> dict[str, float]:
    """Return γ, the worst dense γ and table of both regions, and their links."""
    verdict = verify(designs.read_hysteresis(), designs.hysteresis_dense())
    return {
        "gamma": verdict.gamma,
        "dense": max(verdict.dense),
        "table": max(verdict.table),
        "links": verdict.links,
    }


def smooth_switching(name: str = "k_smooth") -> dict[str, float]:
    """Return the dense γ of the smooth design and of its table, η before and after.

    η is in the single design's units and the states of ``smooth.UNIT``.
    """
    begun, content = designs.smooth_start(name), designs.smooth_content(name)
    return smooth_file.verified(content, begun, designs.NAMES, smooth.dense())
