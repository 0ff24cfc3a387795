"""Loops of the gantry study, and every frequency-domain figure read off them.

    z-domain    exact zero-order hold of the traced plant, the traced run-time
                controller, ``latency`` samples of delay
    s-domain    transfer functions of the source, no delay

Parameters are given by name: ``m_x`` goes to plant and controller alike, ``plant.c``
or ``controller.filters.omega_lpf_hz`` to one of them.  Plants are the drives of
``plants.gantry.x_drive`` and ``plants.gantry.drive``: what is switched off is
not there.  Frequencies in Hz, phases in degrees, as published.
Source: Gordon 2010, chapter 4.
"""

from collections.abc import Mapping
from typing import Any

import control as ct
import numpy as np
from scipy import optimize

from controllers.gantry import mimo as gantry_mimo
from controllers.gantry import pid as gantry_pid
from controllers.gantry import x as gantry_x
from controllers.synthesis import multivariable as mv
from controllers.synthesis.frequency import ComplexArray, Loop, battery, evaluate
from controllers.synthesis.frequency import poles as loop_poles
from controllers.synthesis.frequency import respond as loop_respond
from controllers.synthesis.gantry.continuous import mimo_law, pid_law, y_filters
from controllers.synthesis.gantry.design import averaging
from controllers.synthesis.linearise import linearise, without_bystanders
from controllers.synthesis.parameters import share, with_values
from fmus.model import FloatArray, Model, Record
from plants.gantry import drive as gantry_drive
from plants.gantry import frame as gantry
from plants.gantry import x_drive as linear_motor_drive

CONTROLLERS: dict[str, tuple[Model, Any]] = {
    "mimo": (gantry_mimo.model, mimo_law),
    "pid": (gantry_pid.model, pid_law),
}
# where the yaw mode is looked for, opened and closed
YAW_HZ = (75.0, 140.0)
# what lies below is the rigid motion and the machine's base
LOW_HZ = 60.0


def plant_figures(x: float = 0.0, **parameters: float) -> dict[str, float]:
    """Return yaw_frequency (Hz), yaw_damping, and yaw_shift (%) against x = 0.

    Args:
        x: table position (m).
        parameters: of ``plants.gantry.frame`` by name.
    """
    (p,) = share(parameters, {"plant": gantry.model.parameters})

    def yaw(at: float) -> complex:
        poles = linearise(gantry.model, parameters=p, input=gantry.Input(x=at)).poles()
        return complex(poles[np.argmax(poles.imag)])

    here, middle = yaw(x), yaw(0.0)
    now = gantry.geometry(x, p)
    return {
        "yaw_frequency": abs(here) / (2 * np.pi),
        "yaw_damping": -here.real / abs(here),
        "yaw_shift": 100 * (abs(here) / abs(middle) - 1),
        "alpha_1": float(now.a_2 / p.L),
        "alpha_2": float(now.a_1 / p.L),
    }


def x_figures(
    lag: bool = True, latency: int = 1, T_s: float = 1 / 15_000, **parameters: float
) -> dict[str, float]:
    """Return the figures of the x loop, z-domain.

    ``crossover``, ``phase_margin``, ``s_max``, ``s_max_frequency``, ``active_to``
    (|S| < 1 up to), ``radius`` (largest eigenvalue).

    Args:
        lag: the drive lags (``plants.gantry.x_drive``).
        latency, T_s: delay in whole samples, sample time (s).
        parameters: by name, see the module.
    """
    loop = x_loop(lag, latency, T_s, parameters)
    found = battery(loop_respond(loop))
    falling = np.flatnonzero(found.falling)[-1]
    return {
        "crossover": float(found.crossovers_hz[falling]),
        "phase_margin": float(np.rad2deg(found.phase_margins[falling])),
        "s_max": found.s_max,
        "s_max_frequency": found.s_max_hz,
        "active_to": float(found.bands_hz[0, 1]),
        "radius": float(np.max(np.abs(loop_poles(loop)))),
    }


