"""Loops of the ball-screw study, and every frequency-domain figure read off them.

    s-domain    traced plant, continuous form of the controller (eq. 3.5 to 3.10;
                of the cascade eq. 3.27)
    z-domain    exact zero-order hold of the traced plant, the traced run-time
                controller, ``latency`` samples of delay

each with the ideal two-mass drive and with the 450 Hz current loop before it; and
with the drive as it was measured (``plants.ball_screw.measured``).

Parameters are given by name: ``m_2`` goes to plant and controller alike,
``plant.m_2`` or ``controller.filters.omega_lpf_hz`` to one of them.
Figures bear the names of the study's figures: frequencies in Hz, phase margins
and phases in degrees as published, everything else in SI.
Source: Gordon 2010, sections 3.2 and 3.3.
"""

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import control as ct
import numpy as np

from controllers.ball_screw import mc_ppc, p_pi
from controllers.synthesis.ball_screw.continuous import mc_ppc_law, p_pi_law
from controllers.synthesis.frequency import Battery, Loop, battery, poles, respond
from controllers.synthesis.linearise import linearise, without_bystanders
from controllers.synthesis.parameters import share, with_values
from fmus.model import Model, Record
from plants.ball_screw import drive as ball_screw_drive
from plants.ball_screw import measured as ball_screw_measured
from plants.ball_screw import two_mass as ball_screw

Law: TypeAlias = Callable[[Any], ct.StateSpace]

CONTROLLERS: dict[str, tuple[Model, Law]] = {
    "mc_ppc": (mc_ppc.model, mc_ppc_law),
    "p_pi": (p_pi.model, p_pi_law),
}
COMMANDS = ("x_r", "v_r", "a_r", "j_r", "s_r")


def plant_figures(**parameters: float) -> dict[str, float]:
    """Return axial_frequency (Hz), axial_damping and real_pole (Hz) of the drive."""
    (drive,) = share(parameters, {"plant": ball_screw.model.parameters})
    plant = linearise(ball_screw.model, parameters=drive)
    eigenvalues = plant.poles()
    axial = eigenvalues[np.argmax(eigenvalues.imag)]
    # one pole stands at the origin, the next is viscous friction against inertia
    real = np.sort(np.abs(eigenvalues[eigenvalues.imag == 0]))[1]
    return {
        "axial_frequency": float(np.abs(axial) / (2 * np.pi)),
        "axial_damping": float(-axial.real / np.abs(axial)),
        "real_pole": float(real / (2 * np.pi)),
    }


def figures(
    controller: str, latency: int = 1, T_s: float = 5e-5, **parameters: float
) -> dict[str, float]:
    """Return the frequency-domain battery of one controller in all four cases.

    Without suffix: s-domain, ideal drive; ``_z``, ``_current``, ``_z_current`` as
    they say; the latter two carry the current loop.  Per case:

        crossover_1, ...         where |L| falls through 1 (Hz)
        rise_1, ...              where it rises through 1 (Hz)
        phase_margin_1, ...      at each crossing of either kind (degrees)
        phase_margin_min         the one of smallest magnitude (degrees)
        phase_crossover_1, ...   where L crosses the negative real axis (Hz)
        gain_margin_1, ...       1/|L| there (ratio)
        s_max, s_max_frequency   max |S| and where (Hz)
        band_1_from, band_1_to   where |S| < 1 (Hz), band after band
        real_min                 most negative real part of d_2 -> x_2 (rad/V)
        real_min_frequency       where (Hz)
        magnitude_max            largest magnitude of d_2 -> x_2 (rad/V)
        magnitude_max_frequency  where (Hz)

    and per drive, without ``_z``, ``decay``: the largest real part of an eigenvalue in
    s (1/s), and ``radius``: the largest magnitude of an eigenvalue in z.

    Args:
        controller: ``mc_ppc`` or ``p_pi``.
        latency: delay of the control signal in whole samples (z-domain).
        T_s: sample time (s).
        parameters: by name, see the module.

    Raises:
        LookupError: no controller of that name, or no such parameter.
    """
    found: dict[str, float] = {}
    for current, ending in ((False, ""), (True, "_current")):
        continuous = continuous_loop(controller, current, parameters)
        sampled = sampled_loop(controller, current, parameters, latency, T_s)
        for loop, domain in ((continuous, ""), (sampled, "_z")):
            case = _named(battery(respond(loop)))
            found |= {f"{key}{domain}{ending}": value for key, value in case.items()}
        found[f"decay{ending}"] = float(np.max(poles(continuous).real))
        found[f"radius{ending}"] = float(np.max(np.abs(poles(sampled))))
    return found


def measured_figures(
    controller: str, latency: int = 1, T_s: float = 5e-5, **parameters: float
) -> dict[str, float]:
    """Return the battery with the drive as measured: names as of ``figures``.

    Without suffix in s, ``_z`` sampled; ``decay`` and ``radius``.

    Args:
        controller, latency, T_s, parameters: as of ``measured_loops``.

    Raises:
        LookupError: no controller of that name, or no such parameter.
    """
    continuous, sampled = measured_loops(controller, latency, T_s, **parameters)
    found = _named(battery(respond(continuous)))
    in_z = _named(battery(respond(sampled)))
    found |= {f"{key}_z": value for key, value in in_z.items()}
    found["decay"] = float(np.max(poles(continuous).real))
    found["radius"] = float(np.max(np.abs(poles(sampled))))
    return found


