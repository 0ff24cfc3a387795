"""All three axes under the gridded LQG in one loop of NumPy, as ``contouring_loop``."""

from itertools import pairwise
from typing import Any

import numpy as np
from contouring_loop import AXES, Array, axis
from numpy.polynomial.legendre import leggauss
from scipy.linalg import block_diag, expm

Z = (
    *(6.4841, 0.008, 0.021887, 0.008134),
    [
        *(-114.5, -6.2e4, -9.4e8, -6.4e11, -2.1e15, -1.9e18, -4.6e19),
        *(-1.7e24, 2.3e27, -1.1e29, 4.3e32),
    ],
    [
        *(1.0, 584.926, 1.0176e7, 4.77323e9, 3.47326e13, 1.32677e16, 4.88049e19),
        *(1.47323e22, 2.52635e25, 5.42675e27, 2.40535e30, 3.57378e32),
    ],
)


def done(t: Array) -> Array:
    """Return the share of the path at t ≤ 9.5 s: 10 s with ramps of 0.5 s."""
    begun = np.clip(t, 0, 0.5)
    risen = begun / 2 - 0.5 / (2 * np.pi) * np.sin(np.pi * begun / 0.5)
    return (risen + np.clip(t - 0.5, 0, 9)) / 9.5


def tangent(q: Array) -> Array:
    """Return the tangent (3, n) at shares of the path."""
    alpha, psi = np.pi / 9 * (1 - np.cos(2 * np.pi * q)), 4 * np.pi * q
    flat = np.sin(alpha) * np.exp(1j * psi)
    return np.array([flat.real, flat.imag, np.cos(alpha)])


def run(content: dict[str, Any], T_s: float, stop: float) -> tuple[Array, Array]:
    """Return positions (n, 3) and commands (n, 3)."""
    parts = [axis(*a) for a in (*AXES, Z)]
    A, B, C = (block_diag(*p) for p in zip(*parts, strict=True))
    n = len(A)
    held = np.zeros((n + 3, n + 3))
    held[:n, :n], held[:n, n:] = A, B
    held = expm(held * T_s)
    F, G = held[:n, :n], held[:n, n:]

    q = done(T_s * np.arange(round(stop / T_s) + 1))
    points, weights = leggauss(8)
    steps = [
        0.25 * (b - a) * tangent((a + b) / 2 + (b - a) / 2 * points) @ weights
        for a, b in pairwise(q)
    ]
    r = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])

    law = {k: np.array(v) for k, v in content.items() if k not in ("period", "design")}
    gains = law["K"].reshape(len(law["q"]), -1)
    x, x_hat, w = np.zeros(n), np.zeros(len(law["F"])), np.zeros(len(law["A_w"]))
    positions, commands = [], []
    for k, share in enumerate(q):
        u_c, t = C @ x, tangent(share)
        e = r[k] - u_c
        K = np.array([np.interp(share, law["q"], g) for g in gains.T]).reshape(3, -1)
        u = -K @ np.concatenate([x_hat, w])
        T = np.vstack([t, (np.eye(3) - np.outer(t, t))[:2]])
        innovation = e - law["C"] @ x_hat
        x_hat = law["F"] @ x_hat + law["G"] @ u + law["L"] @ innovation
        w = law["A_w"] @ w + law["B_w"] @ T @ e
        positions.append(u_c)
        commands.append(u)
        x = F @ x + G @ u
    return np.array(positions), np.array(commands)