def x_loop(
    lag: bool, latency: int, T_s: float, parameters: Mapping[str, float]
) -> Loop:
    """Return the z-domain loop of the x axis; arguments as for ``x_figures``."""
    records = {
        "plant": linear_motor_drive.model.parameters,
        "controller": gantry_x.model.parameters,
    }
    drive, p = share(parameters, records)
    drive = with_values(drive, {"amplifier.on": lag})
    plant = linearise(
        linear_motor_drive.model, parameters=drive, inputs=["u", "d"], outputs=["x"]
    )
    names = ["x_m", "x_r", "a_xr"]
    law = linearise(gantry_x.model, parameters=p, inputs=names, outputs=["u"], T_s=T_s)
    return Loop(without_bystanders(plant).sample(T_s, "zoh"), law, latency)


def figures(
    controller: str,
    domain: str = "z",
    x: float = 0.0,
    latency: int = 1,
    T_s: float = 1 / 15_000,
    **parameters: float,
) -> dict[str, float]:
    """Return the figures of the gantry's loop with one controller.

        crossover_1, ...                  upper singular value of L passes 1
        s_max, s_max_frequency            largest upper singular value of S
        s_low, s_low_frequency            the same below 60 Hz
        active_to                         of S below 1 up to
        rejection_1_from, ..._to, ...     of S G below that of G
        yaw_attenuation, yaw_frequency    peak of G over that of S G, and where
        radius                            largest eigenvalue (z-domain)
        turns                             clockwise turns of det(I + L) (z-domain)

    Args:
        controller: ``mimo`` or ``pid``.
        domain: ``z``, or ``s`` without sampling and delay.
        x: table position for plant and schedule (m).
        latency, T_s: delay in whole samples, sample time (s).
        parameters: by name, see the module.

    Raises:
        LookupError: no such controller, domain or parameter.
    """
    if domain == "z":
        loop = sampled_loop(controller, x, parameters, latency, T_s)
        found = named(mv.respond(loop))
        eigenvalues = mv.poles(loop)
        found["radius"] = float(np.max(np.abs(eigenvalues)))
        found["turns"] = float(mv.clockwise_turns(loop))
        return found | _fastest_growing(eigenvalues, T_s)
    if domain != "s":
        raise LookupError(f"no domain {domain!r}: z or s")
    return named(continuous_response(controller, x, parameters))


def _fastest_growing(z: ComplexArray, T_s: float) -> dict[str, float]:
    """Return frequency, damping and time constant of a growing pair, if any."""
    s = np.log(z[np.argmax(np.abs(z))]) / T_s
    if s.real <= 0 or s.imag == 0:
        return {}
    return {
        "growing_frequency": float(abs(s) / (2 * np.pi)),
        "growing_damping": float(-s.real / abs(s)),
        "growth_time": float(1 / s.real),
    }


def lagging_figures(
    omega_l_hz: float = 221.28, **parameters: float
) -> dict[str, float]:
    """Return the figures of the averaged loop whose drives lag, D designed for it.

    Args:
        omega_l_hz: bandwidth of both drives (Hz).
        parameters: by name, see the module; ``k_i`` for instance.
    """
    return figures("mimo", **(lagging(omega_l_hz) | parameters))  # type: ignore[arg-type]


def lagging(omega_l_hz: float) -> dict[str, float]:
    """Return the parameters of drives that lag and of D designed for them."""
    (p,) = share({}, {"plant": gantry.model.parameters})
    gains = averaging(p.m, p.m_x, p.L, p.J_0, p.d, p.c, p.k, omega_l_hz=omega_l_hz)
    lag = {"plant.amplifier.on": True, "plant.amplifier.omega_l_hz": omega_l_hz}
    return gains | lag


def averaged_figures(latency: int = 1, T_s: float = 1 / 15_000) -> dict[str, float]:
    """Return crossover (Hz) and phase_margin (deg) of h D/(m s²) with its delay.

    Args:
        latency, T_s: delay in whole samples besides the hold, sample time (s).
    """
    p = gantry_mimo.Parameters()
    f_hz = np.geomspace(20.0, 150.0, 4001)
    s = np.asarray(2j * np.pi * f_hz, dtype=np.complex128)
    D = p.K * (p.T_d * s + 1) / (s / p.a + 1)
    L = y_filters(p.filters, s) * D / (p.m * s * s) * np.exp(-s * (0.5 + latency) * T_s)
    (crossover,) = mv.crossings(f_hz, np.abs(L))
    phase = np.interp(crossover, f_hz, np.unwrap(np.angle(L)))
    margin = np.mod(np.rad2deg(phase), 360.0) - 180.0
    return {"crossover": float(crossover), "phase_margin": float(margin)}


