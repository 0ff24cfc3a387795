"""The shipped table of five points against the controller rebuilt at every sample.

The harmonic run of chapter 4 (3 V at 1350 rad/s, friction, run-out, x_c moving) with
a simulation of its own: Runge-Kutta at 60 us on the plant's equations.
"""

from collections.abc import Callable

import numpy as np

from controllers.ball_screw_lpv import reference
from controllers.synthesis.ball_screw_lpv import designs
from controllers.synthesis.ball_screw_lpv.plants import VOLT
from controllers.synthesis.lpv import linear
from controllers.synthesis.lpv.reconstruction import controller
from controllers.synthesis.lpv.systems import System, transformed, tustin
from plants.ball_screw_lpv import lpv

T_S, SUBSTEPS, TICKS = 9 / 25_000, 6, 5361
P = lpv.model.parameters


def rates(x: np.ndarray, v_m: float, t: float) -> np.ndarray:
    state = lpv.State(*x)
    told = lpv.Input(v_m=v_m, f_m=3.0 * VOLT * np.sin(1350.0 * t), x_c=0.65 - u_c(x))
    return np.array(lpv.derivative(state, told, P))


def u_c(x: np.ndarray) -> float:
    """Table position; the mode at x_c = 0.65 - u_0, what u_c differs by is 1e-5."""
    told = lpv.Input(x_c=0.65 - x[0])
    return float(lpv.output(lpv.State(*x), told, P).u_c)


def run(K_vib: Callable[[float], System]) -> tuple[np.ndarray, np.ndarray]:
    """Return the error (m) and v_v (V) of every sample."""
    K = linear.read(designs.read("k_track.json")).system
    state = reference.model.state
    x, x_t, x_v = np.array([0.15, 0.0, 0.0, 0.0]), np.zeros(4), np.zeros(9)
    errors, commands = [], []
    for k in range(TICKS):
        state, command = reference.step(state, (), reference.model.parameters, T_S)
        y = lpv.output(lpv.State(*x), lpv.Input(x_c=0.65 - x[0]), P)
        e, gap = float(command.r) - float(y.u_c), float(y.u_m) - float(y.u_c)
        V = K_vib(0.65 - float(y.u_c))
        v_t = (K.C @ x_t + K.D[:, 0] * e).item()
        v_v = (V.C @ x_v + V.D[:, 0] * gap).item()
        x_t, x_v = K.A @ x_t + K.B[:, 0] * e, V.A @ x_v + V.B[:, 0] * gap
        errors.append(e)
        commands.append(v_v)
        for i in range(SUBSTEPS):
            h = T_S / SUBSTEPS
            t = k * T_S + i * h
            k_1 = rates(x, v_t + v_v, t)
            k_2 = rates(x + h / 2 * k_1, v_t + v_v, t + h / 2)
            k_3 = rates(x + h / 2 * k_2, v_t + v_v, t + h / 2)
            k_4 = rates(x + h * k_3, v_t + v_v, t + h)
            x = x + h / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
    return np.array(errors), np.array(commands)


def test_five_points_lose_nothing_that_matters() -> None:
    found = designs.vibration()
    used, region, units = found.used[0], found.problem.regions[0], found.units

    def exact(x_c: float) -> System:
        rho = (min(max(x_c, 0.2), 0.6),)
        plant = units.plant(found.problem.plant(rho))
        Y = used.at(region.basis.values(rho))
        K = units.controller(controller(plant, used.X, Y, used.gamma))
        return transformed(tustin(K, T_S), found.balance)

    by_table, v_table = run(lambda x_c: found.tables[0].at((x_c,)))
    by_formula, v_formula = run(exact)
    assert np.max(np.abs(by_formula)) < 40e-6
    assert np.max(np.abs(by_table - by_formula)) <= 0.05e-6
    assert np.max(np.abs(v_table - v_formula)) <= 3e-3
