"""Figures of chapter 8 that need no simulation in time."""

import json

import numpy as np

from controllers.synthesis.contouring_lpv import designs, lqg, planar
from controllers.synthesis.lpv.frozen import frozen_optima
from controllers.synthesis.lpv.systems import ComplexArray, System, response
from plants.three_axis import _axes
from plants.three_axis._axes import X, Y, Z

AXES = {"x": X, "y": Y, "z": Z}
GRID = np.logspace(0, 4, 801)  # rad/s; sensitivities are told at its first


def parameters() -> dict[str, float]:
    """Return Tables 8.1, 8.3 and 8.4 as they are used."""
    found: dict[str, float] = {}
    for name, axis in AXES.items():
        rigid = {n: getattr(axis, n) for n in ("k_a", "k_t", "p_t", "J_e", "B_e")}
        found |= {f"{n}.{name}": value for n, value in rigid.items()}
    weights = {
        "planar.t": planar.W_T,
        "planar.n": planar.W_N,
        "space.t": lqg.W_T,
        "space.n": lqg.W_N,
    }
    for name, (low, high, crossing, k) in weights.items():
        found |= {
            f"{name}.M_L": 20 * np.log10(low),
            f"{name}.M_H": high,
            f"{name}.M_H_db": 20 * np.log10(high),
            f"{name}.omega_b": crossing,
            f"{name}.k_W": float(k),
        }
    return found


def axis(name: str) -> dict[str, float]:
    """Return gains of an axis (m/V) and its modes, from the printed polynomials."""
    source = AXES[name]
    found = _axes.modes(source)
    model = planar.axis_model(source, np.inf)
    gains = np.abs(response(model, 1j * np.array([1.0, 50.0, 340.0]))[:, 0, 0])
    told = {f"gain_{w}": float(g) for w, g in zip((1, 50, 340), gains, strict=True)}
    told["static"] = source.numerator[-1] / source.denominator[-1]
    told["slowest"] = float(np.max(found.poles[2:].real))
    flexible = [p for p in found.poles[2:] if p.imag > 0]
    for k, pole in enumerate(sorted(flexible, key=abs), start=1):
        told[f"omega_{k}"] = float(abs(pole))
        told[f"zeta_{k}"] = float(-pole.real / abs(pole))
    return told


def frozen(theta: float) -> float:
    """Return the H-infinity optimum of the plant whose path keeps θ (rad)."""
    problem = planar.problem()
    at = ((theta,),)
    return float(frozen_optima(problem.plant, at, problem.time, problem.gain)[0])


def certified() -> dict[str, float]:
    """Return γ on the grid, dense γ and the certificate of the series."""
    verdict = designs.verdict(designs.read())
    return {
        "gamma": verdict.gamma,
        "dense": verdict.dense[0],
        "table": verdict.table[0],
    }


def sensitivity(theta: float) -> dict[str, float]:
    """Return how commands along and across a path of direction θ become errors.

    The sampled loop with all modes, in dB at 1 rad/s, and the rad/s of -3 dB.
    """
    K = designs.read().tables[0].at((theta,))
    T = planar.rotation(theta)
    S = _errors([X, Y], K, planar.T_S)
    turned = T @ S @ T.T
    return _told({"t": turned[:, 0, 0], "n": turned[:, 1, 1]})


def sensitivity_in_space(q: float) -> dict[str, float]:
    """Return the same of the gridded LQG at a share q of the path.

    Of the errors across the path those that x and y commands leave in x and y.
    """
    shipped = json.loads((designs.FOLDER / "lqg_spatial.json").read_text())
    F, G, C, L, A_w, B_w = (
        np.array(shipped[name]) for name in ("F", "G", "C", "L", "A_w", "B_w")
    )
    gains = np.array(shipped["K"]).reshape(len(shipped["q"]), 3, -1)
    K = np.array(
        [[np.interp(q, shipped["q"], column) for column in row] for row in gains.T]
    ).T
    T = lqg.along(np.array([q]))[0]
    n, k = len(F), len(A_w)
    A = np.block([[F - L @ C - G @ K[:, :n], -G @ K[:, n:]], [np.zeros((k, n)), A_w]])
    law = System(A, np.vstack([L, B_w @ T]), -K, np.zeros((3, 3)))
    S = _errors([X, Y, Z], law, lqg.T_S)
    task = T @ S
    t = T[0]
    return _told({"t": (task @ t)[:, 0], "x": task[:, 1, 0], "y": task[:, 2, 1]})


def _errors(axes: list[_axes.Axis], K: System, T_s: float) -> ComplexArray:
    """Return (I + G K)⁻¹ of sampled axes and controller over ``GRID``."""
    plant = planar.beside([planar.axis_model(a, np.inf) for a in axes])
    F, G = lqg.held(plant, T_s)
    z = np.exp(1j * GRID * T_s)
    loop = response(System(F, G, plant.C, plant.D), z) @ response(K, z)
    return np.asarray(np.linalg.inv(np.eye(len(axes)) + loop))


def _told(of: dict[str, ComplexArray]) -> dict[str, float]:
    found = {}
    for name, values in of.items():
        size = np.abs(values)
        found[f"{name}.low"] = float(20 * np.log10(size[0]))
        above = np.flatnonzero(size >= np.sqrt(0.5))
        found[f"{name}.bandwidth"] = float(GRID[above[0]])
        found[f"{name}.peak"] = float(20 * np.log10(np.max(size)))
    return found
