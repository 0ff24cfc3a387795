"""Composite FMUs, their parts and an independent monolith are the same gantry.

The monolith knows none of our models: matched sections from SciPy's poles and
zeros, the command by its closed form in extended precision, the gantry by the
exact zero-order hold of its two modes with the table where it was at the begin of
each step, as the master holds it (Gordon 2010, eq. 4.1 to 4.31).
"""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.signal import zpk2tf
from simulated import simulated

Array = NDArray[np.float64]
T = 1 / 15_000
m, m_x, L, J_0, d, c, k = 2.722, 0.6977, 1.484, 0.4342, 0.1655, 18.17, 159_200.0
F_L = 221.28


def command(t: Array, stroke: float) -> tuple[Array, Array]:
    """Return position (m) and acceleration (m/s²) of one axis on the diagonal."""
    D = np.sqrt(np.longdouble(2)) * stroke
    V, A, J, S = (np.longdouble(v) for v in (0.2, 2, 50, 5000))
    stages = D / V, V / A, A / J, J / S
    s, a = (np.zeros(len(t), dtype=np.longdouble) for _ in range(2))
    for chosen in product((0, 1), repeat=4):
        tau = sum(i * T_i for i, T_i in zip(chosen, stages, strict=True))
        since = np.maximum(t.astype(np.longdouble) - tau, 0)
        s += (-1) ** sum(chosen) * S * since**4 / 24
        a += (-1) ** sum(chosen) * S * since**2 / 2
    half = np.sqrt(np.longdouble(0.5))
    return np.array(s * half, dtype=float), np.array(a * half, dtype=float)


def geometry(x: float) -> tuple[float, float, float]:
    """Return J, a_1, a_2 with the table at x."""
    a_1 = L / 2 - d * (1 - m_x / m) + m_x / m * x
    return J_0 + m_x * (d + x) ** 2, a_1, L - a_1


class Filter:
    """A matched section, direct form; zeros at infinity at -1, gain 1 at z = 1."""

    def __init__(self, zeros: list[complex], poles: list[complex]) -> None:
        z = [*np.exp(np.array(zeros) * T), *[-1.0] * (len(poles) - len(zeros))]
        p = np.exp(np.array(poles) * T)
        b, a = (np.real(v) for v in zpk2tf(z, p, 1.0))
        self.b, self.a = b * (np.sum(a) / np.sum(b)), a
        self.w = [0.0] * len(poles)

    def __call__(self, u: float) -> float:
        b, a, w = self.b, self.a, self.w
        y = b[0] * u + w[0]
        for i in range(len(w) - 1):
            w[i] = b[i + 1] * u - a[i + 1] * y + w[i + 1]
        w[-1] = b[-1] * u - a[-1] * y
        return float(y)


def roots(f_hz: float, zeta: float) -> list[complex]:
    w = 2 * np.pi * f_hz
    return list(np.roots([1, 2 * zeta * w, w * w]).astype(complex))


def notch(f_hz: float, zeta_N: float, zeta_D: float) -> Filter:
    return Filter(roots(f_hz, zeta_N), roots(f_hz, zeta_D))


def lead(omega: float, gamma: float) -> Filter:
    return Filter([-omega / gamma], [-omega * gamma])


class XControl:
    """C(s) h_x(s) and the mass feed-forward."""

    def __init__(self) -> None:
        omega, gamma = 2 * np.pi * 130, 4.16529977
        self.T_i = np.tan(np.deg2rad(80)) / omega
        self.leads = [lead(omega, gamma) for _ in range(2)]
        self.filters = [
            notch(186, 0.6, 0.7),
            notch(332, 0.3, 0.7),
            notch(404, 0.2, 0.7),
            Filter([], [-2 * np.pi * 1200]),
        ]
        self.v = self.e = 0.0

    def __call__(self, e: float, a: float) -> float:
        for section in self.leads:
            e = section(e)
        rho = np.exp(-T / self.T_i)
        self.v += T / (1 - rho) * (e - rho * self.e)
        self.e = e
        u = 6345303.494 * self.v
        for section in self.filters:
            u = section(u)
        return u + m_x * a


