"""The shipped designs of an axis of the serial machine.

k_undisturbed   K(x_c) with the disturbance all but off
k_disturbed     the same with the disturbance as printed
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import controllers.serial
from controllers.synthesis.lpv import shipped, smooth_file
from controllers.synthesis.lpv.design import Design, Verdict, verify
from controllers.synthesis.lpv.problem import Point, grid
from controllers.synthesis.lpv.smooth import descend
from controllers.synthesis.serial_lpv import single, smooth

FOLDER = Path(controllers.serial.__file__).parent
NAMES = ["x_c"]
STEPS = 2  # of the descent's step 1; the third stops the solver
AXIS = tuple(float(x) for x in np.linspace(0.2, 0.6, 41))
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


def smooth_content() -> Mapping[str, Any]:
    """Return the file of the smooth design."""
    content: Mapping[str, Any] = json.loads((FOLDER / "k_smooth.json").read_text())
    return content


def _made_smooth() -> dict[str, str]:
    found = descend(smooth.start(read("k_undisturbed")), STEPS)
    text = smooth_file.text(found, NAMES, (AXIS,), single.T_S, smooth.dense())
    return {"k_smooth.json": text}


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
    "k_smooth": _made_smooth,
}
