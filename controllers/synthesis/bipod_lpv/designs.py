"""The shipped designs of the bipod: made anew, read back, certified.

    k_single   K(φ, ẋ_1) with the printed weights
    k_tuned    the same, weights calibrated to the published errors

    k_hysteresis   two controllers, calibrated weights, switched with hysteresis
    k_smooth   two controllers and their smooth blend, by the source's descent
    k_smooth_tuned   the same, calibrated weights

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
from controllers.synthesis.lpv.descent import descend
from controllers.synthesis.lpv.design import Design, Verdict, verify
from controllers.synthesis.lpv.problem import Point
from controllers.synthesis.lpv.smooth import Smooth

FOLDER = Path(controllers.bipod.__file__).parent
NAMES = ["phi", "v_1"]
HYSTERESIS = ["k_hysteresis_1.json", "k_hysteresis_2.json"]
STEPS = 3  # of the descent's step 1
SMOOTH_DEG = {
    "k_smooth": np.array(single.TABLE_DEG),
    "k_smooth_tuned": np.array(
        [10, 40, 55, 63, 67, 70, 71.35, 72.7, 74.05, 75.4, 77, 78.5, 80]
    ),
}
PROBLEMS = {"k_single": single.problem, "k_tuned": single.calibrated}
WEIGHTS = {"k_single": single.PRINTED, "k_tuned": single.TUNED}
SMOOTH = {"k_smooth": "k_single", "k_smooth_tuned": "k_tuned"}  # and its start


def read(name: str) -> Design:
    """Return a shipped design."""
    content = json.loads((FOLDER / f"{name}.json").read_text())
    return shipped.read(PROBLEMS[name](), [content], NAMES)


def verdict(found: Design) -> Verdict:
    """Return what a design keeps, without a solver."""
    return verify(found, (single.dense(),))


def smooth_content(name: str = "k_smooth") -> Mapping[str, Any]:
    """Return the file of a smooth design."""
    content: Mapping[str, Any] = json.loads((FOLDER / f"{name}.json").read_text())
    return content


def smooth_start(name: str) -> Smooth:
    """Return step 0 of a smooth design."""
    return smooth.start(read(SMOOTH[name]), WEIGHTS[SMOOTH[name]])


def _made_smooth(name: str) -> dict[str, str]:
    found = descend(smooth_start(name), STEPS)
    axes = (np.deg2rad(SMOOTH_DEG[name]).tolist(), (-single.SPEED, single.SPEED))
    about = _about(WEIGHTS[SMOOTH[name]])
    text = smooth_file.text(found, NAMES, axes, single.T_S, smooth.dense(), about)
    return {f"{name}.json": text}


def read_hysteresis() -> Design:
    """Return the shipped design of two controllers with hysteresis."""
    files = [json.loads((FOLDER / file).read_text()) for file in HYSTERESIS]
    return shipped.read(single.hysteresis(single.TUNED), files, NAMES)


def hysteresis_dense() -> tuple[tuple[Point, ...], ...]:
    """Return the grids on which both regions are judged."""
    first, second = (10.0, single.HIGH_DEG), (single.LOW_DEG, 80.0)
    return single.dense(66, first), single.dense(31, second)


def _made_hysteresis() -> dict[str, str]:
    problem, about = single.hysteresis(single.TUNED), _about(single.TUNED)
    return shipped.make(problem, hysteresis_dense(), NAMES, HYSTERESIS, about)


def _made(name: str) -> dict[str, str]:
    problem, about = PROBLEMS[name](), _about(WEIGHTS[name])
    return shipped.make(problem, (single.dense(),), NAMES, [f"{name}.json"], about)


def _about(weights: single.Weights) -> dict[str, Any]:
    return {"W_e": single.W_E, "m_0": single.M_0} | asdict(weights)


DESIGNS: Mapping[str, Callable[[], dict[str, str]]] = {
    "k_single": lambda: _made("k_single"),
    "k_tuned": lambda: _made("k_tuned"),
    "k_smooth": lambda: _made_smooth("k_smooth"),
    "k_smooth_tuned": lambda: _made_smooth("k_smooth_tuned"),
    "k_hysteresis": _made_hysteresis,
}
