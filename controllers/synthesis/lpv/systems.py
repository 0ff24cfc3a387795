"""State-space systems as bare matrices, and the plant a controller is designed for.

    ẋ = A x + B_1 w + B_2 u,   z = C_1 x + D_11 w + D_12 u,   y = C_2 x + D_21 w

w disturbs, z is to be small, y is measured, u = K y.  D_22 = 0.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import schur, solve_sylvester

Matrix: TypeAlias = NDArray[np.floating[Any]]
ComplexArray: TypeAlias = NDArray[np.complexfloating[Any, Any]]


class System(NamedTuple):
    """A, B, C, D of a continuous or sampled system."""

    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix


@dataclass(frozen=True)
class GeneralisedPlant:
    """The plant with its weights, as above; matrices are two-dimensional."""

    A: Matrix
    B_1: Matrix
    B_2: Matrix
    C_1: Matrix
    C_2: Matrix
    D_11: Matrix
    D_12: Matrix
    D_21: Matrix

    @property
    def order(self) -> int:
        return len(self.A)

    def close(self, K: System) -> System:
        """Return w → z with u = K y."""
        B_2D, B_2C = self.B_2 @ K.D, self.B_2 @ K.C
        return System(
            np.block([[self.A + B_2D @ self.C_2, B_2C], [K.B @ self.C_2, K.A]]),
            np.vstack([self.B_1 + B_2D @ self.D_21, K.B @ self.D_21]),
            np.hstack([self.C_1 + self.D_12 @ K.D @ self.C_2, self.D_12 @ K.C]),
            self.D_11 + self.D_12 @ K.D @ self.D_21,
        )


def series(first: System, then: System) -> System:
    """Return ``then`` behind ``first``; states of ``first`` come first."""
    zero = np.zeros((len(first.A), len(then.A)))
    return System(
        np.block([[first.A, zero], [then.B @ first.C, then.A]]),
        np.vstack([first.B, then.B @ first.D]),
        np.hstack([then.D @ first.C, then.C]),
        then.D @ first.D,
    )


def transformed(system: System, T: Matrix) -> System:
    """Return the same system in states x' with x = T x'."""
    A, B = np.linalg.solve(T, system.A @ T), np.linalg.solve(T, system.B)
    return System(A, B, system.C @ T, system.D)


def poles(system: System) -> ComplexArray:
    """Return the eigenvalues of A."""
    return np.asarray(np.linalg.eigvals(system.A), dtype=complex)


def abscissa(system: System) -> float:
    """Return the largest real part of the poles: negative if stable."""
    return float(np.max(poles(system).real))


def response(system: System, points: ComplexArray) -> ComplexArray:
    """Return C (s - A)⁻¹ B + D at points s or z (n,), shape (n, outputs, inputs)."""
    s_A = points[:, None, None] * np.eye(len(system.A)) - system.A
    inner = np.linalg.solve(
        s_A, np.broadcast_to(system.B, (len(points), *system.B.shape))
    )
    return np.asarray(system.C @ inner + system.D)


def tustin(system: System, T_s: float) -> System:
    """Return the system sampled every T_s by the trapezoidal rule."""
    half = T_s / 2 * system.A
    eye = np.eye(len(half))
    A = np.linalg.solve(eye - half, eye + half)
    B = np.linalg.solve(eye - half, system.B) * T_s
    C = np.linalg.solve((eye - half).T, system.C.T).T
    return System(A, B, C, system.D + C @ system.B * (T_s / 2))


def continuous(sampled: System, T_s: float) -> System:
    """Return the continuous system whose ``tustin`` is the sampled one."""
    eye = np.eye(len(sampled.A))
    A = np.linalg.solve((sampled.A + eye).T, (sampled.A - eye).T).T * (2 / T_s)
    half = eye - T_s / 2 * A
    B, C = half @ sampled.B / T_s, sampled.C @ half
    return System(A, B, C, sampled.D - sampled.C @ B * (T_s / 2))


def residualised(system: System, fastest: float) -> System:
    """Return the system with poles beyond ``fastest`` (rad/s) as static gain."""

    def kept(real: float, imaginary: float = 0.0) -> bool:
        return bool(abs(complex(real, imaginary)) < fastest)

    A, U, n = schur(system.A, output="real", sort=kept)
    if n == len(A):
        return system
    X = solve_sylvester(A[:n, :n], -A[n:, n:], -A[:n, n:])
    eye = np.eye(len(A))
    eye[:n, n:] = X
    split = transformed(system, U @ eye)
    C_fast = np.linalg.solve(split.A[n:, n:].T, split.C[:, n:].T).T
    return System(
        split.A[:n, :n],
        split.B[:n],
        split.C[:, :n],
        split.D - C_fast @ split.B[n:],
    )
