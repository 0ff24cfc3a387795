"""Figures of the bipod's designs, from the shipped tables; none is written down."""

import json
from fractions import Fraction

import numpy as np

from controllers.synthesis.bipod_lpv import designs, single, smooth
from controllers.synthesis.lpv import smooth_file
from controllers.synthesis.lpv.design import verify
from controllers.synthesis.lpv.frozen import frozen_optima
from controllers.synthesis.lpv.systems import System, continuous, response
from controllers.synthesis.lpv.table import Table
from plants.bipod._mechanism import Links


def frozen(phi_deg: float, v_1: float) -> float:
    """Return the H-infinity optimum of the plant that stands at φ (deg) and v (m/s)."""
    problem = single.problem()
    at = ((float(np.deg2rad(phi_deg)), v_1),)
    return float(frozen_optima(problem.plant, at, problem.time, problem.gain)[0])


def certified(name: str = "k_single") -> dict[str, float]:
    """Return γ on the grid, and the dense γ of inequalities and table: the worse."""
    verdict = designs.verdict(designs.read(name))
    return {
        "gamma": verdict.gamma,
        "dense": max(verdict.dense[0], verdict.table[0]),
    }


def hysteresis() -> dict[str, float]:
    """Return γ, the worst dense γ of both regions, tables included, and their links."""
    verdict = verify(designs.read_hysteresis(), designs.hysteresis_dense())
    return {
        "gamma": verdict.gamma,
        "dense": max(*verdict.dense, *verdict.table),
        "links": verdict.links,
    }


def smooth_switching(name: str = "k_smooth") -> dict[str, float]:
    """Return the dense γ of the smooth design and of its table, η before and after.

    η is in the single design's units and the states of ``smooth.UNIT``.
    """
    begun, content = designs.smooth_start(name), designs.smooth_content(name)
    return smooth_file.verified(content, begun, designs.NAMES, smooth.dense())


def responses(phi_deg: float, name: str = "k_smooth_tuned") -> dict[str, float]:
    """Return gains (dB) of the loop that stands at φ (deg) with a shipped table.

    ``S_1``: r → e at 1 rad/s;  ``T_270``, ``T_peak``: f_d → x_1 (m/N) at 270 rad/s and
    where it is largest, ``omega_peak`` (rad/s).  Of the table's continuous systems.
    """
    content = json.loads((designs.FOLDER / f"{name}.json").read_text())
    rho = (float(np.deg2rad(phi_deg)), 0.0)
    axes = tuple(np.array(content[axis]) for axis in designs.NAMES)
    sampled = System(*(np.array(content[part]) for part in "ABCD"))
    table = Table(axes, float(Fraction(content["period"])), sampled)
    K = continuous(table.at(rho), table.T_s)
    weights = single.Weights(
        **{n: content["design"]["weights"][n] for n in ("W_v", "W_d", "on_nu")}
    )
    plant = single.plant(rho, weights, Links())
    omega = np.concatenate([[1.0, 270.0], np.geomspace(1.0, 1e4, 2001)])
    s, none = 1j * omega, np.zeros((1, 1))
    driven = response(System(plant.A, plant.B_2, plant.C_2, none), s)[:, 0, 0]
    pushed = response(System(plant.A, plant.B_1[:, [1]], plant.C_2, none), s)[:, 0, 0]
    S = 1 / (1 - driven * response(K, s)[:, 0, 0])
    decibel = 20 * np.log10(np.abs([S, pushed / weights.W_d * S]))
    peak = int(np.argmax(decibel[1]))
    return {
        "S_1": float(decibel[0, 0]),
        "T_270": float(decibel[1, 1]),
        "T_peak": float(decibel[1, peak]),
        "omega_peak": float(omega[peak]),
    }
