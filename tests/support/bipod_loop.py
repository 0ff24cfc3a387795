"""Bipod and its LPV controllers in one loop of plain NumPy, from kinetic energy.

The mechanism is not that of ``plants.bipod``: inertia from the masses' Jacobians, its
derivative by complex step.  Controllers are read from the shipped files.
"""

import json
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import controllers.bipod

Array = NDArray[np.float64]
FOLDER = Path(controllers.bipod.__file__).parent
FILES = {
    "lpv": ("k_tuned",),
    "smooth": ("k_smooth_tuned",),
    "hysteresis": ("k_hysteresis_1", "k_hysteresis_2"),
}
L, A_S, B_X, B_PHI = 0.7, 0.125, 50.0, 10.0
M_1, M_3, M_S, J_S = 25.36, 10.56, 4.16, 0.37
SINE_0 = np.sin(np.pi / 18)
FINE = 1 / 20_000


def sine_of(x):  # type: ignore[no-untyped-def]
    return SINE_0 - x / (2 * L)


def doubled_energy(x):  # type: ignore[no-untyped-def]
    """Twice the kinetic energy at unit speed of T1, T2 at rest: H_1."""
    sine = sine_of(x)
    cosine = np.sqrt(1 - sine * sine)
    y = sine / cosine / 2  # of T3; the rods' centres move half as much
    turn = 1 / (2 * L * cosine)
    total = M_1 + M_3 * (0.25 + y * y) + 3 * J_S * turn * turn
    for along in (3 / 4, 3 / 4, 1 / 4):
        total = total + M_S * (along * along + y * y / 4)
    return total


def acceleration(x: float, v: float, f_1: float, f_d: float) -> float:
    sine = sine_of(x)
    tangent = sine / np.sqrt(1 - sine * sine)
    slope = np.imag(doubled_energy(x + 1e-20j)) / 1e-20
    turn = 1 / (2 * L * np.sqrt(1 - sine * sine))
    lost = B_X * v + B_PHI * turn * turn * v
    return float(
        (f_1 + f_d * tangent / 2 - lost - slope * v * v / 2) / doubled_energy(x)
    )


def command(t: float) -> float:
    """The pulse profile by its acceleration, integrated exactly piece by piece."""
    V, A, t_j = 1.0, 7.0, 0.07542
    stroke = 2 * L * (np.sin(np.deg2rad(80)) - SINE_0)
    end = stroke / V + t_j / 2 + 7 * V / (6 * A)
    knots = [0, t_j, V / A, V / A + t_j, end - 2 * V / A, end]
    values = [0, A, A, 0, 0, -A]
    t = end - abs(t - end)
    s = v = 0.0
    for a, b, low, high in zip(
        knots[:-1], knots[1:], values[:-1], values[1:], strict=True
    ):
        d = min(max(t - a, 0.0), b - a)
        jerk = (high - low) / (b - a)
        s += v * d + low * d * d / 2 + jerk * d**3 / 6
        v += low * d + jerk * d * d / 2
    return -s


def between(table: tuple[Array, Array, Array], phi: float, v: float) -> Array:
    angles, speeds, K = table
    x = np.clip(phi, angles[0], angles[-1])
    i = min(int(np.searchsorted(angles, x, side="right")), len(angles) - 1)
    part = (x - angles[i - 1]) / (angles[i] - angles[i - 1])
    at_speeds = K[i - 1] + part * (K[i] - K[i - 1])
    share = np.clip((v - speeds[0]) / (speeds[1] - speeds[0]), 0, 1)
    return np.asarray(at_speeds[0] + share * (at_speeds[1] - at_speeds[0]))


@dataclass
class Loop:
    """A controller of ``FILES`` on slider T1, 200 N of chirp on the tool table."""

    controller: str

    def run(self, stop: float) -> dict[str, Array]:
        tables, unit, T_s = [], 1.0, 1e-4
        for name in FILES[self.controller]:
            d = json.loads((FOLDER / f"{name}.json").read_text())
            assert float(Fraction(d["period"])) == T_s
            A, B, C, D = (np.array(d[k]) for k in "ABCD")
            K = np.block([[A, B], [C, D]])
            shape = (len(d["phi"]), 2, *K.shape[-2:])
            tables.append((np.array(d["phi"]), np.array(d["v_1"]), K.reshape(shape)))
            weights = d["design"]["weights"]
            unit = 1 / (weights["W_v"] * weights["m_0"])
        x = v = 0.0
        state, region = np.zeros(5), 1
        rows: dict[str, list[float]] = {n: [] for n in ("x_1", "e", "f_1", "region")}
        for k in range(round(stop / T_s) + 1):
            phi, e = float(np.arcsin(sine_of(x))), command(k * T_s) - x
            chosen = region
            if len(tables) == 2:
                up, down = np.deg2rad(75.4), np.deg2rad(70)
                chosen = 2 if phi >= up else 1 if phi <= down else region
            K = between(tables[chosen - 1], phi, v)
            if chosen != region:
                u = between(tables[region - 1], phi, v)[5] @ np.append(state, e)
                row = K[5, :5]
                state = state + np.linalg.pinv(row[None])[:, 0] * (
                    u - K[5] @ np.append(state, e)
                )
                region = chosen
            z = K @ np.append(state, e)
            state, f_1 = z[:5], float(doubled_energy(x) * unit * z[5])
            for name, value in zip(rows, (x, e, f_1, region), strict=True):
                rows[name].append(float(value))
            for n in (2 * k, 2 * k + 1):
                t = n * FINE
                f_d = 200 * np.sin(2 * np.pi * (10 * t + 17 * t * t))
                x, v = runge_kutta(x, v, f_1, f_d)
        return {name: np.array(values) for name, values in rows.items()}


def runge_kutta(x: float, v: float, f_1: float, f_d: float) -> tuple[float, float]:
    h = FINE
    a_1 = acceleration(x, v, f_1, f_d)
    v_2 = v + h / 2 * a_1
    a_2 = acceleration(x + h / 2 * v, v_2, f_1, f_d)
    v_3 = v + h / 2 * a_2
    a_3 = acceleration(x + h / 2 * v_2, v_3, f_1, f_d)
    v_4 = v + h * a_3
    a_4 = acceleration(x + h * v_3, v_4, f_1, f_d)
    return (
        x + h / 6 * (v + 2 * v_2 + 2 * v_3 + v_4),
        v + h / 6 * (a_1 + 2 * a_2 + 2 * a_3 + a_4),
    )
