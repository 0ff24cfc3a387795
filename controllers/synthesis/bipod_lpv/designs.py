"""The shipped designs of the bipod: made anew, read back, certified.

    k_single   K(φ, ẋ_1) with the printed weights
    k_tuned    the same, weights calibrated to the published errors

Tables hold u = W_v m_0 ν over (φ, ẋ_1); the force is f_1 = H_1(φ) u/(W_v m_0).
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path

import controllers.bipod
from controllers.synthesis.bipod_lpv import single
from controllers.synthesis.lpv import shipped
from controllers.synthesis.lpv.design import Design, Verdict, verify

FOLDER = Path(controllers.bipod.__file__).parent
NAMES = ["phi", "v_1"]
WEIGHTS = {"k_single": single.PRINTED, "k_tuned": single.TUNED}


def read(name: str) -> Design:
    """Return a shipped design."""
    content = json.loads((FOLDER / f"{name}.json").read_text())
    return shipped.read(single.problem(WEIGHTS[name]), [content], NAMES)


def verdict(found: Design) -> Verdict:
    """Return what a design keeps, without a solver."""
    return verify(found, (single.dense(),))


def _made(name: str) -> dict[str, str]:
    weights = WEIGHTS[name]
    about = {"W_e": single.W_E, "m_0": single.M_0} | asdict(weights)
    problem = single.problem(weights)
    return shipped.make(problem, (single.dense(),), NAMES, [f"{name}.json"], about)


DESIGNS: Mapping[str, Callable[[], dict[str, str]]] = {
    "k_single": lambda: _made("k_single"),
    "k_tuned": lambda: _made("k_tuned"),
}
