"""Curves of the ball-screw study's frequency-domain figures, as arrays over f_hz.

Loops and parameters by name as in ``controllers.synthesis.ball_screw.loops``.
Source: Gordon 2010, figures 3.4, 3.6 and 3.10 to 3.13.
"""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from controllers.synthesis.ball_screw.loops import continuous_loop, sampled_loop
from controllers.synthesis.ball_screw.pole_placement import augmented
from controllers.synthesis.frequency import evaluate, respond
from controllers.synthesis.parameters import share
from controllers.synthesis.pole_placement import closed_loop_poles
from plants.ball_screw import two_mass as ball_screw

Curves: TypeAlias = dict[str, NDArray[Any]]


def loop(
    controller: str,
    domain: str = "z",
    current: bool = True,
    latency: int = 1,
    lowest_hz: float = 1.0,
    highest_hz: float = 1000.0,
    **parameters: float,
) -> Curves:
    """Return f_hz (n,) and complex L, S, disturbance (rad/V) and tracking.

    Args:
        controller: ``mc_ppc`` or ``p_pi``.
        domain: ``s``, or ``z`` with sampling and ``latency`` samples of delay.
        current: the current loop is there.
        lowest_hz, highest_hz: ends of the frequencies (Hz).
        parameters: by name, see ``controllers.synthesis.ball_screw.loops``.

    Raises:
        LookupError: no such controller, domain or parameter.
    """
    if domain == "s":
        found = continuous_loop(controller, current, parameters)
    elif domain == "z":
        found = sampled_loop(controller, current, parameters, latency)
    else:
        raise LookupError(f"no domain {domain!r}: z or s")
    response = respond(found, np.geomspace(lowest_hz, highest_hz, 3000))
    return {
        "f_hz": response.f_hz,
        "L": response.L,
        "S": 1 / (1 + response.L),
        "disturbance": response.disturbance,
        "tracking": response.tracking,
    }


def drive(current: bool = False, **parameters: float) -> Curves:
    """Return f_hz and the accelerations of screw and table, rad/(V s²), complex.

    ``u_1``, ``u_2`` from the control signal, ``d_1``, ``d_2`` from a force on the
    table.  With ``current`` the current loop stands before the drive.
    """
    plant = continuous_loop("mc_ppc", current, parameters).plant
    f_hz = np.geomspace(10.0, 1000.0, 2000)
    s = np.asarray(2j * np.pi * f_hz, dtype=np.complex128)
    # outputs are both speeds, then both positions
    a = evaluate(plant, s)[:, :2] * s[:, None, None]
    return {
        "f_hz": f_hz,
        "u_1": a[:, 0, 0],
        "u_2": a[:, 1, 0],
        "d_1": a[:, 0, 1],
        "d_2": a[:, 1, 1],
    }


def poles(beta: float = 4.0, **parameters: float) -> Curves:
    """Return real and imaginary parts (1/s) of the poles, opened and as placed.

    Keys ``open_real``, ``open_imag``, ``closed_real``, ``closed_imag``, (5,) each;
    ``beta`` is the factor on the decay of the axial pair (eq. 3.7).
    """
    (p,) = share(parameters, {"plant": ball_screw.model.parameters})
    A, _ = augmented(p.m_1, p.m_2, p.b_1, p.b_2, p.k, p.c)
    opened = np.linalg.eigvals(A).astype(complex)
    closed = np.asarray(closed_loop_poles(opened, beta, 50.0, 0.7))
    return {
        "open_real": opened.real,
        "open_imag": opened.imag,
        "closed_real": closed.real,
        "closed_imag": closed.imag,
    }
