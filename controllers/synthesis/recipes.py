"""Gains to start from: a loop's bandwidth and damping instead of its raw numbers.

All that is slow in a loop besides its plant, sampling, filters and dead time, counts
as one small time constant T_σ, the sum of them.

    current    K_p = ω_b L,  K_i = ω_b R                                    (1)
    velocity   K_p = m/(a T_σ),  K_i = K_p/(a² T_σ)                         (2)
    position   K_v = 1/(4 D² T_e),  T_e = a T_σ                             (3)
    notch      ω_n at the resonance, ζ_z its own damping, ζ_p = 0.7         (4)

(1) cancels the winding's pole and leaves a first-order loop of bandwidth ω_b;
(2) is the symmetrical optimum of m ẍ = u with crossover 1/(a T_σ), where the phase
is largest, a = (1 + sin φ)/cos φ for a phase margin φ; (3) gives a position loop with
damping D over a velocity loop that lags by T_e.
Sources: Harnefors and Nee 1998 (1); Kessler 1958, a after Leonhard 2001 (2); (3) is
the damping of T_e s² + s + K_v.
"""

from typing import NamedTuple

import numpy as np

from controllers.synthesis.frequency import ComplexArray
from fmus.model import FloatArray


class Pi(NamedTuple):
    """Proportional and integral gain, u = K_p e + K_i ∫e dt."""

    K_p: float
    K_i: float


class Cascade(NamedTuple):
    """Position and velocity loop: K_v (1/s) over a PI."""

    K_v: float
    velocity: Pi


class Notch(NamedTuple):
    """Frequency (Hz), damping of its zeros and of its poles."""

    f_hz: float
    zeta_z: float
    zeta_p: float


def current_loop(L: float, R: float, bandwidth_hz: float) -> Pi:
    """Return the PI of a winding with inductance L (H) and resistance R (Ohm).

    Raises:
        ValueError: one of them is not positive.
    """
    _refuse_not_positive(L=L, R=R, bandwidth_hz=bandwidth_hz)
    omega_b = 2 * np.pi * bandwidth_hz
    return Pi(omega_b * L, omega_b * R)


def symmetrical_optimum(m: float, T_sigma: float, phase_margin: float) -> Pi:
    """Return the velocity PI of the mass m for a phase margin (rad).

    ``m`` is in units of u per acceleration, ``T_sigma`` (s) all small lags together.

    Raises:
        ValueError: a number is not positive, or the margin not below 90 degrees.
    """
    _refuse_not_positive(m=m, T_sigma=T_sigma)
    a = spread(phase_margin)
    K_p = m / (a * T_sigma)
    return Pi(K_p, K_p / (a * a * T_sigma))


def spread(phase_margin: float) -> float:
    """Return a of the symmetrical optimum for a phase margin (rad).

    Raises:
        ValueError: it is not between 0 and π/2.
    """
    if not 0 < phase_margin < np.pi / 2:
        raise ValueError(
            f"a phase margin of {np.rad2deg(phase_margin):.4g} degrees is not between "
            f"0 and 90"
        )
    return float((1 + np.sin(phase_margin)) / np.cos(phase_margin))


def position_gain(T_e: float, damping: float) -> float:
    """Return K_v (1/s) over a velocity loop that lags by T_e (s).

    Raises:
        ValueError: one of them is not positive.
    """
    _refuse_not_positive(T_e=T_e, damping=damping)
    return 1 / (4 * damping**2 * T_e)


def cascade(
    m: float, T_sigma: float, phase_margin: float = np.pi / 4, damping: float = 1.0
) -> Cascade:
    """Return K_v and PI of the mass m behind lags T_sigma (s), as (2) and (3).

    Raises:
        ValueError: as of the two.
    """
    T_e = spread(phase_margin) * T_sigma
    velocity = symmetrical_optimum(m, T_sigma, phase_margin)
    return Cascade(position_gain(T_e, damping), velocity)


def of_bandwidths(
    m: float, velocity_hz: float, integral_hz: float, position_hz: float
) -> Cascade:
    """Return the gains of a mass m whose velocity loop crosses over at velocity_hz,
    whose PI turns at integral_hz and whose position loop at position_hz.

    Raises:
        ValueError: one of them is not positive.
    """
    _refuse_not_positive(m=m, velocity_hz=velocity_hz, position_hz=position_hz)
    _refuse_not_positive(integral_hz=integral_hz)
    K_p = 2 * np.pi * velocity_hz * m
    velocity = Pi(K_p, K_p * 2 * np.pi * integral_hz)
    return Cascade(2 * np.pi * position_hz, velocity)


def notch_of(f_hz: FloatArray, G: ComplexArray, zeta_p: float = 0.7) -> Notch:
    """Return the notch for the sharpest resonance of a response G (n,) at f_hz (n,).

    That is the largest peak above what is around it, an octave to either side; its
    damping is half its width where it is 3 dB lower, over its frequency.

    Raises:
        ValueError: there is no peak, or the lines are too few to see its width.
    """
    f_hz, size = np.asarray(f_hz, dtype=float), np.log(np.abs(G))
    inner = np.arange(1, len(size) - 1)
    peaks = inner[(size[inner] > size[inner - 1]) & (size[inner] >= size[inner + 1])]
    if not len(peaks):
        raise ValueError("the response has no peak, so there is nothing to notch")
    heights = [size[i] - np.median(size[_octave(f_hz, i)]) for i in peaks]
    i = int(peaks[int(np.argmax(heights))])
    low, high = _falls(f_hz, size, i, -1), _falls(f_hz, size, i, 1)
    return Notch(float(f_hz[i]), float((high - low) / (2 * f_hz[i])), zeta_p)


def _octave(f_hz: FloatArray, i: int) -> FloatArray:
    return np.asarray((f_hz > f_hz[i] / 2) & (f_hz < f_hz[i] * 2))


def _falls(f_hz: FloatArray, size: FloatArray, i: int, way: int) -> float:
    """Return the frequency at which a peak has fallen by 3 dB, one way."""
    wanted = size[i] - np.log(2) / 2
    j = i
    while size[j] > wanted:
        j += way
        if not 0 <= j < len(size):
            raise ValueError(
                f"the peak at {f_hz[i]:.4g} Hz is not 3 dB above its surroundings"
            )
    share = (size[j - way] - wanted) / (size[j - way] - size[j])
    return float(f_hz[j - way] + share * (f_hz[j] - f_hz[j - way]))


def _refuse_not_positive(**values: float) -> None:
    for name, value in values.items():
        if not value > 0:
            raise ValueError(f"{name} = {value:g} is not greater than 0")