class YControl:
    """Eq. 4.30 and 4.31, scheduled by the commanded x."""

    def __init__(self) -> None:
        sin = np.sin(np.deg2rad(70))
        gamma = np.sqrt((1 + sin) / (1 - sin))
        self.packs = [
            [
                notch(110, 0.5, 0.7),
                notch(320, 0.2, 0.9),
                notch(400, 0.15, 1.0),
                notch(940, 0.6, 0.75),
                Filter([], roots(450, np.sqrt(0.5))),
                lead(2 * np.pi * 154, gamma),
            ]
            for _ in range(2)
        ]
        self.D = Filter([-1 / 0.004709660418], [-669.3477867])
        self.before = np.zeros(2)
        self.integral = np.zeros(2)

    def __call__(self, e: Array, a: float, x: float) -> Array:
        _, a_1, a_2 = geometry(x)
        alpha = np.array([a_2, a_1]) / L
        self.integral += T / 2 * (e + self.before)
        rate = (e - self.before) / T
        self.before = e
        twist = 49.03546478 * (rate[0] - rate[1]) * np.array([1, -1])
        w = 116158.8004 * self.D(float(alpha @ e)) + twist + 1e7 * self.integral
        u = alpha * w
        for i, pack in enumerate(self.packs):
            for section in pack:
                u[i] = section(u[i])
        return np.asarray(u + m * alpha * a)


def held_x() -> tuple[Array, Array]:
    """Return Φ and Γ of (x, v, f) over T."""
    M = np.zeros((4, 4))
    p = 2 * np.pi * F_L
    M[0, 1], M[1, 2], M[2, 2], M[2, 3] = 1, 1 / m_x, -p, p
    E = expm(M * T)
    return E[:3, :3], E[:3, 3]


def gantry_step(y: Array, v: Array, u: Array, x: float) -> tuple[Array, Array]:
    """Move the ends over T with held forces and the table held at x."""
    J, a_1, a_2 = geometry(x)
    alpha = np.array([a_2, a_1]) / L
    y_c, v_c = alpha @ y, alpha @ v
    theta, rate = (y[1] - y[0]) / L, (v[1] - v[0]) / L
    push = (u[0] + u[1]) / m
    y_c, v_c = y_c + T * v_c + T * T / 2 * push, v_c + T * push
    rest = (a_2 * u[1] - a_1 * u[0]) / k
    sigma, square = c / (2 * J), k / J
    w = np.sqrt(square - sigma**2)
    E, C, S = np.exp(-sigma * T), np.cos(w * T), np.sin(w * T) / w
    off = theta - rest
    theta = rest + E * (off * (C + sigma * S) + rate * S)
    rate = E * (rate * (C - sigma * S) - square * off * S)
    arms = np.array([-a_1, a_2])
    return y_c + arms * theta, v_c + arms * rate


def monolith(n: int, stroke: float, x_0: float, latency: int) -> dict[str, Array]:
    """Return table and ends of both axes on the diagonal, each (n,)."""
    s, a = command(np.arange(n) * T, stroke)
    Phi, Gamma = held_x()
    x_control, y_control = XControl(), YControl()
    x, y, v = np.array([x_0, 0.0, 0.0]), np.zeros(2), np.zeros(2)
    waiting = [(0.0, np.zeros(2))] * latency
    rows = np.empty((n, 3))
    for i in range(n):
        rows[i] = x[0], *y
        x_r = x_0 + s[i]
        u_x = x_control(x_r - x[0], a[i])
        u_y = y_control(s[i] - y, a[i], x_r)
        waiting.append((u_x, u_y))
        u_x, u_y = waiting.pop(0)
        y, v = gantry_step(y, v, u_y, x[0])
        x = Phi @ x + Gamma * u_x
    return dict(zip(("x_plant.x", "y_plant.y_1", "y_plant.y_2"), rows.T, strict=True))