def measured_loops(
    controller: str, latency: int = 1, T_s: float = 5e-5, **parameters: float
) -> tuple[Loop, Loop]:
    """Return the loops in s and in z with ``plants.ball_screw.measured``.

    Its current loop is on; ``second_order.on``, ``torsion.on`` and what belongs to
    them are parameters of the plant.

    Args:
        controller, latency, T_s, parameters: as in ``figures``.

    Raises:
        LookupError: no controller of that name, or no such parameter.
    """
    model, law = _controller(controller)
    record = with_values(ball_screw_measured.model.parameters, {"current_loop.on": 1})
    records = {"plant": record, "controller": model.parameters}
    drive, p = share(parameters, records)
    plant = _linear(ball_screw_measured.model, drive)
    sampled = Loop(_held(plant, T_s), _sampled(model, p, T_s), latency)
    return Loop(plant, law(p)), sampled


def tracking(
    controller: str,
    f_hz: float,
    latency: int = 1,
    T_s: float = 5e-5,
    **parameters: float,
) -> dict[str, float]:
    """Return x_r -> x_2 of the sampled loop at one frequency, ideal drive.

    Args:
        f_hz: frequency (Hz).
        controller, latency, T_s, parameters: as in ``figures``.

    Returns:
        ``magnitude`` (ratio), ``phase`` (degrees), and real and imaginary part of
        the tracking error per unit command, ``error_real`` and ``error_imag``.
    """
    loop = sampled_loop(controller, False, parameters, latency, T_s)
    response = respond(loop, np.array([float(f_hz)])).tracking[0]
    return {
        "magnitude": float(np.abs(response)),
        "phase": float(np.angle(response, deg=True)),
        "error_real": float(1 - response.real),
        "error_imag": float(-response.imag),
    }


def continuous_loop(
    controller: str, current: bool, parameters: Mapping[str, float]
) -> Loop:
    """Return the s-domain loop; its plant shows both speeds and both positions."""
    _, law = _controller(controller)
    plant, p = _parts(controller, current, parameters)
    return Loop(plant, law(p))


def sampled_loop(
    controller: str,
    current: bool,
    parameters: Mapping[str, float],
    latency: int = 1,
    T_s: float = 5e-5,
) -> Loop:
    """Return the z-domain loop with the run-time controller and its commands."""
    model, _ = _controller(controller)
    plant, p = _parts(controller, current, parameters)
    return Loop(_held(plant, T_s), _sampled(model, p, T_s), latency)


def _held(plant: ct.StateSpace, T_s: float) -> ct.StateSpace:
    return plant[["x_1", "x_2"], :].sample(T_s, "zoh")


def _sampled(model: Model, p: Record, T_s: float) -> ct.StateSpace:
    inputs = ["y_1", "y_2", *COMMANDS]
    return linearise(model, parameters=p, inputs=inputs, outputs=["u"], T_s=T_s)


def _controller(name: str) -> tuple[Model, Law]:
    if name not in CONTROLLERS:
        raise LookupError(f"no controller {name!r}, there are {', '.join(CONTROLLERS)}")
    return CONTROLLERS[name]


def _parts(
    controller: str, current: bool, parameters: Mapping[str, float]
) -> tuple[ct.StateSpace, Record]:
    """Return the plant (u, d_2) -> (v_1, v_2, x_1, x_2) and the law's parameters."""
    model = ball_screw_drive.model if current else ball_screw.model
    records = {
        "plant": model.parameters,
        "controller": _controller(controller)[0].parameters,
    }
    drive, p = share(parameters, records)
    if current:
        drive = with_values(drive, {"current_loop.on": True})
    return _linear(model, drive), p


def _linear(model: Model, drive: Record) -> ct.StateSpace:
    outputs = ["v_1", "v_2", "x_1", "x_2"]
    plant = linearise(model, parameters=drive, inputs=["u", "d_2"], outputs=outputs)
    # parts of the drive that are switched off would show among the eigenvalues
    return without_bystanders(plant)


def _named(found: Battery) -> dict[str, float]:
    """Spread a battery's arrays over numbered names."""
    numbered = {
        "crossover": found.crossovers_hz[found.falling],
        "rise": found.crossovers_hz[~found.falling],
        "phase_margin": np.rad2deg(found.phase_margins),
        "phase_crossover": found.phase_crossovers_hz,
        "gain_margin": found.gain_margins,
    }
    named = {
        f"{name}_{i}": float(value)
        for name, values in numbered.items()
        for i, value in enumerate(values, 1)
    }
    for i, (low, high) in enumerate(found.bands_hz, 1):
        named |= {f"band_{i}_from": float(low), f"band_{i}_to": float(high)}
    if found.phase_margins.size:
        nearest = np.argmin(np.abs(found.phase_margins))
        named["phase_margin_min"] = named[f"phase_margin_{nearest + 1}"]
    return named | {
        "s_max": found.s_max,
        "s_max_frequency": found.s_max_hz,
        "real_min": found.real_min,
        "real_min_frequency": found.real_min_hz,
        "magnitude_max": found.magnitude_max,
        "magnitude_max_frequency": found.magnitude_max_hz,
    }
