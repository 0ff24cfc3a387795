"""The bipod keeps its energy and takes no more than it is given."""

from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plants.bipod import one_slider, two_sliders
from plants.bipod._friction import Friction

H = 5e-5  # s
forces = st.floats(-2000, 2000)
acting = st.lists(
    st.tuples(forces, forces, st.floats(-300, 300)), min_size=4, max_size=4
)
speeds = st.tuples(st.floats(-1, 1), st.floats(-1, 1))


def start(plant: ModuleType, phi: float, v: tuple[float, float]) -> Any:
    """Return a state at the angle φ (rad)."""
    reach = 0.125 + 1.4 * np.sin(phi)
    if plant is one_slider:
        return one_slider.State(one_slider.Parameters().x_2 - reach, v[0])
    return two_sliders.State(0.0, v[0], reach, v[1])


def given_power(x: Any, u: Any, p: Any, plant: ModuleType) -> float:
    """Return what forces on sliders and tool table bring in (W), friction apart."""
    free = p._replace(
        links=p.links._replace(b_x=0.0, b_phi=0.0), friction=Friction(on=False)
    )
    return float(plant.derivative(x, u, free).W)


def ahead(x: Any, h: float, k: Any) -> Any:
    return type(x)(*(a + h * b for a, b in zip(x, k, strict=True)))


@pytest.mark.parametrize("plant", [one_slider, two_sliders])
@settings(max_examples=25, derandomize=True)
@given(st.floats(0.2, 1.3), speeds, acting, st.booleans(), st.sampled_from([0.0, 9.81]))
def test_energy_is_kept_and_no_more_is_taken_than_given(
    plant: ModuleType,
    phi: float,
    v: tuple[float, float],
    held: list[tuple[float, float, float]],
    rough: bool,
    g: float,
) -> None:
    """E - W stays, and E rises by no more than the work of the forces."""
    p = plant.Parameters()._replace(friction=Friction(on=rough), g=g)
    x, work = start(plant, phi, v), 0.0
    E_0 = plant.output(x, plant.Input(), p).E
    for f_1, f_2, f_d in held:
        u = plant.Input(f_1, f_d) if plant is one_slider else plant.Input(f_1, f_2, f_d)
        for _ in range(10):
            k_1 = plant.derivative(x, u, p)
            x_2 = ahead(x, H / 2, k_1)
            k_2 = plant.derivative(x_2, u, p)
            x_3 = ahead(x, H / 2, k_2)
            k_3 = plant.derivative(x_3, u, p)
            x_4 = ahead(x, H, k_3)
            k_4 = plant.derivative(x_4, u, p)
            powers = [given_power(at, u, p, plant) for at in (x, x_2, x_3, x_4)]
            work += H / 6 * float(np.dot(powers, (1, 2, 2, 1)))
            for k, weight in ((k_1, 1), (k_2, 2), (k_3, 2), (k_4, 1)):
                x = ahead(x, weight * H / 6, k)
    E = plant.output(x, plant.Input(), p).E
    assert abs(E - E_0 - x.W) < 1e-8
    assert work - (E - E_0) > -1e-8
