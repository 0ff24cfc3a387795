"""Curves of the gantry study's frequency-domain figures, as arrays over f_hz.

Loops and parameters by name as in ``controllers.synthesis.gantry.loops``.
Source: Gordon 2010, figures 4.3, 4.5 to 4.9 and 4.11 to 4.15.
"""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from controllers.synthesis import multivariable as mv
from controllers.synthesis.frequency import ComplexArray, evaluate
from controllers.synthesis.frequency import respond as loop_respond
from controllers.synthesis.gantry.loops import (
    continuous_response,
    lagging,
    sampled_loop,
    x_loop,
)
from controllers.synthesis.linearise import linearise, without_bystanders
from controllers.synthesis.parameters import share, with_values
from plants.gantry import drive as gantry_drive
from plants.gantry import frame as gantry
from plants.gantry import x_drive as linear_motor_drive

Curves: TypeAlias = dict[str, NDArray[Any]]
F_HZ = np.geomspace(1.0, 1000.0, 3000)


def loop(
    controller: str,
    domain: str = "z",
    x: float = 0.0,
    omega_l_hz: float | None = None,
    **parameters: float,
) -> Curves:
    """Return f_hz (n,) and singular values of the gantry's loop with a controller.

    ``L_upper``, ``L_lower``, the same of S, G (m/V) and SG (m/V), and the complex
    ``nyquist``, det(I + L) - 1, which turns about -1 where the loop is unstable.

    Args:
        controller: ``mimo`` or ``pid``.
        domain: ``z`` with one sample of delay, or ``s`` without.
        x: table position (m).
        omega_l_hz: bandwidth of the drives (Hz), D designed for it; None: no lag.
        parameters: by name, see ``controllers.synthesis.gantry.loops``.

    Raises:
        LookupError: no such controller, domain or parameter.
    """
    if omega_l_hz is not None:
        parameters = lagging(omega_l_hz) | parameters
    if domain == "z":
        found = mv.respond(sampled_loop(controller, x, parameters), F_HZ)
    elif domain == "s":
        found = continuous_response(controller, x, parameters, F_HZ)
    else:
        raise LookupError(f"no domain {domain!r}: z or s")
    L, S = found.L, found.S
    curves: Curves = {"f_hz": F_HZ}
    for name, M in (("L", L), ("S", S), ("G", found.G), ("SG", S @ found.G)):
        values = np.linalg.svd(M, compute_uv=False)
        curves |= {f"{name}_upper": values[:, 0], f"{name}_lower": values[:, -1]}
    return curves | {"nyquist": np.linalg.det(np.eye(2) + L) - 1}


def x_axis(lag: bool = True, **parameters: float) -> Curves:
    """Return f_hz and complex L, S of the x loop and the plant's ``acceleration``.

    The latter is m/(V s²), of the drive as it is in the loop, lagging or not.
    """
    found = loop_respond(x_loop(lag, 1, 1 / 15_000, parameters), F_HZ)
    drive = with_values(linear_motor_drive.model.parameters, {"amplifier.on": lag})
    plant = linearise(
        linear_motor_drive.model, parameters=drive, inputs=["u"], outputs=["x"]
    )
    s = np.asarray(2j * np.pi * F_HZ, dtype=np.complex128)
    a = s * s * evaluate(without_bystanders(plant), s)[:, 0, 0]
    return {"f_hz": F_HZ, "L": found.L, "S": 1 / (1 + found.L), "acceleration": a}


def frame(x: float = 0.0, **parameters: float) -> Curves:
    """Return f_hz and the gantry's FRFs from either motor to either encoder.

    ``y_11`` (from motor 1 to encoder 1), ``y_12`` ... are positions (m/V), ``a_11``
    ... accelerations (m/(V s²)), complex.

    Args:
        x: table position (m).
        parameters: of ``plants.gantry.drive`` by name, ``plant.beam.on`` say.
    """
    G, s = _plant(x, parameters)
    curves: Curves = {"f_hz": F_HZ}
    for i, j in np.ndindex(2, 2):
        curves[f"y_{i + 1}{j + 1}"] = G[:, i, j]
        curves[f"a_{i + 1}{j + 1}"] = s * s * G[:, i, j]
    return curves


def hammer(at: float, x: float = 0.0, **parameters: float) -> Curves:
    """Return f_hz and the acceleration of encoder 1 (m/(V s²)), complex, ``a_1``.

    The frame is struck at the share ``at`` of its span, 0 at motor 1, 1 at motor 2: a
    force there is one at either end, by the lever.
    """
    G, s = _plant(x, parameters)
    struck = (1 - at) * G[:, 0, 0] + at * G[:, 0, 1]
    return {"f_hz": F_HZ, "a_1": s * s * struck}


def distribution(**parameters: float) -> Curves:
    """Return table positions ``x`` (m) and the shares of the mass at either end."""
    (p,) = share(parameters, {"plant": gantry.model.parameters})
    x = np.linspace(-0.15, 0.15, 61)
    shapes = [gantry.geometry(float(one), p) for one in x]
    return {
        "x": x,
        "alpha_1": np.array([now.a_2 / p.L for now in shapes], dtype=float),
        "alpha_2": np.array([now.a_1 / p.L for now in shapes], dtype=float),
    }


def _plant(x: float, parameters: dict[str, float]) -> tuple[ComplexArray, ComplexArray]:
    (drive,) = share(parameters, {"plant": gantry_drive.model.parameters})
    plant = linearise(
        gantry_drive.model,
        parameters=drive,
        input=gantry.Input(x=x),
        inputs=["u_1", "u_2"],
        outputs=["y_1", "y_2"],
    )
    s = np.asarray(2j * np.pi * F_HZ, dtype=np.complex128)
    return evaluate(without_bystanders(plant), s), s
