"""Figures of the designs, computed from the shipped tables; none is written down.

γ on the design's grid, dense γ and the certificate of the table come from X, Y and the
table by Cholesky factors, norms and responses from a frequency grid, radii from the
sampled loop with the plant held.  Decibels are 20 log10, gains of f_c → u_c in m/N.
"""

from functools import cache

import numpy as np

from controllers.synthesis.ball_screw_lpv import designs, smooth
from controllers.synthesis.ball_screw_lpv.k_vib import T_S
from controllers.synthesis.ball_screw_lpv.loops import NONE, Loop, crossing, held
from controllers.synthesis.ball_screw_lpv.plants import over_x, over_x_and_mass
from controllers.synthesis.lpv import linear, smooth_file
from controllers.synthesis.lpv.design import Verdict
from controllers.synthesis.lpv.frozen import frozen_optima
from controllers.synthesis.lpv.systems import (
    ComplexArray,
    Matrix,
    System,
    continuous,
    response,
)

MODE = np.linspace(900.0, 1800.0, 4501)  # rad/s, where the flexible mode is
WIDE = np.geomspace(10.0, 5000.0, 20_001)  # rad/s
HALF_POWER = 10 ** (-3 / 20)


def plant(x_c: float) -> dict[str, float]:
    """Return the peak of |G_22| of Table 3.3's smooth part at x_c (m) (dB)."""
    return {"g22_peak": _peak(response(over_x(x_c), 1j * MODE)[:, 1, 1])}


def k_track(x_c: float = 0.4, damped: bool = False) -> dict[str, float]:
    """Return what K_track does at x_c (m); ``damped``: the redesigned one with K_vib.

    ``gamma``, ``norm``; |S| at 1 rad/s ``s_1`` (dB); where S and T pass -3 dB
    (rad/s); ``radius`` of the sampled loop and ``radius_late`` with one sample more.
    """
    K_vib, file = NONE, "k_track.json"
    if damped:
        K_vib, file = designs.vibration().tables[0].at((x_c,)), "k_track_damped.json"
    content = designs.read(file)
    K = linear.read(content)
    wanted = designs.damped_plant() if damped else designs.tracking_plant()
    figures = {"gamma": content["design"]["gamma"], "norm": K.norm(wanted)}
    return figures | _tracking(over_x(x_c), K.system, K_vib)


def k_vib() -> dict[str, float]:
    """Return γ, dense γ and the table's certificate of K_vib, and frozen optima.

    ``frozen_0.2`` and ``frozen_0.6`` bound γ from below at either end of the stroke.
    """
    found = designs.vibration()
    ends = ((0.2,), (0.6,))
    frozen = frozen_optima(found.problem.plant, ends, found.problem.time)
    bounds = {
        f"frozen_{rho[0]:g}": float(g) for rho, g in zip(ends, frozen, strict=True)
    }
    return _certified(designs.verdict(found)) | bounds


def k_vib_at(x_c: float) -> dict[str, float]:
    """Return what K_track with K_vib does at x_c (m).

    ``reduction`` (dB): peak of f_c → u_c of the bare plant over that in the loop;
    the rest as of ``k_track``.
    """
    table = designs.vibration().tables[0]
    return _damping(over_x(x_c), table.at((x_c,)))


def switching(regions: int = 2) -> dict[str, float]:
    """Return γ, dense γ, the tables' certificate and the links of K_vib(x_c, m_wor).

    ``dense`` and ``table`` are the worst of the regions, ``links`` as in ``Verdict``.
    """
    found = designs.switched() if regions == 2 else designs.one_region()
    verdict = designs.verdict(found)
    lower = frozen_optima(found.problem.plant, found.problem.frozen, found.problem.time)
    return _certified(verdict) | {"links": verdict.links, "frozen": float(lower.max())}


def switching_at(x_c: float, m_wor: float, regions: int = 2) -> dict[str, float]:
    """Return what the loop of one or two regions does at x_c (m) and m_wor (kg).

    Keys as of ``k_vib_at``, bandwidths also in Hz as ``t_bandwidth_hz``.
    """
    if regions == 2:
        found = designs.switched()
        table = found.tables[0 if x_c < 0.26 else 1]
    else:
        table = designs.one_region().tables[0]
    figures = _damping(over_x_and_mass(x_c, m_wor), table.at((x_c, m_wor)))
    return figures | {"t_bandwidth_hz": figures["t_bandwidth"] / (2 * np.pi)}


def smooth_switching() -> dict[str, float]:
    """Return the dense γ of four smoothly switching controllers, η before and after.

    ``worst`` is the larger of the blend's γ and its table's.  η is that of
    ``smooth_file.verified``, in transitions, in the units of the design of one region
    (time in ms) and the states in which its storage function at 0.4 m, 5 kg is I.
    """
    content, begun = designs.read("k_vib_smooth.json"), designs.smooth_start()
    dense, names = smooth.dense(), designs.OVER_MASS
    found = smooth_file.verified(content, begun, names, dense)
    return found | {"worst": max(found["dense"], found["table"])}


@cache
def _k_track_sampled() -> System:
    return linear.read(designs.read("k_track.json")).system


def _certified(verdict: Verdict) -> dict[str, float]:
    return {
        "gamma": verdict.gamma,
        "dense": max(verdict.dense),
        "table": max(verdict.table),
    }


def _damping(bare: System, K_vib: System) -> dict[str, float]:
    K_track = _k_track_sampled()
    loop = Loop(bare, continuous(K_track, T_S), continuous(K_vib, T_S))
    before = _peak(response(bare, 1j * MODE)[:, 1, 1])
    after = _peak(loop.disturbance(1j * MODE))
    return {"reduction": before - after} | _tracking(bare, K_track, K_vib)


def _tracking(bare: System, K_track: System, K_vib: System) -> dict[str, float]:
    loop = Loop(bare, continuous(K_track, T_S), continuous(K_vib, T_S))
    low = WIDE[WIDE < 600.0]
    radii = [Loop(held(bare, T_S), K_track, K_vib, late).radius() for late in (0, 1)]
    return {
        "s_1": float(_dB(loop.sensitivity(np.array([1j])))[0]),
        "s_bandwidth": crossing(low, np.abs(loop.sensitivity(1j * low)), HALF_POWER),
        "t_bandwidth": crossing(WIDE, np.abs(loop.tracking(1j * WIDE)), HALF_POWER),
        "radius": radii[0],
        "radius_late": radii[1],
    }


def _peak(G: ComplexArray) -> float:
    return float(np.max(_dB(G)))


def _dB(G: ComplexArray) -> Matrix:
    return np.asarray(20 * np.log10(np.abs(G)))
