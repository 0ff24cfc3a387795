"""Frequency responses from a sine that steps through frequencies, by its amplitude.

    x = Re{G A e^{jωt}} + harmonics:    G = (2/AN) Σ x_k e^{-jωt_k}  over whole periods

The first part of each dwell settles; the second half is projected on sine and cosine
of reference and position alike, so that a delay both share cancels.  A mechanism with
friction has another G at each amplitude: one run each.
Source: Maeda 2007, sec. 4.1, 4.2, fig. 4-2, 4-5, 4-9a.
"""

from typing import NamedTuple

import numpy as np

from controllers.references import stepped_sine
from controllers.synthesis.frequency import ComplexArray
from fmus.model import FloatArray


class Sweep(NamedTuple):
    """f_hz (n,), complex G (n,), and what is left beside the sine, of its size (n,)."""

    f_hz: FloatArray
    G: ComplexArray
    distortion: FloatArray


def frequencies(f_1: float, f_N: float, N: int, T_d: float) -> FloatArray:
    """Return the f_j (Hz), (N,), of ``controllers.references.stepped_sine``."""
    p = stepped_sine.Parameters(f_1=f_1, f_N=f_N, N=N, T_d=T_d)
    return np.asarray([float(stepped_sine.frequency(j, p)) for j in range(N)])


def respond(
    r: FloatArray,
    x: FloatArray,
    T_s: float,
    f_1: float,
    f_N: float,
    N: int,
    T_d: float,
) -> Sweep:
    """Return the response from r to x at every frequency of the sweep.

    Args:
        r, x: what was driven and what moved, at the same samples, (n,).
        T_s: sample time (s).
        f_1, f_N, N, T_d: of the reference (Hz, Hz, 1, s).

    Raises:
        ValueError: the records end before the last frequency does.
    """
    dwell = round(T_d / T_s)
    if len(x) < N * dwell:
        raise ValueError(
            f"{len(x)} samples do not hold {N} frequencies of {T_d:g} s: stop later"
        )
    f_hz = frequencies(f_1, f_N, int(N), T_d)
    G, distortion = [], []
    for j, f in enumerate(f_hz):
        k = np.arange(dwell - dwell // 2, dwell) + j * dwell
        turn = np.exp(-2j * np.pi * f * k * T_s)
        moved = np.asarray(x)[k] - np.mean(np.asarray(x)[k])
        driven = 2 * np.mean(np.asarray(r)[k] * turn)
        amplitude = 2 * np.mean(moved * turn)
        rest = moved - np.real(amplitude * np.conj(turn))
        G.append(amplitude / driven)
        distortion.append(np.std(rest) * np.sqrt(2) / np.abs(amplitude))
    return Sweep(f_hz, np.asarray(G), np.asarray(distortion))


def bandwidth(sweep: Sweep, level: float = 1 / np.sqrt(2)) -> float:
    """Return where |G| first falls through level (Hz), straight in log and log.

    Raises:
        ValueError: it does not fall so far.
    """
    size = np.log(np.abs(sweep.G) / level)
    i = np.flatnonzero((size[:-1] > 0) & (size[1:] <= 0))
    if not len(i):
        raise ValueError(f"the response does not fall through {level:.3g}")
    j = int(i[0])
    share = size[j] / (size[j] - size[j + 1])
    log_f = np.log(sweep.f_hz)
    return float(np.exp(log_f[j] + share * (log_f[j + 1] - log_f[j])))


def peak(sweep: Sweep, above_hz: float = 0.0) -> tuple[float, float]:
    """Return frequency (Hz) and |G| of the highest inner maximum above a frequency.

    A parabola through the three points in logarithms lies at its top.

    Raises:
        ValueError: there is none.
    """
    size, log_f = np.log(np.abs(sweep.G)), np.log(sweep.f_hz)
    inner = np.arange(1, len(size) - 1)
    tops = inner[(size[inner] > size[inner - 1]) & (size[inner] >= size[inner + 1])]
    tops = tops[sweep.f_hz[tops] > above_hz]
    if not len(tops):
        raise ValueError(f"the response has no peak above {above_hz:g} Hz")
    i = int(tops[np.argmax(size[tops])])
    curve = np.polyfit(log_f[i - 1 : i + 2] - log_f[i], size[i - 1 : i + 2], 2)
    top = -curve[1] / (2 * curve[0])
    return float(np.exp(log_f[i] + top)), float(np.exp(np.polyval(curve, top)))


def notch_at_peak(
    r: FloatArray,
    x: FloatArray,
    T_s: float,
    f_1: float,
    f_N: float,
    N: int,
    T_d: float,
    above_hz: float = 50.0,
    name: str = "notch.omega_hz",
) -> dict[str, float]:
    """Return the frequency of the peak by the name of a parameter: a design step.

    Args:
        r, x, T_s, f_1, f_N, N, T_d: as for ``respond``.
        above_hz: peaks below do not count (Hz).
        name: of the parameter that is set.
    """
    return {name: peak(respond(r, x, T_s, f_1, f_N, int(N), T_d), above_hz)[0]}
