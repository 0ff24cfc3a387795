"""The shipped designs for contouring.

k_planar      K(θ) from (r_x - x, r_y - y) to both commands, a Fourier series
lqg_spatial   gridded LQG along the path in space, from (r - u_c) to three commands
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

import controllers.three_axis
from controllers.synthesis.contouring_lpv import lqg, planar
from controllers.synthesis.lpv import shipped
from controllers.synthesis.lpv.design import Design, Verdict, verify

FOLDER = Path(controllers.three_axis.__file__).parent
NAMES = ["theta"]
LQG_POINTS = 17
LQG_W_V = 0.5  # 1/V
LQG_RATIO = 3e11  # V²/m²


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


def _lqg() -> dict[str, str]:
    grid = np.linspace(0, 1, LQG_POINTS)
    found = lqg.design(lqg.along(grid), LQG_W_V, LQG_RATIO)
    matrices = found._asdict()
    gains = matrices.pop("K")
    content = {
        "period": "1/4000",
        "q": grid,
        **matrices,
        "K": gains.reshape(-1, gains.shape[-1]),
        "design": {
            "weights": {"W_t": lqg.W_T, "W_n": lqg.W_N, "W_v": LQG_W_V},
            "ratio": LQG_RATIO,
            "versions": shipped.versions(),
        },
    }
    return {"lqg_spatial.json": shipped.text(content)}


DESIGNS: Mapping[str, Callable[[], dict[str, str]]] = {
    "k_planar": _made,
    "lqg_spatial": _lqg,
}
