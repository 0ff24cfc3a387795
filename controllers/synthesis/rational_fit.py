"""A stable transfer function from a frequency response, in real modal blocks.

    H(jω) ≈ Σ r_k/(jω - p_k),   p_k real or in conjugate pairs, Re p_k < 0

Poles are relocated: (Σ c_k φ_k)/(1 + Σ d_k φ_k) is fitted over the partial fractions
φ_k of the last poles, which is linear in c and d, and the zeros of its denominator
are the next poles; one that comes out unstable is mirrored.  Errors count relative to
|H|.

Source: Gustavsen and Semlyen 1999 (vector fitting); used where Hanifzadegan 2014,
sec. 8.3, constrains the poles of a maximum-likelihood fit.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from controllers.synthesis.frequency import ComplexArray
from fmus.model import FloatArray

PASSES = 30
LIGHT = 0.01  # damping ratio of the first poles


class Modes(NamedTuple):
    """Blocks [σ ω; -ω σ] on the diagonal of Λ; H(s) = c (sI - Λ)⁻¹ b.

    ``sigma``, ``b``, ``c`` are (n,), ``omega`` (n - 1,): beside the diagonal, 0
    between blocks.  Real poles come first.
    """

    sigma: FloatArray
    omega: FloatArray
    b: FloatArray
    c: FloatArray

    def response(self, omega: FloatArray) -> ComplexArray:
        """Return H at frequencies (m,) (rad/s)."""
        A = np.diag(self.sigma) + np.diag(self.omega, 1) - np.diag(self.omega, -1)
        s_A = 1j * np.asarray(omega)[:, None, None] * np.eye(len(A)) - A
        b = np.broadcast_to(self.b[:, None], (len(omega), len(A), 1))
        return np.asarray(np.linalg.solve(s_A, b)[:, :, 0] @ self.c)


def stable_fit(omega: FloatArray, H: ComplexArray, order: int) -> Modes:
    """Return the stable modes that explain a response.

    Args:
        omega: frequencies, shape (m,) (rad/s), positive.
        H: the response, shape (m,), nowhere zero.
        order: number of poles.

    Raises:
        ValueError: the shapes do not fit, or the response has too few points.
    """
    omega, H = np.asarray(omega, dtype=float), np.asarray(H, dtype=complex)
    if H.shape != omega.shape or len(omega) < order:
        raise ValueError(
            f"{H.shape} values at {omega.shape} frequencies do not determine "
            f"{order} poles and their residues"
        )
    # in units of the highest frequency
    unit = float(np.max(omega))
    s = np.asarray(1j * omega / unit, dtype=np.complex128)
    weight = 1 / np.abs(H)
    sizes = np.geomspace(np.min(omega), unit, order // 2 + 2)[1:-1] / unit
    poles = np.array([*(-sizes[:1] if order % 2 else []), *((-LIGHT + 1j) * sizes)])
    for _ in range(PASSES):
        basis = _fractions(s, poles)
        both = np.hstack([basis, -H[:, None] * basis])
        found = _solved(weight[:, None] * both, weight * H)
        poles = _zeros(poles, found[order:])
    c = _solved(weight[:, None] * _fractions(s, poles), weight * H)
    sigma, beside, b = _blocks(poles)
    return Modes(unit * sigma, unit * beside, b, unit * c)


def _fractions(s: ComplexArray, poles: ComplexArray) -> ComplexArray:
    """Return (sI - Λ)⁻¹ b, (m, n), of poles whose conjugates are meant as well."""
    columns = []
    for p in poles:
        if p.imag == 0:
            columns.append(1 / (s - p.real))
        else:
            size = (s - p.real) ** 2 + p.imag**2
            columns += [(s - p.real) / size, -p.imag / size]
    return np.array(columns).T


def _solved(A: ComplexArray, b: ComplexArray) -> FloatArray:
    """Return the real least-squares solution, columns scaled to one size."""
    rows, right = np.vstack([A.real, A.imag]), np.concatenate([b.real, b.imag])
    scale = np.linalg.norm(rows, axis=0)
    return np.asarray(np.linalg.lstsq(rows / scale, right, rcond=None)[0] / scale)


def _zeros(poles: ComplexArray, d: FloatArray) -> ComplexArray:
    """Return the zeros of 1 + d (sI - Λ)⁻¹ b, mirrored into the stable half."""
    sigma, beside, b = _blocks(poles)
    A = np.diag(sigma) + np.diag(beside, 1) - np.diag(beside, -1)
    found = np.linalg.eigvals(A - np.outer(b, d))
    found = -np.abs(found.real) + 1j * found.imag
    upper = found[found.imag >= 0]
    return np.asarray(sorted(upper, key=lambda p: (p.imag != 0, abs(p))))


def _blocks(poles: ComplexArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return Λ's diagonal and what is beside it, and b."""
    sigma: list[float] = []
    parts, b = [], []
    for p in poles:
        size = 1 if p.imag == 0 else 2
        sigma += [float(p.real)] * size
        parts.append(np.diag([float(p.imag)], 1) if size == 2 else np.zeros((1, 1)))
        b += [1.0, 0.0][:size]
    return np.array(sigma), np.diag(block_diag(*parts), 1), np.array(b)
