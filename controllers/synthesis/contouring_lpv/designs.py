"""The shipped designs for contouring.

k_planar   K(θ) from (r_x - x, r_y - y) to both commands, a Fourier series
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import controllers.three_axis
from controllers.synthesis.contouring_lpv import planar
from controllers.synthesis.lpv import shipped
from controllers.synthesis.lpv.design import Design, Verdict, verify

FOLDER = Path(controllers.three_axis.__file__).parent
NAMES = ["theta"]


def read() -> Design:
    """Return the shipped design."""
    content = json.loads((FOLDER / "k_planar.json").read_text())
    return shipped.read(planar.problem(), [content], NAMES)


def verdict(found: Design) -> Verdict:
    """Return what a design keeps, without a solver."""
    return verify(found, (planar.dense(),))


def _made() -> dict[str, str]:
    about = {
        "W_t": planar.W_T,
        "W_n": planar.W_N,
        "W_v": planar.W_V,
        "W_f": planar.W_F,
    }
    problem = planar.problem()
    return shipped.make(problem, (planar.dense(),), NAMES, ["k_planar.json"], about)


DESIGNS: Mapping[str, Callable[[], dict[str, str]]] = {"k_planar": _made}
