"""The ball screw with varying dynamics and its controllers in one loop of NumPy.

It knows none of our models: Tables 3.3 and 3.4 and the controllers' files are read
here once more, the plant is one Runge-Kutta step per 60 us with what the master holds
over it (command, force, nut distance and workpiece mass), the controller runs every
sixth instant (Hanifzadegan 2014, ch. 3 to 5).
"""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import controllers.ball_screw_lpv

Array = NDArray[np.float64]
H, T_S = 6e-5, 3.6e-4
R_G, J_0, B_E = 0.02 / (2 * np.pi), 7.1432e-4, 0.0156
VOLT = 0.72 * 0.887 / R_G
ROWS = (  # c_0 ... c_3, c_4 of zeta, omega, alpha_11, alpha_12, beta_11, beta_12
    (2.70e-2, -2.36e-2, 3.05e-2, -0.15e-2, -1.90),
    (1570.0, -490.0, 170.0, 0.0, -0.90),
    (5.05e-3, 7.05e-3, -3.83e-3, -0.22e-3, -2.90),
    (-11.3e-3, -5.2e-3, 2.90e-3, -0.4e-3, -6.19),
    (-0.99e-6, -2.52e-6, 2.60e-6, 0.396e-6, 1.90),
    (2.77e-6, 1.98e-6, -2.28e-6, -0.71e-6, -1.90),
)

Force = Callable[[float], float]
Law = Callable[[float, float], Array]


def over_x(x_c: float, m_wor: float) -> list[float]:
    """Return ζ, ω, α_11, α_12, β_11, β_12 of Table 3.3 with run-out."""
    return [
        a + b * x_c + c * x_c**2 + d * np.sin(x_c / R_G + e) for a, b, c, d, e in ROWS
    ]


def over_x_and_mass(x_c: float, m_wor: float) -> list[float]:
    """Return the same of Table 3.4, repaired."""
    d = 0.64 - x_c
    return [
        0.023,
        1299 - 15 * m_wor + 320 * d,
        (9.17 - 0.11 * m_wor - 3.9 * d) * 1e-3,
        (-15.35 + 0.41 * m_wor + 2.8 * d) * 1e-3,
        (-2.825 + 0.82 * d) * 1e-6,
        (5.15 - 0.08 * m_wor - 0.48 * d) * 1e-6,
    ]


def shipped(name: str) -> dict[str, Array]:
    """Return breakpoints and matrices of a shipped controller."""
    folder = Path(controllers.ball_screw_lpv.__file__).parent
    content = json.loads((folder / f"{name}.json").read_text())
    kept = {"A", "B", "C", "D", "x_c", "m_wor"} & content.keys()
    return {key: np.array(content[key], dtype=float) for key in kept}


def whole(table: dict[str, Array]) -> Array:
    """Return [A B; C D], the axes of the table in front."""
    A, B, C, D = (table[key] for key in "ABCD")
    return np.concatenate(
        [np.concatenate([A, B], axis=-1), np.concatenate([C, D], axis=-1)], axis=-2
    )


def between(points: Array, matrices: Array, at: float) -> Array:
    """Return matrices (n, ...) interpolated linearly and held beyond the ends."""
    at = min(max(at, points[0]), points[-1])
    i = min(int(np.searchsorted(points, at, side="right")) - 1, len(points) - 2)
    share = (at - points[i]) / (points[i + 1] - points[i])
    return np.asarray(matrices[i] * (1 - share) + matrices[i + 1] * share)


def scheduled(name: str) -> Law:
    """Return K(x_c, m_wor) of a shipped table."""
    table = shipped(name)
    K = whole(table)

    def at(x_c: float, m_wor: float) -> Array:
        here = between(table["x_c"], K, x_c)
        return between(table["m_wor"], here, m_wor) if "m_wor" in table else here

    return at


def reference(t: float, r_0: float, stroke: float) -> float:
    """Integrate the jerk of a move out and back, segment by segment."""
    V, A, J = 0.48, 2.0, 20.0
    cruise = stroke / V - V / A - A / J
    durations = [A / J, V / A - A / J, A / J, cruise, A / J, V / A - A / J, A / J]
    way, jerks = 1.0, (J, 0.0, -J, 0.0, -J, 0.0, J)
    if t > sum(durations):
        t, way = min(t - sum(durations), sum(durations)), -1.0
    s = v = a = 0.0
    for T, j in zip(durations, jerks, strict=True):
        T = min(T, t)
        s, v, a = (
            s + v * T + a * T**2 / 2 + j * T**3 / 6,
            v + a * T + j * T**2 / 2,
            (a + j * T),
        )
        t -= T
    return r_0 + s if way > 0 else r_0 + stroke - s