@pytest.mark.parametrize("latency", [0, 1])
def test_the_fmus_are_the_monolith_while_the_table_moves(
    tmp_path: Path, latency: int
) -> None:
    late = [f"{axis}_controller.latency={latency}" for axis in "xy"]
    done = simulated(tmp_path, "gantry/mimo_diagonal_200", *late)
    reference = monolith(18_751, 0.1414, -0.0707, latency)
    for name, expected in reference.items():
        assert np.max(np.abs(done[name].values - expected)) < 1e-9 * 0.2, name
        # the errors are those of the feed-forward, 1e-8 m: they agree far closer
        assert np.max(np.abs(done[name].values - expected)) < 1e-13, name


def test_split_and_composite_controllers_are_bit_equal(tmp_path: Path) -> None:
    whole = simulated(tmp_path / "whole", "gantry/mimo_diagonal_200", "stop=1/2")
    split = simulated(tmp_path / "split", "gantry/mimo_split_diagonal_200", "stop=1/2")
    for name in ("x_plant.x", "y_plant.y_1", "y_plant.y_2", "y_plant.y_t"):
        assert np.array_equal(whole[name].values, split[name].values), name


def moving_table(n: int, stroke: float, x_0: float, parts: int) -> Array:
    """Return the ends (n, 2) with x moving through each step: RK4 of all states."""
    s, a = command(np.arange(n) * T, stroke)
    x_control, y_control = XControl(), YControl()
    p = 2 * np.pi * F_L
    spring = np.array([[1.0, -1.0], [-1.0, 1.0]]) / L**2

    def slope(q: Array, u_x: float, u_y: Array) -> Array:
        x, v_x, f, y, v = q[0], q[1], q[2], q[3:5], q[5:]
        J, a_1, a_2 = geometry(x)
        M = np.array(
            [[a_2**2 * m + J, a_1 * a_2 * m - J], [a_1 * a_2 * m - J, a_1**2 * m + J]]
        )
        force = u_y - spring @ (c * v + k * y)
        det = (M[0, 0] * M[1, 1] - M[0, 1] ** 2) / L**2
        acceleration = (
            np.array(
                [
                    M[1, 1] * force[0] - M[0, 1] * force[1],
                    M[0, 0] * force[1] - M[0, 1] * force[0],
                ]
            )
            / det
        )
        return np.array([v_x, f / m_x, p * (u_x - f), *v, *acceleration])

    q = np.array([x_0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    u_x, u_y = 0.0, np.zeros(2)
    rows = np.empty((n, 2))
    h = T / parts
    for i in range(n):
        rows[i] = q[3:5]
        x_r = x_0 + s[i]
        new = x_control(x_r - q[0], a[i]), y_control(s[i] - q[3:5], a[i], x_r)
        for _ in range(parts):
            k_1 = slope(q, u_x, u_y)
            k_2 = slope(q + h / 2 * k_1, u_x, u_y)
            k_3 = slope(q + h / 2 * k_2, u_x, u_y)
            k_4 = slope(q + h * k_3, u_x, u_y)
            q = q + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
        u_x, u_y = new
    return rows


def test_finer_exchange_converges_with_first_order_to_the_moving_table(
    tmp_path: Path,
) -> None:
    stroke, n = 0.02, 3001
    reference = moving_table(n, stroke, -0.0707, 2)
    shorter = [f"trajectory.stroke_{axis}={stroke}" for axis in "xy"]
    errors = []
    for parts in (1, 2, 4):
        steps = [f"{axis}_plant.step=1/{15_000 * parts}" for axis in "xy"]
        done = simulated(
            tmp_path / str(parts),
            "gantry/mimo_diagonal_200",
            "stop=1/5",
            *shorter,
            *steps,
        )
        ends = np.column_stack([done[f"y_plant.y_{i}"].values for i in (1, 2)])
        errors.append(np.max(np.abs(ends - reference)))
    assert errors[0] < 1e-9 * 0.2
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(2, rel=0.05)
