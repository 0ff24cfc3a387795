"""The shipped designs of an axis of the serial machine.

k_undisturbed   K(x_c) with the disturbance all but off
k_disturbed     the same with the disturbance as printed
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

import controllers.serial
from controllers.synthesis.lpv import shipped
from controllers.synthesis.lpv.design import Design, Verdict, verify
from controllers.synthesis.lpv.problem import Point, grid
from controllers.synthesis.serial_lpv import single

FOLDER = Path(controllers.serial.__file__).parent
NAMES = ["x_c"]
DISTURBANCE = {"k_undisturbed": single.UNDISTURBED, "k_disturbed": 1.0}


def read(name: str) -> Design:
    """Return a shipped design."""
    content = json.loads((FOLDER / f"{name}.json").read_text())
    return shipped.read(single.problem(DISTURBANCE[name]), [content], NAMES)


def dense(n: int = 81) -> tuple[Point, ...]:
    """Return the grid on which a design is judged, two rates at each of n points."""
    return grid(np.linspace(0.2, 0.6, n), rates=[single.SPEED])


def verdict(found: Design) -> Verdict:
    """Return what a design keeps, without a solver."""
    return verify(found, (dense(),))


def _made(name: str) -> dict[str, str]:
    about = {
        "W_e": single.W_E,
        "W_f": single.W_F,
        "W_v": single.W_V,
        "disturbance": DISTURBANCE[name],
    }
    problem = single.problem(DISTURBANCE[name])
    return shipped.make(problem, (dense(),), NAMES, [f"{name}.json"], about)


DESIGNS: Mapping[str, Callable[[], dict[str, str]]] = {
    "k_undisturbed": lambda: _made("k_undisturbed"),
    "k_disturbed": lambda: _made("k_disturbed"),
}
