"""Figures of the drive's models that the source prints, from the models themselves.

Sources: Hanifzadegan 2014, ch. 3, Tables 3.1 to 3.4, eq. 3.15, 3.16.
"""

from typing import Any

import numpy as np

from controllers.ball_screw_lpv import reference
from controllers.synthesis.ball_screw_lpv import designs
from controllers.synthesis.ball_screw_lpv.plants import hybrid, over_x, over_x_and_mass
from controllers.synthesis.linearise import linearise
from fmus.model import Model, leaves
from plants.ball_screw_lpv import hybrid as hybrid_plant
from plants.ball_screw_lpv import lpv, lpv_mass, milling, motor_drive
from plants.ball_screw_lpv._screw import Screw, matrices

PAIR = ("k_track", "k_vib")
FULL = {"x_c": (0.1, 0.6), "m_wor": (0.0, 100.0)}  # m, kg: ranges of fig. 3.8 to 3.10


def parameters() -> dict[str, float]:
    """Return the parameters of the plants as they start, arrays as ``mode.zeta.1``.

    Those of ``motor_drive``, ``hybrid`` and ``lpv`` bear the names of the FMUs'; of
    ``lpv_mass`` only the mode, as ``mass.zeta.1``.
    """
    found: dict[str, float] = {}
    for model in (motor_drive.model, hybrid_plant.model, lpv.model):
        found |= _starts(model)
    coefficients = _starts(lpv_mass.model).items()
    return found | {
        name.replace("mode.", "mass."): value
        for name, value in coefficients
        if name.startswith("mode.")
    }


def analytic(
    x_c: float = 0.59, m_wor: float = 0.0, eta: float = 0.0475
) -> dict[str, float]:
    """Return M, K, C (SI) and the mode of the hybrid model at x_c (m), m_wor (kg).

    ``omega`` (rad/s) is the undamped frequency, ``zeta`` in percent.
    """
    p = Screw(eta=eta)
    m = matrices(x_c, m_wor, p)
    poles = np.linalg.eigvals(hybrid(x_c, m_wor, p).A)
    mode = max(poles, key=lambda pole: float(pole.imag))
    viscous = p.c_m / p.r_g**2
    found = {name: float(value) for name, value in m._asdict().items()}
    return found | {
        "c_m": viscous,
        "c_11": viscous + found["c_hys"],
        "omega": float(np.abs(mode)),
        "zeta": float(-100 * mode.real / np.abs(mode)),
    }


def extremes(points: int = 21) -> dict[str, float]:
    """Return the least and the largest ω (rad/s) and c_hys (kg/s) over the range of
    figures 3.8 to 3.10."""
    grid = [
        analytic(x_c, m_wor)
        for x_c in np.linspace(*FULL["x_c"], points)
        for m_wor in np.linspace(*FULL["m_wor"], points)
    ]
    found: dict[str, float] = {}
    for name in ("omega", "c_hys"):
        values = [point[name] for point in grid]
        found |= {f"{name}_min": min(values), f"{name}_max": max(values)}
    return found


def mode_in_stroke() -> dict[str, float]:
    """Return the lowest and highest frequency (Hz) of Table 3.3 over the stroke, and
    the lowest of Table 3.4 with 10 kg."""
    stroke = np.linspace(0.2, 0.6, 81)

    def frequency(A: Any) -> float:
        return float(np.max(np.abs(np.linalg.eigvals(A))) / (2 * np.pi))

    light = [frequency(over_x(x_c).A) for x_c in stroke]
    heavy = [frequency(over_x_and_mass(x_c, 10.0).A) for x_c in stroke]
    return {"lowest": min(light), "highest": max(light), "heavy": min(heavy)}


