"""Rigid body and Coulomb friction of the drive from jogs, by unbiased least squares.

With the command held over a sample and the speed's sign kept, exactly

    ω[k+1] = a ω[k] + b τ[k] - c₊ s₊[k] - c₋ s₋[k]
    B_e = (1 - a)/b,   J_e = -T_s B_e/ln a,   T± = c±/b

s± tell the sign of ω, τ = k_t k_a v_m.  Left out, the two columns of friction bias J_e
by a tenth.  Samples near rest or about a reversal do not count.

Source: Hanifzadegan 2014, sec. 3.4.1, eq. 3.22 (repaired), 3.23, after Erkorkmaz and
Altintas 2001.
"""

import numpy as np

from fmus.model import FloatArray
from plants.ball_screw_lpv._drive import Amplifier
from plants.ball_screw_lpv._mode import R_G


def rigid_body(
    T_s: float,
    v_m: FloatArray,
    v: FloatArray,
    slowest: float = 0.02,
    friction: bool = True,
    r_g: float = R_G,
    k_t: float = Amplifier().k_t,
    k_a: float = Amplifier().k_a,
) -> dict[str, float]:
    """Return J_e, B_e, T_plus and T_minus that explain a jog.

    Args:
        T_s: sample time (s).
        v_m: command held from each sample on, shape (n,) (V).
        v: table speed at each sample, shape (n,) (m/s).
        slowest: speed (m/s) below which a sample does not count.
        friction: False leaves the friction out, what biases the rest.
        r_g, k_t, k_a: travel per angle, torque constant, current per command.

    Raises:
        ValueError: too few samples move in either direction, or no inertia fits.
    """
    omega, tau = np.asarray(v) / r_g, k_t * k_a * np.asarray(v_m)
    before, after = omega[:-1], omega[1:]
    moving = np.minimum(np.abs(before), np.abs(after)) > slowest / r_g
    counts = moving & (np.sign(before) == np.sign(after))
    forward, backward = (before > 0)[counts], (before < 0)[counts]
    if min(np.count_nonzero(forward), np.count_nonzero(backward)) < 10:
        raise ValueError("the jog moves too little in one of the directions")
    columns = [before[counts], tau[:-1][counts]]
    if friction:
        columns += [-1.0 * forward, -1.0 * backward]
    A = np.column_stack(columns)
    scale = np.linalg.norm(A, axis=0)
    found = np.linalg.lstsq(A / scale, after[counts], rcond=None)[0] / scale
    a, b = found[:2]
    if not (0 < a < 1 and b > 0):
        raise ValueError("no rigid body with friction explains the jog")
    B_e = (1 - a) / b
    plus, minus = found[2:] / b if friction else (0.0, 0.0)
    return {
        "rigid.J_e": float(-T_s * B_e / np.log(a)),
        "rigid.B_e": float(B_e),
        "friction.T_plus": float(plus),
        "friction.T_minus": float(minus),
    }
