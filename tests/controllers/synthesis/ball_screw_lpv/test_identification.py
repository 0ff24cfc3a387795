"""What runs and responses tell about the drive, and how well."""

from dataclasses import replace

import numpy as np
import pytest

from controllers.synthesis.ball_screw_lpv.mode_identification import (
    flexible_mode,
    over_position_and_mass,
    over_stroke,
    physical,
    rank_one,
    responses,
    stroke,
)
from controllers.synthesis.ball_screw_lpv.plants import over_x, with_mode
from controllers.synthesis.ball_screw_lpv.rigid_identification import rigid_body
from controllers.synthesis.lpv.systems import System, poles, response
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run
from plants.ball_screw_lpv._mode import (
    R_G,
    OverPosition,
    OverPositionAndMass,
    force_on_table,
    over_position,
)
from plants.ball_screw_lpv._mode import over_position_and_mass as table_3_4
from plants.ball_screw_lpv._screw import Screw, matrices

POSITIONS = np.linspace(0.2, 0.6, 81)
OMEGA = np.linspace(700.0, 2600.0, 400)
PUBLISHED = {
    "rigid.J_e": 7.1432e-4,
    "rigid.B_e": 0.0156,
    "friction.T_plus": 0.3686,
    "friction.T_minus": -0.2551,
}


def test_co_simulated_jogs_give_table_3_2(tmp_path) -> None:  # type: ignore[no-untyped-def]
    done = run(load_scenario("ball_screw_lpv/jogs_identified"), tmp_path, report=False)
    found = done.composition.designs["rigid"].values
    for name, value in PUBLISHED.items():
        assert found[name] == pytest.approx(value, rel=2e-4)
    # least squares that leave the friction out see it as inertia and damping
    biased = done.composition.designs["biased"].values
    assert biased["rigid.J_e"] > 1.05 * PUBLISHED["rigid.J_e"]
    assert biased["rigid.B_e"] > 1.2 * PUBLISHED["rigid.B_e"]


def test_elements_of_a_designed_array_are_figures(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """``metric = "design.<step>.<name>[i]"`` of ``reference.toml``."""
    from orchestrator.reproduction.reproduce import _designed

    done = run(load_scenario("ball_screw_lpv/jogs_identified"), tmp_path, report=False)
    result = done.composition.designs["rigid"]
    array = replace(result, values={"rigid.J_e": (1.0, 2.0)})
    done.composition.designs["rigid"] = array  # type: ignore[index]
    found = _designed(done)
    assert found["design.rigid.rigid.J_e[2]"].value == 2.0


def test_noise_on_the_speed_leaves_the_inertia(tmp_path) -> None:  # type: ignore[no-untyped-def]
    done = run(load_scenario("ball_screw_lpv/jogs"), tmp_path, report=False)
    v, v_m = (np.asarray(done[n].values) for n in ("plant.v", "jogs.v_m"))
    noise = np.random.default_rng(1).normal(size=len(v)) * 1e-5
    found = rigid_body(9 / 25_000, v_m, v + noise)
    for name, value in PUBLISHED.items():
        assert found[name] == pytest.approx(value, rel=5e-3)


def test_a_jog_that_hardly_moves_is_refused() -> None:
    with pytest.raises(ValueError, match="moves too little"):
        rigid_body(1e-3, np.ones(100), np.linspace(0.0, 0.1, 100))


@pytest.mark.parametrize("x_c", [0.2, 0.35, 0.6])
def test_responses_give_the_mode(x_c: float) -> None:
    G = response(over_x(x_c, run_out=1.0), 1j * OMEGA)[:, :, 0]
    known = over_position(x_c, OverPosition(), R_G, 1.0)
    for value, true in zip(flexible_mode(OMEGA, G), known, strict=True):
        assert value == pytest.approx(true, rel=1e-6)


def test_one_percent_of_noise_costs_little() -> None:
    """Bounds of the dossier: ω 0.01 %, ζ and α 0.4 %, β 1.5 %, of one trial doubled."""
    G = response(over_x(0.4), 1j * OMEGA)[:, :, 0]
    draw = np.random.default_rng(2).normal(size=(2, *G.shape))
    noisy = G * (1 + 0.01 / np.sqrt(2) * (draw[0] + 1j * draw[1]))
    found, known = flexible_mode(OMEGA, noisy), over_position(0.4, OverPosition(), R_G)
    bounds = {"omega": 2e-4, "zeta": 8e-3, "alpha_11": 8e-3, "alpha_12": 8e-3}
    for name, bound in bounds.items():
        assert getattr(found, name) == pytest.approx(getattr(known, name), rel=bound)
    for name in ("beta_11", "beta_12"):
        assert getattr(found, name) == pytest.approx(getattr(known, name), rel=3e-2)


def test_responses_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match=r"not \(400, 2\)"):
        flexible_mode(OMEGA, np.ones((400, 1), dtype=complex))


