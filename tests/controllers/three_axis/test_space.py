"""The path in space and the projections across it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.three_axis import space_path, task_frame_space

angles = st.floats(-4, 4)
lengths = st.floats(-1, 1)


def path(T_s: float, t_r: float) -> np.ndarray:
    """Return the outputs over the whole path, one row per tick."""
    p = space_path.Parameters(t_r=t_r)
    x, rows = space_path.State(), []
    for _ in range(round(p.T / T_s) + 1):
        x, y = space_path.step(x, space_path.Input(), p, T_s)
        rows.append(y)
    return np.array(rows)


def test_the_path_keeps_its_cone_and_its_rates() -> None:
    T_s = 1e-2
    found = path(T_s, 0.0)
    assert found[-1, :3] == pytest.approx([-0.002578, 0.0, 0.455643], abs=1e-6)
    alpha = np.arccos(found[:, 3:6])
    assert np.degrees(np.max(alpha, axis=0)) == pytest.approx(
        [111.99, 124.71, 40.0], abs=0.01
    )
    rates = np.max(np.abs(np.diff(alpha, axis=0)), axis=0) / T_s
    assert rates == pytest.approx([0.751, 0.808, 0.219], abs=1e-3)


def test_the_path_does_not_depend_on_the_sample_time() -> None:
    coarse, fine = path(1e-2, 0.5), path(2e-3, 0.5)
    assert coarse[:, :3] == pytest.approx(fine[::5, :3], abs=1e-11)


def errors(t: np.ndarray, e: np.ndarray) -> task_frame_space.Output:
    u = task_frame_space.Input(*e, *t)
    parameters, state = task_frame_space.Parameters(), task_frame_space.State()
    return task_frame_space.step(state, u, parameters, 1e-3)[1]


@given(angles, angles, lengths, lengths, lengths)
def test_the_error_across_is_a_projection_of_rank_two(
    alpha: float, psi: float, e_x: float, e_y: float, e_z: float
) -> None:
    """P = P² = P', P t = 0; (8.11) bounds the third part from above."""
    s = np.sin(alpha)
    t = np.array([s * np.cos(psi), s * np.sin(psi), np.cos(alpha)])
    P = np.array([errors(t, e)[4:7] for e in np.eye(3)])
    assert pytest.approx(P @ P, abs=1e-14) == P
    assert pytest.approx(P.T, abs=1e-14) == P
    assert pytest.approx(np.zeros(3), abs=1e-14) == P @ t
    assert np.linalg.svd(P)[1] == pytest.approx([1, 1, 0], abs=1e-14)

    y = errors(t, np.array([e_x, e_y, e_z]))
    whole = y.e_t**2 + y.e_nb**2
    assert whole == pytest.approx(e_x**2 + e_y**2 + e_z**2, abs=1e-14)
    if abs(t[2]) > 1e-3:
        bound = abs(s / t[2]) * np.hypot(y.e_nbx, y.e_nby)
        assert abs(y.e_nbz) <= bound * (1 + 1e-9) + 1e-12
