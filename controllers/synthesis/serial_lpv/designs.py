"""The shipped designs of an axis of the serial machine.

k_undisturbed   K(x_c) with the disturbance all but off
k_disturbed     the same with the disturbance as printed
k_hysteresis    two controllers, switched with hysteresis, a file each
k_smooth        two controllers and their smooth blend, by the source's descent

the last two also as ``..._disturbed``.
"""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import controllers.serial
from controllers.synthesis.lpv import shipped, smooth_file
from controllers.synthesis.lpv.descent import (
    bisect,
    descend,
    find_P,
    find_slow_K,
    reach,
)
from controllers.synthesis.lpv.design import Design, Verdict, lower_bound, verify
from controllers.synthesis.lpv.problem import Point, grid
from controllers.synthesis.lpv.smooth import Smooth, rate_bound
from controllers.synthesis.serial_lpv import single, smooth

FOLDER = Path(controllers.serial.__file__).parent
NAMES = ["x_c"]
TRANSITION = np.linspace(smooth.LOW, smooth.HIGH, 17)  # K is affine outside
AXIS = (0.2, 0.29, *(float(x) for x in TRANSITION), 0.51, 0.6)
SCALE = {"": single.UNDISTURBED, "_disturbed": 1.0}  # of the disturbance
STEPS = 4  # of the descent's step 1, disturbance off
AIM = 26.0  # γ_d before the option, disturbance on
RELAXED = 1.01  # of γ, for the least rate of K
WIDTH = 0.06  # of the bracket of γ_d, relative
DISTURBANCE = {"k_undisturbed": single.UNDISTURBED, "k_disturbed": 1.0}
SINGLE = {"": "k_undisturbed", "_disturbed": "k_disturbed"}


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


def read_hysteresis(case: str = "") -> Design:
    """Return the shipped design of two controllers; ``case`` as of ``SCALE``."""
    files = [json.loads((FOLDER / file).read_text()) for file in _hysteresis(case)]
    return shipped.read(single.hysteresis(SCALE[case]), files, NAMES)


def hysteresis_dense(n: int = 45) -> tuple[tuple[Point, ...], ...]:
    """Return the grids on which both regions are judged."""
    reach = ((0.2, single.HIGH), (single.LOW, 0.6))
    return tuple(grid(np.linspace(*ends, n), rates=[single.SPEED]) for ends in reach)


def smooth_content(case: str = "") -> Mapping[str, Any]:
    """Return the file of a smooth design; ``case`` as of ``SCALE``."""
    file = FOLDER / f"k_smooth{case}.json"
    content: Mapping[str, Any] = json.loads(file.read_text())
    return content


def smooth_start(case: str = "") -> Smooth:
    """Return what the descent starts from; ``case`` as of ``SCALE``."""
    return smooth.start(read(SINGLE[case]), SCALE[case])


def _hysteresis(case: str) -> list[str]:
    return [f"k_hysteresis{case}_{i}.json" for i in (1, 2)]


def _made_smooth(case: str) -> dict[str, str]:
    """Make a smooth design: the descent, the option (6.46), and step 1 once more.

    With the disturbance on step 2 stops the solver unless K's rate is bounded; there
    γ_d is bisected at the η that the option came to.
    """
    begun = smooth_start(case)
    tried: tuple[tuple[float, float], ...] = ()
    if case:
        found = reach(find_P(begun), AIM, 0.0)
        slow = find_P(find_slow_K(found, RELAXED))
        eta = rate_bound(slow, slow.problem.points)
        found, tried = bisect(slow, eta, lower_bound(begun.start.problem), WIDTH)
    else:
        found = find_P(find_slow_K(descend(begun, STEPS), RELAXED))
    text = smooth_file.text(
        found, NAMES, (AXIS,), single.T_S, smooth.dense(), tried=tried
    )
    return {f"k_smooth{case}.json": text}


def _made_hysteresis(case: str) -> dict[str, str]:
    problem, files = single.hysteresis(SCALE[case]), _hysteresis(case)
    return shipped.make(problem, hysteresis_dense(), NAMES, files, _about(SCALE[case]))


def _about(disturbance: float) -> dict[str, Any]:
    return {
        "W_e": single.W_E,
        "W_f": single.W_F,
        "W_v": single.W_V,
        "disturbance": disturbance,
    }


def _made(name: str) -> dict[str, str]:
    problem, about = single.problem(DISTURBANCE[name]), _about(DISTURBANCE[name])
    return shipped.make(problem, (dense(),), NAMES, [f"{name}.json"], about)


DESIGNS: Mapping[str, Callable[[], dict[str, str]]] = {
    "k_undisturbed": lambda: _made("k_undisturbed"),
    "k_disturbed": lambda: _made("k_disturbed"),
    "k_hysteresis": lambda: _made_hysteresis(""),
    "k_hysteresis_disturbed": lambda: _made_hysteresis("_disturbed"),
    "k_smooth": lambda: _made_smooth(""),
    "k_smooth_disturbed": lambda: _made_smooth("_disturbed"),
}
