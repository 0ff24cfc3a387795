"""The serial machine and its controllers in one loop of plain NumPy.

It knows none of our models: Table 3.3 and the controllers' files are read once more,
both axes are one Runge-Kutta step per 60 us, their controllers run every sixth
instant, the path is the closed form of its moves in extended precision.
"""

import json
from itertools import product
from pathlib import Path
from typing import TypeAlias

import numpy as np
from ball_screw_lpv_loop import B_E, J_0, R_G, ROWS, T_S, H, between, whole
from numpy.typing import NDArray

import controllers.serial

Array = NDArray[np.float64]
Floats: TypeAlias = tuple[float, float, float, float]
FOLDER = Path(controllers.serial.__file__).parent
FILES = {
    "lpv": ("k_undisturbed",),
    "smooth": ("k_smooth",),
    "hysteresis": ("k_hysteresis_1", "k_hysteresis_2"),
}
VOLT, LOW, HIGH = 0.72 * 0.887 / 0.0032, 0.38, 0.42
SWEEP = 16_667  # steps, the first whole number of them in a second
V, A, J, S = 0.4, 1.0, 20.0, 1000.0


def travelled(length: float, k: int) -> float:
    """Return the arc length (m), k samples after a move of four stages began."""
    stages = [np.longdouble(n) / np.longdouble(d) for n, d in _stages(length)]
    t = np.longdouble(k) * np.longdouble(9) / 25_000
    s = np.longdouble(0)
    for chosen in product((0, 1), repeat=4):
        tau = sum(c * T for c, T in zip(chosen, stages, strict=True))
        s += (-1) ** sum(chosen) * np.maximum(t - tau, 0) ** 4 / 24
    return float(S * s)


def _stages(length: float) -> list[tuple[float, float]]:
    return [(length, V), (V, A), (A, J), (J, S)]


def path(k: int) -> Array:
    """Return the command (m) of both axes: a line, and most of the circle after it."""
    k_1 = int(np.ceil(0.1 / T_S))
    k_2 = k_1 + int(np.ceil((sum(n / d for n, d in _stages(0.24)) + 0.1) / T_S))
    s, phi = travelled(0.24, k - k_1), travelled(np.pi * 0.28 * 1.25, k - k_2) / 0.14
    return np.array([0.057 + s + 0.14 * np.sin(phi), 0.25 - 0.14 * np.cos(phi)])


def modes(x_c: float) -> list[float]:
    """Return ζ, ω, α_11, α_12, β_11, β_12 of Table 3.3 without run-out."""
    return [a + b * x_c + c * x_c**2 for a, b, c, _, _ in ROWS]


def rate(x: Floats, v_m: float, f_c: float) -> Floats:
    """Return ẋ; f_c drives the mode so that G_12 = G_21, by Cramer's rule."""
    zeta, omega, a_1, a_2, b_1, b_2 = modes(0.65 - x[0])
    first = 2 * zeta * omega * a_1 - omega**2 * b_1
    whole = first * b_1 - a_1 * a_1
    q_0, q_1 = (a_2 * b_1 - a_1 * b_2) / whole, (first * b_2 - a_1 * a_2) / whole
    f = VOLT * v_m
    spring = omega**2 * x[2] + 2 * zeta * omega * x[3]
    body = (R_G**2 * (f + f_c) - B_E * x[1]) / J_0
    return x[1], body, x[3] + q_0 * f_c, f + q_1 * f_c - spring


def ahead(x: Floats, h: float, k: Floats) -> Floats:
    return x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2], x[3] + h * k[3]


def stepped(x: Floats, v_m: float, f_c: float) -> Floats:
    k_1 = rate(x, v_m, f_c)
    k_2 = rate(ahead(x, H / 2, k_1), v_m, f_c)
    k_3 = rate(ahead(x, H / 2, k_2), v_m, f_c)
    k_4 = rate(ahead(x, H, k_3), v_m, f_c)
    for k, weight in ((k_1, 1), (k_2, 2), (k_3, 2), (k_4, 1)):
        x = ahead(x, weight * H / 6, k)
    return x


class Axis:
    """One axis with its controller."""

    def __init__(self, controller: str, u_0: float) -> None:
        files = [
            json.loads((FOLDER / f"{n}.json").read_text()) for n in FILES[controller]
        ]
        kept = ("A", "B", "C", "D", "x_c")
        tables = [{k: np.array(d[k]) for k in kept} for d in files]
        self.tables = [(t["x_c"], whole(t)) for t in tables]
        self.plant: Floats = (u_0, 0.0, 0.0, 0.0)
        self.x = np.zeros(7)
        self.region = 0

    def sample(self, r: float) -> tuple[float, float, float, float]:
        """Return table position, error, command and region."""
        u_0, _, q, q_1 = self.plant
        _, _, _, a_2, _, b_2 = modes(0.65 - u_0)
        u_c = u_0 + a_2 * q + b_2 * q_1
        e, x_c = r - u_c, 0.65 - u_c
        chosen = 1
        if len(self.tables) == 2:
            chosen = 2 if x_c >= HIGH else 1 if x_c <= LOW else max(self.region, 1)
        K = between(*self.tables[chosen - 1], x_c)
        if self.region not in (0, chosen):
            before = between(*self.tables[self.region - 1], x_c)[7]
            missing = (before - K[7]) @ np.append(self.x, e)
            self.x = self.x + np.linalg.pinv(K[7:, :7])[:, 0] * missing
        self.region = chosen
        z = K @ np.append(self.x, e)
        self.x = z[:7]
        return u_c, e, float(z[7]), float(chosen)


def run(controller: str, samples: int, force: float = 50.0) -> dict[str, Array]:
    """Return positions, errors, commands and regions, (2, samples)."""
    axes = Axis(controller, 0.057), Axis(controller, 0.11)
    rows = []
    for k in range(samples):
        now = [axis.sample(float(r)) for axis, r in zip(axes, path(k), strict=True)]
        rows.append(now)
        for n in range(6 * k, 6 * k + 6):
            t = n % SWEEP * H
            f_c = float(force * np.sin(2 * np.pi * (20 * t + 190 * t * t)))
            for axis, (_, _, v_m, _) in zip(axes, now, strict=True):
                axis.plant = stepped(axis.plant, v_m, f_c)
    found = np.array(rows).transpose(2, 1, 0)
    return dict(zip(("u_c", "e", "v_m", "region"), found, strict=True))
