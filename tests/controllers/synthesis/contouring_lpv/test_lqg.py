"""The gridded LQG is what its design gives and stabilises a path that stands still."""

import json

import numpy as np
import pytest

from controllers.synthesis.contouring_lpv import designs, lqg
from controllers.synthesis.contouring_lpv.planar import axis_model, beside
from plants.three_axis._axes import X, Y, Z


@pytest.fixture(scope="module")
def shipped() -> dict[str, object]:
    return json.loads((designs.FOLDER / "lqg_spatial.json").read_text())


def test_the_shipped_gains_are_the_design_made_anew(shipped) -> None:
    made = json.loads(designs.DESIGNS["lqg_spatial"]()["lqg_spatial.json"])
    for name in ("q", "F", "G", "C", "A_w", "B_w", "L", "K"):
        scale = np.max(np.abs(shipped[name]))
        assert np.array(made[name]) == pytest.approx(
            np.array(shipped[name]), abs=1e-6 * scale
        ), name


def test_frozen_loops_with_all_modes_are_stable(shipped) -> None:
    names = ("F", "G", "C", "L", "A_w", "B_w")
    F, G, C, L, A_w, B_w = (np.array(shipped[name]) for name in names)
    gains = np.array(shipped["K"]).reshape(len(shipped["q"]), 3, -1)
    plant = beside([axis_model(axis, np.inf) for axis in (X, Y, Z)])
    F_p, G_p = lqg.held(plant, lqg.T_S)
    n, k, m = len(F), len(A_w), len(F_p)
    zero = np.zeros
    for T, K in zip(lqg.along(np.array(shipped["q"])), gains, strict=True):
        K_x, K_w = K[:, :n], K[:, n:]
        loop = np.block(
            [
                [F_p, -G_p @ K_x, -G_p @ K_w],
                [-L @ plant.C, F - L @ C - G @ K_x, -G @ K_w],
                [-B_w @ T @ plant.C, zero((k, n)), A_w],
            ]
        )
        assert len(loop) == n + k + m
        assert np.max(np.abs(np.linalg.eigvals(loop))) < 1