def current_loop() -> dict[str, float]:
    """Return DC gain of v_m → i (A/V), where it falls to 0.708 A/V and to -3 dB of
    its DC gain (rad/s), and its largest gain (A/V)."""
    system = linearise(motor_drive.model)
    kept = [i for i, column in enumerate(system.A.T) if np.any(column != 0)]
    A, B = system.A[np.ix_(kept, kept)], system.B[kept, 0]
    C = system.C[0, kept]
    omega = np.concatenate([[0.0], np.geomspace(10.0, 1e4, 40_001)])
    gain = np.abs(
        [C @ np.linalg.solve(1j * w * np.eye(len(kept)) - A, B) for w in omega]
    )

    def falls(level: float) -> float:
        return float(omega[np.flatnonzero(gain >= level)[-1]])

    return {
        "dc": float(gain[0]),
        "bandwidth": falls(10 ** (-3 / 20)),
        "relative_bandwidth": falls(gain[0] * 10 ** (-3 / 20)),
        "peak": float(np.max(gain)),
    }


def rigid_body() -> dict[str, float]:
    """Return J_e of eq. 3.3 (kg m²) as printed and calibrated, and the pole (rad/s)."""
    p = Screw()
    m_s = p.rho_s * np.pi * p.d_s**2 / 4 * p.l_s
    table, screw = p.r_g**2, m_s * p.d_s**2 / 8
    printed = 1.7e-4 + 9.3212e-7 + 4e-5 + 7.65e-5
    rigid = lpv.model.parameters.rigid
    return {
        "J_e_printed": 20 * table + screw + printed,
        "J_e_calibrated": p.m_tab * table + screw + p.J_m,
        "pole": -rigid.B_e / rigid.J_e,
        "mass": rigid.J_e / rigid.r_g**2,
    }


def cutting() -> dict[str, float]:
    """Return the cutting conditions in the units of Table 4.2, and the frequency at
    which teeth pass (rad/s)."""
    p = milling.Parameters()
    return {
        "depth": 1e3 * p.depth,
        "n": 60 * p.n_hz,
        "c": 1e3 * p.c,
        "D": 1e3 * p.D,
        "N": milling.TEETH,
        "beta": float(np.rad2deg(p.beta)),
        "K_tc": 1e-6 * p.K_tc,
        "K_rc": 1e-6 * p.K_rc,
        "K_te": 1e-3 * p.K_te,
        "K_re": 1e-3 * p.K_re,
        "tooth_pass": 2 * np.pi * p.n_hz * milling.TEETH,
    }


def weights() -> dict[str, float]:
    """Return the weights that the shipped designs were made with: gains in dB,
    frequencies in rad/s, W_v in 1/V."""
    track, vib = (designs.read(f"{name}.json")["design"]["weights"] for name in PAIR)
    found = {"W_v.track": track["W_v"], "W_v.vib": vib["W_v"]}
    orders = {"W_e": track["W_e"][3], "W_f": 1}
    for name, weight in (("W_e", track["W_e"]), ("W_f", vib["W_f"])):
        M_L, M_H, omega_b = weight[:3]
        found |= {
            f"{name}.M_L": 20 * float(np.log10(M_L)),
            f"{name}.M_H": 20 * float(np.log10(M_H)),
            f"{name}.omega_b": omega_b,
            f"{name}.order": orders[name],
        }
    return found


def move_time() -> dict[str, float]:
    """Return the time of one way (s) of the references of chapters 4 and 5."""
    fourth = reference.Parameters()
    fifth = fourth._replace(r_0=0.1, stroke=0.34)
    return {
        "chapter_4": reference.move_time(fourth),
        "chapter_5": reference.move_time(fifth),
    }


def _starts(model: Model) -> dict[str, float]:
    found: dict[str, float] = {}
    for leaf in leaves(model.parameters):
        values = np.ravel(np.asarray(leaf.value, dtype=float))
        if not np.ndim(leaf.value):
            found[leaf.name] = float(values[0])
            continue
        for i, value in enumerate(values):
            found[f"{leaf.name}.{i + 1}"] = float(value)
    return found
