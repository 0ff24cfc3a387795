"""Linear stability of the sampled NCTF loop near the origin, one delay included.

    G_obj(z) = β K/α (z + b) / ((z - 1)(z - E)),   E = exp(-αT),
    β = αT - 1 + E,   b = (1 - E - αT E) / β

A hold, the object K α/(s (s + α)), the line v = α e, the rate (x_k - x_{k-1})/T and
the PI compensator give X/X_r; its poles depend on αT, ω_n T and ζ alone.

Source: Maeda 2007, eq. 3-12 to 3-14; eq. 3-12 prints (z + 1) for (z - 1).
"""

import numpy as np
from scipy.optimize import bisect

from controllers.synthesis.jury import is_stable
from fmus.model import FloatArray

HIGHEST = 1e3  # of ζ: where the search gives up


def closed_loop(
    alpha_T: float,
    omega_n_T: float,
    zeta: float,
    alpha_obj_T: float | None = None,
    integral: bool = True,
) -> FloatArray:
    """Return the denominator of X/X_r (eq. 3-13), highest power first, shape (6,).

    Args:
        alpha_T: inclination of the trajectory times sample time.
        omega_n_T, zeta: design parameters ω_n T (rad) and ζ.
        alpha_obj_T: damping of the object times sample time, where it is not the
            inclination (fig. 7-1).
        integral: the compensator integrates; without it the pole of the integrator
            stays at z = 1 (fig. 3-5b).
    """
    a = alpha_T if alpha_obj_T is None else alpha_obj_T
    E = np.exp(-a)
    beta = a + np.expm1(-a)
    b = (-np.expm1(-a) - a * E) / beta
    both = 2 * zeta + (omega_n_T if integral else 0.0)
    mu_1 = omega_n_T * both
    mu_2 = omega_n_T * (both * b - 2 * zeta)
    mu_3 = -2 * zeta * omega_n_T * b
    return np.array(
        [
            a**2,
            -(a**2) * (2 + E),
            (alpha_T + 1) * beta * mu_1 + a**2 * (1 + 2 * E),
            -beta * mu_1 + (alpha_T + 1) * beta * mu_2 - a**2 * E,
            -beta * mu_2 + (alpha_T + 1) * beta * mu_3,
            -beta * mu_3,
        ]
    )


def linear_limit(
    omega_n_T: float, alpha_T: float = 505 * 2e-4, alpha_obj_T: float | None = None
) -> float:
    """Return the largest ζ with a stable loop, by Jury's test; 0 where none is.

    Args:
        omega_n_T: ω_n T (rad).
        alpha_T, alpha_obj_T: as for ``closed_loop``.

    Raises:
        ValueError: the loop is stable up to ζ = 1000.
    """

    def stable(zeta: float) -> bool:
        return is_stable(closed_loop(alpha_T, omega_n_T, zeta, alpha_obj_T))

    zetas = np.geomspace(1e-2, HIGHEST, 400)
    found = np.flatnonzero([stable(zeta) for zeta in zetas])
    if not len(found):
        return 0.0
    last = found[-1]
    if last == len(zetas) - 1:
        raise ValueError(f"stable up to ζ = {HIGHEST:g}")
    bracket = (zetas[last], zetas[last + 1])
    return float(bisect(lambda zeta: 1 if stable(zeta) else -1, *bracket))


def practical_limit(
    K_pu: float,
    omega_n_T: float,
    alpha: float = 505.0,
    K: float = 32.3,
    T: float = 2e-4,
) -> float:
    """Return ζ_prac (eq. 3-14) of an ultimate proportional gain.

    Args:
        K_pu: ultimate proportional gain (A s/mm).
        omega_n_T: ω_n T (rad).
        alpha, K: simplified object (1/s, mm/(A s)).
        T: sample time (s).
    """
    return K_pu * alpha * K * T / (2 * omega_n_T)
