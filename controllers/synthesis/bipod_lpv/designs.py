"""The shipped designs of the bipod: made anew, read back, certified.

    k_single   K(φ, ẋ_1) with the printed weights
    k_tuned    the same, weights calibrated to the published errors

    k_hysteresis   two controllers, calibrated weights, switched with hysteresis
    k_smooth   two controllers and their smooth blend, by the source's descent

Tables hold u = W_v m_0 ν over (φ, ẋ_1); the force is f_1 = H_1(φ) u/(W_v m_0).
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

import controllers.bipod
from controllers.synthesis.bipod_lpv import single, smooth
from controllers.synthesis.lpv import shipped, smooth_file
from controllers.synthesis.lpv.design import Design, Verdict, verify
from controllers.synthesis.lpv.problem import Point
from controllers.synthesis.lpv.smooth import descend

FOLDER = Path(controllers.bipod.__file__).parent
NAMES = ["phi", "v_1"]
HYSTERESIS = ["k_hysteresis_1.json", "k_hysteresis_2.json"]
STEPS = 3  # of the descent's step 1
SMOOTH_AXES = (
    tuple(float(x) for x in np.deg2rad(np.linspace(10.0, 80.0, 57))),
    (-1.0, 1.0),
)
WEIGHTS = {"k_single": single.PRINTED, "k_tuned": single.TUNED}


def read(name: str) -> Design:
    """Return a shipped design."""
    content = json.loads((FOLDER / f"{name}.json").read_text())
    return shipped.read(single.problem(WEIGHTS[name]), [content], NAMES)


def verdict(found: Design) -> Verdict:
    """Return what a design keeps, without a solver."""
    return verify(found, (single.dense(),))


def smooth_content() -> Mapping[str, Any]:
    """Return the file of the smooth design."""
    content: Mapping[str, Any] = json.loads((FOLDER / "k_smooth.json").read_text())
    return content


def _made_smooth() -> dict[str, str]:
    found = descend(smooth.start(read("k_single")), STEPS)
    text = smooth_file.text(found, NAMES, SMOOTH_AXES, single.T_S, smooth.dense())
    return {"k_smooth.json": text}


def read_hysteresis() -> Design:
    """Return the shipped design of two controllers with hysteresis."""
    files = [json.loads((FOLDER / file).read_text()) for file in HYSTERESIS]
    return shipped.read(single.hysteresis(single.TUNED), files, NAMES)


def hysteresis_dense() -> tuple[tuple[Point, ...], ...]:
    """Return the grids on which both regions are judged."""
    first, second = (10.0, single.HIGH_DEG), (single.LOW_DEG, 80.0)
    return single.dense(66, first), single.dense(31, second)


def _made_hysteresis() -> dict[str, str]:
    about = {"W_e": single.W_E, "m_0": single.M_0} | asdict(single.TUNED)
    problem = single.hysteresis(single.TUNED)
    return shipped.make(problem, hysteresis_dense(), NAMES, HYSTERESIS, about)


def _made(name: str) -> dict[str, str]:
    weights = WEIGHTS[name]
    about = {"W_e": single.W_E, "m_0": single.M_0} | asdict(weights)
    problem = single.problem(weights)
    return shipped.make(problem, (single.dense(),), NAMES, [f"{name}.json"], about)


DESIGNS: Mapping[str, Callable[[], dict[str, str]]] = {
    "k_single": lambda: _made("k_single"),
    "k_tuned": lambda: _made("k_tuned"),
    "k_smooth": _made_smooth,
    "k_hysteresis": _made_hysteresis,
}
