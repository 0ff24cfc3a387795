"""What the study of the ball screw with varying dynamics must show."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from controllers.ball_screw_lpv import k_track, lpv, lpv_damped
from controllers.synthesis.linearise import linearise
from orchestrator.reproduction.reproduce import reproduce
from plants.ball_screw_lpv import lpv as plant

T_S = 9 / 25_000


@pytest.mark.parametrize(
    "only",
    [
        "parameters.*",
        "table_3*",
        "hybrid.*",
        "current_loop.*",
        "plant.*",
        "milling.*",
        "reference.*",
        "case_1.*",
        "case_[23].*",
        "damped.*",
        "chapter_5.*",
        "fig_*",
        "weights.*",
    ],
)
def test_figures_are_within_the_tolerances_of_the_study(
    only: str, tmp_path: Path
) -> None:
    figures = reproduce("ball_screw_lpv", only, processes=1, folder=tmp_path).figures
    assert [f.spec.id for f in figures if f.regression == "FAILED"] == []
    assert figures


def radius(model, x_c: float, latency: int, **parameters: bool) -> float:
    """Largest magnitude of the poles of the sampled loop, from the models' graphs."""
    p = plant.Parameters()._replace(
        friction=plant.Parameters().friction._replace(on=False), run_out=False
    )
    drive = linearise(
        plant.model,
        parameters=p,
        input=plant.Input(x_c=x_c),
        inputs=["v_m"],
        outputs=["u_m", "u_c"],
    )
    told = model.parameters
    if parameters:
        told = told._replace(tracking=told.tracking._replace(**parameters))
    law = linearise(
        model,
        parameters=told,
        input=lpv.Input(u_m=0.65 - x_c, u_c=0.65 - x_c, r=0.65 - x_c),
        inputs=["u_m", "u_c"],
        outputs=["v_m"],
    )
    n, k = drive.A.shape[0], law.A.shape[0]
    held = np.zeros((n + 1, n + 1))
    held[:n, :n], held[:n, n:] = drive.A, drive.B
    held = expm(held * T_S)
    F, G = held[:n, :n], held[:n, n:]
    C, (A, B, H, D) = drive.C, (law.A, law.B, law.C, law.D)
    if latency:
        zero = np.zeros
        A = np.block([[A, zero((k, 1))], [H, zero((1, 1))]])
        B, H = np.vstack([B, D]), np.hstack([zero((1, k)), np.ones((1, 1))])
        D = zero((1, 2))
    loop = np.block([[F + G @ D @ C, G @ H], [B @ C, A]])
    return float(np.max(np.abs(np.linalg.eigvals(loop))))


@pytest.mark.parametrize("latency", [0, 1])
@pytest.mark.parametrize("vibration", [False, True])
@pytest.mark.parametrize("x_c", [0.2, 0.3, 0.4, 0.5, 0.6])
def test_the_sampled_loop_keeps_its_radius_with_a_sample_of_latency(
    x_c: float, vibration: bool, latency: int
) -> None:
    found = radius(lpv.model, x_c, latency, vibration=vibration)
    assert found == pytest.approx(0.9935, abs=5e-4)


@pytest.mark.parametrize("x_c", [0.2, 0.4, 0.6])
def test_the_redesigned_tracking_is_stable_with_a_sample_of_latency(x_c: float) -> None:
    assert radius(lpv_damped.model, x_c, 1) <= 0.994
    assert k_track.model.period == lpv_damped.model.period
