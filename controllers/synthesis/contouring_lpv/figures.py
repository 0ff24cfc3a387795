"""Figures of the contouring designs, from the shipped series."""

from controllers.synthesis.contouring_lpv import designs, planar
from controllers.synthesis.lpv.frozen import frozen_optima


def frozen(theta: float) -> float:
    """Return the H-infinity optimum of the plant whose path keeps θ (rad)."""
    problem = planar.problem()
    at = ((theta,),)
    return float(frozen_optima(problem.plant, at, problem.time, problem.gain)[0])


def certified() -> dict[str, float]:
    """Return γ on the grid, dense γ and the certificate of the series."""
    verdict = designs.verdict(designs.read())
    return {
        "gamma": verdict.gamma,
        "dense": verdict.dense[0],
        "table": verdict.table[0],
    }
