"""FMUs of machines give back no more than forces put in (Hanifzadegan 2014).

Forces are held over a step, so their work is force times travel, whatever happens
between.  What is not given back or stored, friction took.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.build import build
from orchestrator.master.stepper import Stepper
from plants.bipod import one_slider
from plants.serial import axis
from plants.three_axis import _values

STEP = "1/1000"  # s
L_S = 0.7  # m
draws = settings(max_examples=6, derandomize=True)


def held(*largest: float, steps: int = 6) -> st.SearchStrategy[Any]:
    """Draw inputs for some steps, each up to its size."""
    once = st.tuples(*(st.floats(-size, size) for size in largest))
    return st.lists(once, min_size=steps, max_size=steps)


def balances(
    module: str,
    start: Mapping[str, Any],
    inputs: list[str],
    rows: list[tuple[float, ...]],
    read: Callable[[Stepper], np.ndarray],
) -> list[np.ndarray]:
    """Return what ``read`` tells at the start and after each step."""
    with Stepper(build(module), start) as fmu:
        told = [read(fmu)]
        for row in rows:
            for name, value in zip(inputs, row, strict=True):
                fmu[name] = value
            fmu.step(STEP)
            told.append(read(fmu))
    return told


@pytest.mark.parametrize("sliders", [1, 2])
@draws
@given(
    phi=st.floats(0.2, 1.3),
    speed=st.floats(-1, 1),
    rows=held(2000, 2000, 300),
    rough=st.booleans(),
    g=st.sampled_from([0.0, 9.81]),
)
def test_the_bipod_keeps_its_energy_and_gives_back_no_more_than_it_got(
    sliders: int,
    phi: float,
    speed: float,
    rows: list[tuple[float, ...]],
    rough: bool,
    g: float,
) -> None:
    """One slider and both, with friction and gravity or without: below 1e-9 J."""
    reach, start = 0.125 + 2 * L_S * np.sin(phi), {"friction.on": rough, "g": g}
    start |= {"state.v_1": speed}
    if sliders == 1:
        start["state.x_1"] = one_slider.Parameters().x_2 - reach
        rows = [(f_1, f_d) for f_1, _, f_d in rows]
        module, inputs = "plants.bipod.one_slider", ["f_1", "f_d"]
    else:
        start |= {"state.x_2": reach, "state.v_2": -speed / 2}
        module, inputs = "plants.bipod.two_sliders", ["f_1", "f_2", "f_d"]

    def read(fmu: Stepper) -> np.ndarray:
        x = [fmu["x_1"], *([fmu["x_2"]] if sliders == 2 else [])]
        return np.array([fmu["E"], fmu["W"], *x, L_S * np.cos(fmu["phi"])])

    told = balances(module, start, inputs, rows, read)
    stored = np.array([row[0] - row[1] for row in told])
    assert np.ptp(stored) < 1e-9
    for before, after, row in zip(told, told[1:], rows, strict=False):
        moved = after - before
        assert np.dot(row, moved[2:]) > moved[0] - 1e-9


@draws
@given(rows=held(3, 3, 300, 300, steps=8), rough=st.booleans())
def test_the_serial_machine_moves_by_no_more_than_its_motors_and_forces_give(
    rows: list[tuple[float, ...]], rough: bool
) -> None:
    """The rigid body of either axis; the other axis has no part in it."""
    p = axis.Parameters()
    mass = p.rigid.J_e / p.rigid.r_g**2
    newton = p.amplifier.k_t * p.amplifier.k_a / p.r_g

    def read(fmu: Stepper) -> np.ndarray:
        v = np.array([fmu["v_x"], fmu["v_y"]])
        return np.array([*mass * v**2 / 2, fmu["state.x.u_0"], fmu["state.y.u_0"]])

    start = {"x.friction.on": rough, "y.friction.on": rough}
    inputs = ["v_mx", "v_my", "f_cx", "f_cy"]
    told = balances("plants.serial.machine", start, inputs, rows, read)
    for before, after, row in zip(told, told[1:], rows, strict=False):
        force = newton * np.array(row[:2]) + np.array(row[2:])
        kept, moved = np.split(after - before, 2)
        lost = force * moved - kept
        assert np.all(lost > -1e-9)
    alone = [(x, 0.0, f, 0.0) for x, _, f, _ in rows]
    apart = balances("plants.serial.machine", start, inputs, alone, read)
    assert [row[[0, 2]].tolist() for row in apart] == [
        row[[0, 2]].tolist() for row in told
    ]
    assert np.all(apart[-1][[1, 3]] == 0)


@draws
@given(rows=held(5, 5, 5, 200, 200, 200, steps=8), rough=st.booleans())
def test_the_three_axes_take_what_their_motors_and_forces_give(
    rows: list[tuple[float, ...]], rough: bool
) -> None:
    """The screws as bodies: friction takes the rest, viscous and Coulomb's.

    Of the flexible factor the source gives no masses: it has no energy to balance.
    """
    axes = (_values.X, _values.Y, _values.Z)
    r_g = np.array([a.p_t for a in axes]) / (2 * np.pi)
    mass, damping = (
        np.array([getattr(a, n) for a in axes]) / r_g**2 for n in ("J_e", "B_e")
    )
    newton = np.array([a.k_t * a.k_a for a in axes]) / r_g
    T_c = rough * np.array([a.friction.T_c for a in axes]) / r_g

    def read(fmu: Stepper) -> np.ndarray:
        return np.array([fmu[f"state.{a}.v"] for a in "xyz"])

    start = {f"{a}.friction.on": rough for a in "xyz"}
    inputs = [f"v_m{a}" for a in "xyz"] + [f"f_c{a}" for a in "xyz"]
    told = balances("plants.three_axis.spatial", start, inputs, rows, read)
    for before, after, row in zip(told, told[1:], rows, strict=False):
        force = newton * np.array(row[:3]) + np.array(row[3:])
        # the impulse that is missing is friction's: viscous with the travel, else T_c
        lost = 1e-3 * force - mass * (after - before)
        fastest = (
            np.maximum(np.abs(before), np.abs(after)) + 1e-3 * np.abs(force) / mass
        )
        assert np.all(np.abs(lost) <= 1e-3 * (damping * fastest + T_c) + 1e-9)
        going = (before * after > 0) & (np.abs(before) > 1e-2)
        assert np.all((lost * np.sign(before))[going] >= 0)
