"""The machining centre's x and y axes and their controllers in one loop of NumPy.

It knows none of our models: Tables 8.1 and 8.2 are typed here once more, the axes are
exact under a held command (matrix exponential of their partial fractions), the series
of the controller is summed over the path's angle (Hanifzadegan 2014, ch. 8).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, expm

Array = NDArray[np.float64]
K_T, R = 0.4769, 0.05
AXES = (  # k_a, p_t, J_e, B_e, numerator and denominator of G_flex
    (
        *(6.4898, 0.010, 0.0071, 0.0678),
        [-17.06, -3.041e4, 2.396e8, 6.038e11, 1.689e15, 2.155e18],
        [1.0, 463.5, 9.845e6, 3.014e9, 2.409e13, 3.699e15, 2.6e18],
    ),
    (
        *(7.5768, 0.010, 0.00979, 0.0287),
        [53.38, 472.6, 3.023e8, 1.346e11, 5.354e13],
        [1.0, 169.5, 4.263e6, 4.736e8, 4.927e11, 3.874e13],
    ),
)


def axis(
    k_a: float, p_t: float, J: float, B: float, top: list[float], bottom: list[float]
) -> tuple[Array, Array, Array]:
    """Return A, B, C of an axis, from the roots of its denominator in 1000 rad/s."""
    scale = 1000.0 ** np.arange(len(bottom))[::-1]
    below = np.array(bottom) * scale / scale[0]
    above = np.array(top) * scale[-len(top) :] / scale[0]
    poles = np.concatenate([[0.0, -B / J / 1000], np.roots(below)])
    blocks, C = [], []
    for i, p in enumerate(poles):
        if p.imag < 0:
            continue
        rest = np.prod(p - np.delete(poles, i))
        residue = np.polyval(above, p) / rest * p_t / (2 * np.pi) * K_T * k_a / J / 1e6
        if p.imag == 0:
            blocks.append(np.array([[p.real]]))
            C += [residue.real]
        else:
            blocks.append(np.array([[p.real, p.imag], [-p.imag, p.real]]))
            C += [2 * residue.real, 2 * residue.imag]
    drive = np.concatenate([[1.0] + [0.0] * (len(b) - 1) for b in blocks])
    # poles and residues of p = s/1000: time in ms
    return block_diag(*blocks) * 1000, drive[:, None] * 1000, np.array([C])


def plant(T_s: float, inertia: tuple[float, float] = (1.0, 1.0)) -> Any:
    """Return F, G, C of both axes, held over T_s; inertias times a factor."""
    parts = [axis(*a[:2], a[2] * j, *a[3:]) for a, j in zip(AXES, inertia, strict=True)]
    A, B, C = (block_diag(*p) for p in zip(*parts, strict=True))
    n = len(A)
    held = np.zeros((n + 2, n + 2))
    held[:n, :n], held[:n, n:] = A, B
    held = expm(held * T_s)
    return held[:n, :n], held[:n, n:], C


def rose(t: Array) -> tuple[Array, Array]:
    """Return the command (2, n) and its angle; 5 s with ramps of 0.5 s."""
    w, begun = 2 * np.pi / 4.5, np.clip(t, 0, 0.5)
    left = np.clip(5 - t, 0, 0.5)

    def risen(s: Array) -> Array:
        return s / 2 - 0.5 / (2 * np.pi) * np.sin(np.pi * s / 0.5)

    p = w * (risen(begun) + np.clip(t - 0.5, 0, 4) + 0.25 - risen(left))
    z = R * np.cos(2 * p) * np.exp(1j * p)
    slope = (-2 * np.sin(2 * p) + 1j * np.cos(2 * p)) * np.exp(1j * p)
    return np.array([z.real, z.imag]), np.unwrap(np.angle(slope))


class PPI:
    """The cascade with its published-nowhere gains, every T_s."""

    def __init__(self, T_s: float) -> None:
        self.T_s, self.sum, self.last = T_s, np.zeros(2), np.zeros(2)

    def __call__(self, e: Array, y: Array, theta: float) -> Array:
        e_v = 20 * e - (y - self.last) / self.T_s
        self.last = y
        self.sum = self.sum + self.T_s / 0.05 * e_v
        return np.array([100.0, 50.0]) * (e_v + self.sum)


class Series:
    """K(θ) from the numbers of its file."""

    def __init__(self, content: dict[str, Any]) -> None:
        self.parts = [np.array(content[name]) for name in "ABCD"]
        self.x = np.zeros(self.parts[0].shape[-1])

    def __call__(self, e: Array, y: Array, theta: float) -> Array:
        k = np.arange(1, len(self.parts[0]) // 2 + 1)
        waves = np.array([np.cos(k * theta), np.sin(k * theta)]).T.ravel()
        waves = np.concatenate([[1.0], waves])
        A, B, C, D = (np.tensordot(waves, M, axes=1) for M in self.parts)
        u = C @ self.x + D @ e
        self.x = A @ self.x + B @ e
        return u


def run(
    law: Any, T_s: float, stop: float, inertia: tuple[float, float] = (1.0, 1.0)
) -> tuple[Array, Array]:
    """Return positions (n, 2), from the start of the path, and commands (n, 2)."""
    F, G, C = plant(T_s, inertia)
    n = round(stop / T_s) + 1
    r, theta = rose(T_s * np.arange(n))
    r = r - r[:, :1]
    x, positions, commands = np.zeros(len(F)), [], []
    for k in range(n):
        y = C @ x
        u = law(r[:, k] - y, y, theta[k])
        positions.append(y)
        commands.append(u)
        x = F @ x + G @ u
    return np.array(positions), np.array(commands)