def test_a_mode_of_rank_one_gives_the_table_its_response() -> None:
    mode = over_position(0.4, OverPosition(), R_G)
    alpha_22, beta_22 = rank_one(mode)
    assert alpha_22 == pytest.approx(0.022951, rel=1e-3)
    s = 1j * mode.omega
    G = response(with_mode(mode, 0.0), np.array([s]))[0, 1, 1]
    den = 2 * mode.zeta * mode.omega * s
    body = R_G**2 / (s * (7.1432e-4 * s + 0.0156))
    assert (G - body) * den == pytest.approx(alpha_22 + s * beta_22, rel=5e-4)


def test_co_simulated_responses_give_the_mode_over_the_stroke(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """Nine positions of the 81; fields compare, as phases have a sign to choose."""
    sets = ["stop=8.1", "stations.N=9", "stations.d=0.045"]
    done = run(load_scenario("ball_screw_lpv/stroke", sets), tmp_path, report=False)
    names = ("stations.x_c", "multisine.d_1", "plant.u_m", "plant.u_c")
    signals = [np.asarray(done[name].values) for name in names]
    found = stroke(3 / 50_000, *signals)
    c = OverPosition(
        *(found[f"mode.{name}"] for name in OverPosition._fields[:-1]),
        phase=found["mode.phase"],
    )
    for x in POSITIONS:
        ours, known = (over_position(x, o, R_G, 1.0) for o in (c, OverPosition()))
        for value, true in zip(ours, known, strict=True):
            assert value == pytest.approx(true, rel=1e-3)


def test_the_fit_over_the_stroke_finds_its_own_function() -> None:
    for name in ("zeta", "alpha_11", "beta_12"):
        values = np.array(
            [
                getattr(over_position(x, OverPosition(), R_G, 1.0), name)
                for x in POSITIONS
            ]
        )
        assert over_stroke(POSITIONS, values).at(POSITIONS) == pytest.approx(
            values, rel=1e-10
        )


def test_a_plane_over_position_and_mass_finds_table_3_4() -> None:
    x, m = (a.ravel() for a in np.meshgrid(POSITIONS, [0.0, 5.0, 10.0]))
    values = np.array(
        [
            table_3_4(*point, OverPositionAndMass()).omega
            for point in zip(x, m, strict=True)
        ]
    )
    plane = over_position_and_mass(x, m, values)
    assert [plane.c_0, plane.c_x, plane.c_m] == pytest.approx(
        [1299 + 320 * 0.64, -320, -15]
    )
    assert plane.rms < 1e-9
    # what the mode bends besides, the plane leaves as its error
    curved = over_position_and_mass(x, m, values + 400 * (x - 0.4) ** 2)
    assert 0 < curved.mean < curved.rms


def test_a_record_without_whole_periods_is_refused() -> None:
    with pytest.raises(ValueError, match="whole periods"):
        responses(np.array([3.3]), 0.1, np.ones(10), np.ones((10, 2)))


@pytest.mark.parametrize("x_c", [0.2, 0.6])
def test_the_matrices_behind_a_mode_have_that_mode(x_c: float) -> None:
    mode = over_position(x_c, OverPosition(), R_G)
    M, C, K = physical(mode)
    zero, eye = np.zeros((2, 2)), np.eye(2)
    A = np.block([[zero, eye], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    found = max(poles(System(A, zero, zero, zero)), key=lambda p: p.imag)
    assert abs(found) == pytest.approx(mode.omega, rel=1e-9)
    assert -found.real / abs(found) == pytest.approx(mode.zeta, rel=1e-9)
    assert K @ np.ones(2) == pytest.approx(np.zeros(2), abs=1e-3 * K[0, 0] / 1e3)


def test_the_analytic_model_predicts_the_stiffness_and_not_the_coupling() -> None:
    """Fig. 3.16: k and m_22 near the identified ones, the inertia between them not."""
    for x_c in (0.2, 0.4, 0.6):
        M, _, K = physical(over_position(x_c, OverPosition(), R_G))
        analytic = matrices(x_c, 0.0, Screw())
        assert K[0, 0] == pytest.approx(analytic.k_e, rel=0.25)
        assert M[1, 1] == pytest.approx(analytic.m_22, rel=0.25)
        assert M[0, 1] < 0 < analytic.m_12


def test_forces_on_the_table_follow_from_the_motor_side() -> None:
    mode = over_position(0.4, OverPosition(), R_G)
    b_0, b_1 = force_on_table(mode)
    assert b_1 < 0 < b_0
