"""The shipped designs of this drive: made anew, read back, certified.

    k_track            K_track, the rigid body
    k_vib              K_vib(x_c) around it
    k_vib_one_region   K_vib(x_c, m_wor)
    k_vib_switched     the same on two regions, a file each
    k_vib_smooth       the same in four that hand over smoothly, for proof alone
    k_track_damped     K_track for the drive that K_vib(0.4 m) damps

Each is a data file beside the run-time controllers.  A design builds on the shipped
ones before it.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import controllers.ball_screw_lpv
from controllers.synthesis.ball_screw_lpv import k_track, k_vib, smooth, switching
from controllers.synthesis.ball_screw_lpv.plants import over_x
from controllers.synthesis.lpv import linear, shipped, smooth_file
from controllers.synthesis.lpv.descent import find_shares
from controllers.synthesis.lpv.design import Design, Verdict, verify
from controllers.synthesis.lpv.problem import Point, Problem
from controllers.synthesis.lpv.smooth import Smooth, certified
from controllers.synthesis.lpv.systems import GeneralisedPlant, System, continuous

FOLDER = Path(controllers.ball_screw_lpv.__file__).parent
DAMPED_AT = 0.4  # m
DAMPED_W_V = 1e-4  # 1/V
OVER_MASS = ["x_c", "m_wor"]
WEIGHTS = {"W_f": k_vib.W_F, "W_v": k_vib.W_V, "eps": k_vib.EPS}


def read(file: str) -> Any:
    """Return the content of a shipped file."""
    return json.loads((FOLDER / file).read_text())


def tracking() -> System:
    """Return the shipped K_track, continuous."""
    return linear.read(read("k_track.json")).K


def tracking_plant() -> GeneralisedPlant:
    """Return what K_track is designed for."""
    return k_track.plant_with_weights()


def damped_plant() -> GeneralisedPlant:
    """Return what the redesigned K_track is designed for."""
    table = vibration().tables[0]
    K_vib = continuous(table.at((DAMPED_AT,)), table.T_s)
    plant = k_track.damped(over_x(DAMPED_AT), K_vib)
    return k_track.plant_with_weights(W_v=DAMPED_W_V, plant=plant)


def vibration() -> Design:
    """Return the shipped K_vib."""
    return shipped.read(k_vib.problem(tracking()), [read("k_vib.json")], ["x_c"])


def one_region() -> Design:
    """Return the shipped K_vib over position and mass."""
    files = [read("k_vib_one_region.json")]
    return shipped.read(switching.one_region(tracking()), files, OVER_MASS)


def switched() -> Design:
    """Return the shipped K_vib of two regions."""
    files = [read(f"k_vib_region_{i}.json") for i in (1, 2)]
    return shipped.read(switching.two_regions(tracking()), files, OVER_MASS)


def smooth_start() -> Smooth:
    """Return what four smoothly switching controllers start from."""
    begun = smooth.start(one_region())
    return replace(begun, history=(certified(begun, begun.problem.points),))


def dense_of(problem: Problem) -> tuple[tuple[Point, ...], ...]:
    """Return the grids on which this drive's designs are judged."""
    if len(problem.axes[0]) == 1:
        return (k_vib.dense(),)
    return tuple(switching.dense(a[0][0], a[0][-1]) for a in problem.axes)


def verdict(found: Design) -> Verdict:
    """Return what a design keeps, without a solver."""
    return verify(found, dense_of(found.problem))


def _made(problem: Problem, names: list[str], files: list[str]) -> dict[str, str]:
    return shipped.make(problem, dense_of(problem), names, files, WEIGHTS)


def _k_track() -> dict[str, str]:
    plant, found = tracking_plant(), k_track.design()
    weights = {"W_e": k_track.W_E, "W_v": k_track.W_V, "delta": k_track.DELTA}
    made = linear.linear(found.K, k_vib.T_S)
    content = linear.contents(made, plant, found.gamma, weights)
    return {"k_track.json": shipped.text(content)}


def _k_track_damped() -> dict[str, str]:
    table = vibration().tables[0]
    K_vib = continuous(table.at((DAMPED_AT,)), table.T_s)
    G = k_track.damped(over_x(DAMPED_AT), K_vib)
    found = k_track.design(W_v=DAMPED_W_V, plant=G, fastest=6e4)
    plant = k_track.plant_with_weights(W_v=DAMPED_W_V, plant=G)
    weights = {"W_e": k_track.W_E, "W_v": DAMPED_W_V, "delta": k_track.DELTA}
    made = linear.linear(found.K, k_vib.T_S)
    content = linear.contents(made, plant, found.gamma, weights)
    return {"k_track_damped.json": shipped.text(content)}


def _k_vib() -> dict[str, str]:
    return _made(k_vib.problem(tracking()), ["x_c"], ["k_vib.json"])


def _k_vib_one_region() -> dict[str, str]:
    problem = switching.one_region(tracking())
    return _made(problem, OVER_MASS, ["k_vib_one_region.json"])


def _k_vib_switched() -> dict[str, str]:
    files = ["k_vib_region_1.json", "k_vib_region_2.json"]
    return _made(switching.two_regions(tracking()), OVER_MASS, files)


def _k_vib_smooth() -> dict[str, str]:
    found, axes = find_shares(smooth_start()), (switching.WHOLE, switching.MASSES)
    text = smooth_file.text(found, OVER_MASS, axes, k_vib.T_S, smooth.dense(), WEIGHTS)
    return {"k_vib_smooth.json": text}


DESIGNS: Mapping[str, Callable[[], dict[str, str]]] = {
    "k_track": _k_track,
    "k_vib": _k_vib,
    "k_vib_one_region": _k_vib_one_region,
    "k_vib_switched": _k_vib_switched,
    "k_vib_smooth": _k_vib_smooth,
    "k_track_damped": _k_track_damped,
}
