"""Frequency response from records of input and output, and a drive fitted to it.

    Ĝ(f) = S_uy(f) / S_uu(f)                                the H1 estimate
    G(s) = b e^{-τs} / (s² + a_1 s + a_0) · (1 - e^{-sT}) / (sT)

Spectra are averaged over segments with a Hann window and half of overlap (Welch).
H1 is unbiased by noise in the output.  The last factor is the hold of a control signal
that changes at each sample T.  Weights are those of the estimate's variance,
(1 - γ²) / γ² with the coherence γ².
Source: Bendat and Piersol, Random Data, sec. 9.2; Anang et al. 2018, sec. 2.2.
"""

from typing import NamedTuple

import numpy as np
from scipy import optimize, signal

from controllers.synthesis.frequency import ComplexArray
from fmus.model import FloatArray


class Estimate(NamedTuple):
    """f_hz, complex G and the coherence, (n,), and of how many segments."""

    f_hz: FloatArray
    G: ComplexArray
    coherence: FloatArray
    segments: int


def h1(u: FloatArray, y: FloatArray, T_s: float, resolution_hz: float) -> Estimate:
    """Return the H1 estimate from u to y, (n,) each.

    Args:
        u, y: values at the same samples, in any units.
        T_s: sample time (s).
        resolution_hz: distance of the lines (Hz).

    Raises:
        ValueError: the records hold fewer than eight segments.
    """
    length = round(1 / (resolution_hz * T_s))
    segments = 2 * len(u) // length - 1
    if segments < 8:
        raise ValueError(
            f"{len(u)} values make {segments} segments of {1 / resolution_hz:g} s: "
            f"take a longer record or a coarser resolution"
        )
    how = {"fs": 1 / T_s, "nperseg": length, "detrend": "linear"}
    f_hz, S_uu = signal.welch(u, **how)
    _, S_yy = signal.welch(y, **how)
    _, S_uy = signal.csd(u, y, **how)
    coherence = np.abs(S_uy) ** 2 / (S_uu * S_yy)
    return Estimate(f_hz[1:], (S_uy / S_uu)[1:], coherence[1:], segments)


def second_order(
    found: Estimate, T_s: float, from_hz: float, to_hz: float
) -> dict[str, float]:
    """Return b, a_1 (1/s), a_0 (1/s²) and the dead time tau (s) of G between two ends.

    Least squares of the relative difference, weighted by its variance, from a linear
    start (Levy) over a row of dead times.

    Args:
        found: the estimate.
        T_s: sample time of the hold before the drive (s).
        from_hz, to_hz: the lines that count (Hz).

    Raises:
        ValueError: fewer than eight lines are there.
    """
    inside = (found.f_hz >= from_hz) & (found.f_hz <= to_hz)
    if np.count_nonzero(inside) < 8:
        raise ValueError(f"fewer than 8 lines from {from_hz:g} to {to_hz:g} Hz")
    s = np.asarray(2j * np.pi * found.f_hz[inside], dtype=np.complex128)
    G = found.G[inside] / (-np.expm1(-s * T_s) / (s * T_s))
    gamma = np.clip(found.coherence[inside], 1e-6, 1 - 1e-9)
    weight = np.sqrt(gamma / (1 - gamma))
    weight /= np.max(weight)

    def apart(x: FloatArray) -> FloatArray:
        b, a_1, a_0, tau = np.exp(x[0]), np.exp(x[1]), x[2] ** 2, x[3] * 1e-3
        model = b * np.exp(-tau * s) / (s * s + a_1 * s + a_0)
        difference = weight * (model / G - 1)
        return np.concatenate([difference.real, difference.imag])

    best: optimize.OptimizeResult | None = None
    for tau in (0.0, 1e-3, 2e-3, 4e-3):
        b, a_1, a_0 = _levy(s, np.asarray(G * np.exp(tau * s)), weight)
        start = [np.log(b), np.log(a_1), np.sqrt(a_0), tau * 1e3]
        low = [start[0] - 5, start[1] - 5, 0.0, 0.0]
        high = [start[0] + 5, start[1] + 5, 10 * start[2] + 100, tau * 1e3 + 10]
        how = {"bounds": (low, high), "x_scale": "jac", "xtol": 1e-12}
        one = optimize.least_squares(apart, start, **how)
        if best is None or one.cost < best.cost:
            best = one
    assert best is not None
    x = best.x
    return {
        "b": float(np.exp(x[0])),
        "a_1": float(np.exp(x[1])),
        "a_0": float(x[2] ** 2),
        "tau": float(1e-3 * x[3]),
    }


def identify(
    u: FloatArray,
    y: FloatArray,
    T_s: float,
    resolution_hz: float = 0.5,
    from_hz: float = 1.0,
    to_hz: float = 200.0,
    scale: float = 1.0,
) -> dict[str, float]:
    """Return what ``second_order`` finds in the H1 estimate: a design step.

    Args:
        u, y: records of a run, (n,), the control signal held from sample to sample.
        T_s: sample time (s).
        resolution_hz, from_hz, to_hz: as for ``h1`` and ``second_order``.
        scale: from the unit of y to that of the drive's position.
    """
    return second_order(h1(u, scale * y, T_s, resolution_hz), T_s, from_hz, to_hz)


def _levy(
    s: ComplexArray, G: ComplexArray, weight: FloatArray
) -> tuple[float, float, float]:
    """Return positive b, a_1, a_0 of G (s² + a_1 s + a_0) = b, by least squares."""
    w = weight / np.abs(G * s * s)
    columns = np.stack([np.ones_like(s), -G * s, -G], axis=1) * w[:, None]
    right = G * s * s * w
    both = np.concatenate([columns.real, columns.imag])
    scale = np.linalg.norm(both, axis=0)
    sides = np.concatenate([right.real, right.imag])
    found = np.linalg.lstsq(both / scale, sides, rcond=None)[0] / scale
    b, a_1, a_0 = (float(max(one, 1e-6)) for one in found)
    return b, a_1, a_0