def milling(t: float, entry: float, leaves: float) -> float:
    """Return the resultant cutting force (N), by Gauss' rule along each edge."""
    nodes, weights = np.polynomial.legendre.leggauss(16)
    k_beta, depth = 2 * np.tan(np.pi / 6) / 18e-3, 2.7e-3
    F = np.zeros(2)
    for j in range(4):
        tip = 2 * np.pi * ((3400 / 60 * t + j / 4) % 1)
        low, high = np.clip([tip - k_beta * depth, tip], entry, leaves)
        phi = (high + low) / 2 + (high - low) / 2 * nodes
        dz = weights * (high - low) / 2 / k_beta
        F_t = (35e3 + 1980e6 * 1e-4 * np.sin(phi)) * dz
        F_r = (30e3 + 540e6 * 1e-4 * np.sin(phi)) * dz
        F += (
            -F_t @ np.cos(phi) - F_r @ np.sin(phi),
            F_t @ np.sin(phi) - F_r @ np.cos(phi),
        )
    return float(np.hypot(*F))


@dataclass
class Loop:
    """One run; ``law`` is K_vib(x_c, m_wor), ``switch`` chooses among several."""

    mode: Callable[[float, float], list[float]] = over_x
    laws: tuple[Law, ...] = ()
    on_motor: Force = lambda t: 0.0
    on_table: Force = lambda t: 0.0
    mass: Force = lambda t: 0.0
    r_0: float = 0.15
    stroke: float = 0.30
    stop: float = 1.95
    region: int = 0
    rows: dict[str, list[float]] = field(default_factory=dict)

    def run(self) -> dict[str, Array]:
        """Return time, u_c, u_m, v_m, e and region at every sample."""
        K_track = whole(shipped("k_track"))
        x_t = np.zeros(len(K_track) - 1)
        x_v = np.zeros(len(self.laws[0](0.4, 0.0)) - 1) if self.laws else np.zeros(0)
        x = np.array([self.r_0, 0.0, 0.0, 0.0])
        x_c, v_m = 0.65 - self.r_0, 0.0
        rows: dict[str, list[float]] = {n: [] for n in ("t", "u_c", "u_m", "v_m", "e")}
        rows["region"] = []
        u_m, u_c = self._read(x, x_c, self.mass(0.0))
        for k in range(round(self.stop / H) + 1):
            t = k * H
            if k:
                held = (k - 1) * H
                f_m, f_c = self.on_motor(held), self.on_table(held)
                m_wor, at = self.mass(held), x_c
                x = self._step(x, VOLT * v_m + f_m, f_c, at, m_wor)
                u_m, u_c = self._read(x, at, m_wor)
            x_c = 0.65 - u_c
            if k % 6 == 0:
                e = reference(t, self.r_0, self.stroke) - u_c
                z = K_track @ np.append(x_t, e)
                x_t, v_m = z[:-1], z[-1]
                if self.laws:
                    law = self._law(x_c)
                    z = law(x_c, self.mass(t)) @ np.append(x_v, u_m - u_c)
                    x_v, v_m = z[:-1], v_m + z[-1]
                for name, value in zip(rows, (t, u_c, u_m, v_m, e), strict=False):
                    rows[name].append(value)
                rows["region"].append(self.region + 1)
        return {name: np.array(values) for name, values in rows.items()}

    def _law(self, x_c: float) -> Law:
        if len(self.laws) > 1:
            if x_c >= 0.27:
                self.region = 1
            elif x_c <= 0.25:
                self.region = 0
        return self.laws[self.region]

    def _read(self, x: Array, x_c: float, m_wor: float) -> tuple[float, float]:
        _, _, a_1, a_2, b_1, b_2 = self.mode(x_c, m_wor)
        return x[0] + a_1 * x[2] + b_1 * x[3], x[0] + a_2 * x[2] + b_2 * x[3]

    def _step(self, x: Array, f: float, f_c: float, x_c: float, m_wor: float) -> Array:
        zeta, omega, a_1, a_2, b_1, b_2 = self.mode(x_c, m_wor)
        G = np.array([[2 * zeta * omega * a_1 - omega**2 * b_1, a_1], [a_1, b_1]])
        q_0, q_1 = np.linalg.solve(G, [a_2, b_2])
        J = J_0 + R_G**2 * m_wor

        def rate(x: Array) -> Array:
            T_f = (0.3686 if x[1] > 0 else 0.2551) * np.tanh(x[1] / 1e-3)
            motor = f - T_f / R_G
            return np.array(
                [
                    x[1],
                    (R_G**2 * (motor + f_c) - B_E * x[1]) / J,
                    x[3] + q_0 * f_c,
                    motor + q_1 * f_c - omega**2 * x[2] - 2 * zeta * omega * x[3],
                ]
            )

        k_1 = rate(x)
        k_2 = rate(x + H / 2 * k_1)
        k_3 = rate(x + H / 2 * k_2)
        k_4 = rate(x + H * k_3)
        return x + H / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