def integral_limit(
    latency: int = 1, T_s: float = 1 / 15_000, **parameters: float
) -> float:
    """Return the k_i (V/(m s)) at which the averaged loop's yaw mode turns unstable.

    Args:
        latency, T_s: delay in whole samples, sample time (s).
        parameters: by name; ``beta = 0`` asks for the limit without damping.
    """

    def excess(k_i: float) -> float:
        loop = sampled_loop("mimo", 0.0, parameters | {"k_i": k_i}, latency, T_s)
        z = mv.poles(loop)
        f_hz = np.abs(np.angle(z)) / (2 * np.pi * T_s)
        return float(np.max(np.abs(z[(f_hz > 60) & (f_hz < 200)])) - 1)

    return float(optimize.brentq(excess, 1e6, 1e8, xtol=1.0))


def sampled_loop(
    controller: str,
    x: float,
    parameters: Mapping[str, float],
    latency: int = 1,
    T_s: float = 1 / 15_000,
) -> Loop:
    """Return the z-domain loop (u_1, u_2) → (y_1, y_2) with the table at x (m)."""
    plant, p = _parts(controller, x, parameters)
    model, _ = CONTROLLERS[controller]
    law = linearise(
        model,
        parameters=p,
        input=model.input._replace(x_s=x),
        inputs=["y_1m", "y_2m"],
        outputs=["u_1", "u_2"],
        T_s=T_s,
    )
    return Loop(plant.sample(T_s, "zoh"), without_bystanders(law), latency)


def continuous_response(
    controller: str,
    x: float,
    parameters: Mapping[str, float],
    f_hz: FloatArray = mv.GRID_HZ,
) -> mv.MultiResponse:
    """Return G and K of the source in the s-domain, without delay."""
    plant, p = _parts(controller, x, parameters)
    s = np.asarray(2j * np.pi * f_hz, dtype=np.complex128)
    return mv.MultiResponse(
        f_hz, evaluate(plant, s), CONTROLLERS[controller][1](p, x, s)
    )


def _parts(
    controller: str, x: float, parameters: Mapping[str, float]
) -> tuple[ct.StateSpace, Record]:
    """Return the plant (u_1, u_2) → (y_1, y_2) and the controller's parameters."""
    if controller not in CONTROLLERS:
        raise LookupError(f"no controller {controller!r}, there are mimo and pid")
    records = {
        "plant": gantry_drive.model.parameters,
        "controller": CONTROLLERS[controller][0].parameters,
    }
    drive, p = share(parameters, records)
    plant = linearise(
        gantry_drive.model,
        parameters=drive,
        input=gantry.Input(x=x),
        inputs=["u_1", "u_2"],
        outputs=["y_1", "y_2"],
    )
    return without_bystanders(plant), p


def named(response: mv.MultiResponse) -> dict[str, float]:
    """Read the figures of a loop, by name (see ``figures``)."""
    f_hz = response.f_hz
    L, S = mv.upper(response.L), response.S
    closed, opened = mv.upper(S @ response.G), mv.upper(response.G)
    sensitivity = mv.upper(S)
    worst = int(np.argmax(sensitivity))
    rigid = int(np.argmax(sensitivity[f_hz < LOW_HZ]))
    at_yaw = (f_hz >= YAW_HZ[0]) & (f_hz <= YAW_HZ[1])
    peak = int(np.argmax(closed[at_yaw]))
    found = {f"crossover_{i}": float(f) for i, f in enumerate(mv.crossings(f_hz, L), 1)}
    for i, (low, high) in enumerate(mv.bands_below(f_hz, closed / opened), 1):
        found |= {f"rejection_{i}_from": float(low), f"rejection_{i}_to": float(high)}
    active = mv.bands_below(f_hz, sensitivity)
    return found | {
        "s_max": float(sensitivity[worst]),
        "s_max_frequency": float(f_hz[worst]),
        "s_low": float(sensitivity[rigid]),
        "s_low_frequency": float(f_hz[rigid]),
        "active_to": float(active[0, 1]) if len(active) else 0.0,
        "yaw_attenuation": float(np.max(opened[at_yaw]) / closed[at_yaw][peak]),
        "yaw_frequency": float(f_hz[at_yaw][peak]),
    }
