"""Loops with dead time, several signals, several rates, friction, a foreign FMU."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from zipfile import ZipFile

import control as ct
import numpy as np
import pytest
from lag_loop import lag_loop, of_others
from measured_loops import composed, decibels, degrees
from numpy.typing import NDArray
from scipy.linalg import block_diag

from controllers.synthesis.frequency import evaluate
from controllers.synthesis.gantry.loops import sampled_loop
from controllers.synthesis.linearise import linearise
from controllers.synthesis.multivariable import respond
from controllers.xy_table import p_pi
from orchestrator.errors import ResponseError
from orchestrator.response.bench import bench
from orchestrator.response.excitation import Form, spectra
from orchestrator.response.figures import to_frd, words
from orchestrator.response.measure import measure, measure_transfer
from orchestrator.response.modes import growth
from orchestrator.response.traced import beside
from plants.xy_table import axis

Complex = NDArray[np.complex128]
TABLE = "cascade_nppi/p_pi_0_4hz"


def held(plant: ct.StateSpace, tau: float, T_s: float, z: Complex) -> Complex:
    """Return y/u of a plant whose held input arrives ``tau`` late, at points z."""
    n, whole = plant.nstates, int(tau // T_s)
    late = tau - whole * T_s  # the older value acts for this part of a sample

    def passed(h: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        found = plant.sample(h, "zoh")
        return found.A, found.B

    A, _ = passed(T_s)
    rest, new = passed(T_s - late)
    old = rest @ passed(late)[1] if late > 1e-12 else 0 * new
    return np.array(
        [
            (plant.C @ np.linalg.solve(p * np.eye(n) - A, new + old / p))[0, 0]
            * p**-whole
            for p in z
        ]
    )


def test_the_xy_tables_loop_is_the_exact_one_with_its_dead_time() -> None:
    T_s = 1 / 2000
    composition = composed(TABLE)
    found = measure(composition, ["controller.u"])
    low = found.hz <= 500
    z = np.exp(2j * np.pi * found.hz[low] * T_s)
    plant = linearise(axis.model, inputs=["u"], outputs=["y"])
    law = linearise(p_pi.model, inputs=["y"], outputs=["u"], T_s=T_s)
    tau = axis.model.parameters.tau
    L = -evaluate(law, z)[:, 0, 0] * held(plant, tau, T_s, z)
    S = found.S[low, 0, 0]
    assert decibels(S, 1 / (1 + L)) < 0.01
    assert degrees(S, 1 / (1 + L)) < 0.1
    assert "in motion" in next(words(found))
    traced, told = beside(composition, found)
    assert traced is not None
    assert "within" in told
    assert np.allclose(1 + traced.G[low, 0, 0], 1 / (1 + L), rtol=1e-6)


def test_the_gantrys_sensitivity_is_the_exact_matrix() -> None:
    breaks = ["y_controller.u_1", "y_controller.u_2"]
    composition = composed("gantry/mimo_line_200")
    found = measure(composition, breaks, lowest=Fraction(4))
    low = found.hz <= 3750
    exact = respond(sampled_loop("mimo", 0.0, {}), found.hz[low])
    S = np.linalg.inv(np.eye(2) + exact.K @ exact.G)
    large = np.linalg.norm(S, ord=2, axis=(1, 2))
    assert np.max(np.linalg.norm(found.S[low] - S, ord=2, axis=(1, 2)) / large) < 1e-3
    assert found.s_max[0] == pytest.approx(np.max(large), rel=0.01)
    L = to_frd(found)
    assert L.ninputs == L.noutputs == 2
    traced, _ = beside(composition, found)
    assert traced is not None
    assert np.allclose(np.eye(2) + traced.G[low], S, atol=1e-6 * np.max(large))
    # K G and its eigenvalues, by which generalised Nyquist judges the loops together
    eigenvalues = np.linalg.eigvals(exact.K @ exact.G)
    for line, wanted in zip(found.loci[low], eigenvalues, strict=True):
        assert np.allclose(np.sort_complex(line), np.sort_complex(wanted), rtol=1e-3)
    assert np.allclose(np.prod(1 + found.loci, axis=1), 1 / np.linalg.det(found.S))


def test_a_break_faster_than_its_loop_gives_the_fundamental_per_line() -> None:
    """Brute force: one sine at a time over the same cascade."""
    fast = measure(composed(TABLE), ["plant.y"], lowest=Fraction(4))
    assert fast.slower == "controller.u"
    assert fast.alias > 1e-3
    with bench(composed(TABLE), ["plant.y"]) as at:
        n = int(fast.period / at.rates.T)
        for i in (4, len(fast.hz) // 2, len(fast.hz) - 2):
            line = round(fast.hz[i] * float(fast.period))
            d = 0.1 * np.cos(2 * np.pi * line * np.arange(n) / n)
            last = at.responses([d], 9)[0, -n:]
            S = 1 + spectra(last, n, [line])[0, 0] / 0.1
            assert decibels(S, fast.S[i, 0, 0]) < 1e-3


@pytest.mark.parametrize("form", ["chirp", "stepped"])
def test_every_excitation_finds_the_same_loop(form: Form) -> None:
    table, low = composed(TABLE), Fraction(32)
    many = measure(table, ["controller.u"], lowest=low, quick=True)
    other = measure(
        table, ["controller.u"], lowest=1 / many.period, form=form, quick=True
    )
    common = np.isin(other.hz, many.hz)
    assert np.sum(common) > 5
    S = many.S[np.isin(many.hz, other.hz), 0, 0]
    assert np.max(np.abs(other.S[common, 0, 0] / S - 1)) < 1e-6


@pytest.mark.parametrize("broken", ["position.v_c", "velocity.v", "plant.x_1"])
def test_a_cascade_of_three_rates_is_that_of_one_sine_at_a_time(
    broken: str, request: pytest.FixtureRequest
) -> None:
    """20 kHz plant, 4 kHz velocity, 1 kHz position: broken at each of them."""
    if not request.config.getoption("--every-form"):
        pytest.skip("--every-form measures three rates")
    cascade = composed(
        "ball_screw_pole_placement/p_pi_split_track_500",
        "position.step=1/1000",
        "velocity.step=1/4000",
    )
    found = measure(cascade, [broken])
    assert found.slower == (None if broken == "position.v_c" else "position.v_c")
    with bench(cascade, [broken]) as at:
        n, size = int(found.period / at.rates.T), found.amplitude[0] / 10
        for i in range(3, len(found.hz), len(found.hz) // 7):
            line = round(found.hz[i] * float(found.period))
            d = size * np.cos(2 * np.pi * line * np.arange(n) / n)
            B = spectra(at.responses([d], 4)[0, -n:], n, [line])[0, 0]
            assert decibels(1 + B / size, found.S[i, 0, 0]) < 1e-3


def test_friction_is_told_by_distortion_and_by_half_the_amplitude() -> None:
    rubbing = composed(
        "ball_screw_pole_placement/mc_ppc_friction_reversal", "rates.control=10 kHz"
    )
    found = measure(rubbing, ["controller.u"], lowest=Fraction(64), amplitude=0.3)
    assert found.distortion > 0.01
    assert found.half > 0.01
    assert any(line.startswith("not linear") for line in words(found))


def test_a_foreign_fmus_loop_is_measured_as_its_own_models_is(tmp_path: Path) -> None:
    """The same plant in an FMU that was not built here runs in a process apart."""
    here = composed(TABLE)
    plant = here.system.components["plant"]
    copy = tmp_path / "theirs.fmu"
    copy.write_bytes(plant.fmu.read_bytes())
    with ZipFile(copy, "a") as archive:
        archive.comment = b"theirs"
    foreign = replace(plant, fmu=copy)
    parts = {**here.system.components, "plant": foreign}
    there = replace(here, system=replace(here.system, components=parts))
    both = [
        measure(c, ["controller.u"], lowest=Fraction(8), quick=True)
        for c in (here, there)
    ]
    assert np.array_equal(both[0].S, both[1].S)
    there = replace(there, sources={**there.sources, "plant": "theirs.fmu"})
    traced, told = beside(there, both[1])
    assert traced is None
    assert "plant is theirs.fmu, whose equations are not known here" in told


LATE = ["controller.latency=300", "controller.K=0.1"]  # 4.8 periods of 1/16 s


@pytest.mark.parametrize("foreign", [False, True])
def test_an_answer_that_is_not_there_yet_is_waited_for(
    foreign: bool, tmp_path: Path
) -> None:
    """Four periods of silence are no L = 0, nor is the first time round all of it."""
    ours = lag_loop(tmp_path, *LATE)
    loop = of_others(ours, "plant", tmp_path) if foreign else ours
    found = measure(loop, ["controller.u"], lowest=Fraction(16), quick=True)
    equations, told = beside(ours, found)
    assert equations is not None, told
    assert np.allclose(found.S, 1 + equations.G, atol=1e-6)
    way = measure_transfer(
        loop, ["plant.u"], ["controller.u"], lowest=Fraction(16), quick=True
    )
    assert np.allclose(way.G, equations.G, atol=1e-6)


def test_a_gain_of_zero_is_told_and_what_never_comes_is_refused(tmp_path: Path) -> None:
    ours = lag_loop(tmp_path, "controller.K=0")
    found = measure(ours, ["controller.u"], lowest=Fraction(16))
    assert np.all(found.L == 0)
    assert any("by the models' equations nothing can" in line for line in words(found))
    theirs = of_others(ours, "plant", tmp_path)
    with pytest.raises(ResponseError, match="nothing of what is injected arrives at"):
        measure(theirs, ["controller.u"], lowest=Fraction(16), amplitude=0.1)
    ways = measure_transfer(
        theirs, ["plant.u"], ["plant.y", "controller.u"], lowest=Fraction(16)
    )
    assert np.all(ways.G[:, 0] != 0)
    assert np.all(ways.G[:, 1] == 0)
    assert any("arrives at controller.u, within 8" in line for line in words(ways))


@pytest.mark.parametrize("foreign", [False, True])
@pytest.mark.parametrize("K", [-1.2, -1.01, -1.001])
def test_a_loop_whose_differences_grow_from_period_to_period_has_no_margins(
    K: float, foreign: bool, tmp_path: Path
) -> None:
    """A pole at about s = (-K - 1)/T, the slowest of which takes long to be large."""
    ours = lag_loop(tmp_path, f"controller.K={K}")
    loop = of_others(ours, "plant", tmp_path) if foreign else ours
    rate = np.log(1 - (K + 1) * (1 - np.exp(-0.1))) / 1e-3
    told = "unstable" if foreign else f"grows by {rate:.3g} 1/s"
    with pytest.raises(ResponseError, match=told):
        measure(loop, ["controller.u"], lowest=Fraction(16), amplitude=0.1, quick=True)


def test_what_stays_as_large_as_it_is_does_not_grow() -> None:
    """Integrators one behind another, a free oscillation, and a long delay."""
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])
    whole = block_diag(np.eye(3) + np.eye(3, k=1), turn, np.eye(90, k=-1))
    skew = np.linalg.qr(np.random.default_rng(1).normal(size=whole.shape))[0]
    assert growth(whole, 1e-3) is None
    assert growth(skew @ whole @ skew.T, 1e-3) is None
    found = growth(block_diag(whole, 1.00001 * turn), 1e-3)
    assert found is not None
    assert found.rate == pytest.approx(0.01, rel=1e-3)
    assert found.hz == pytest.approx(np.arccos(0.6) / (2 * np.pi * 1e-3))


def test_equations_stand_beside_lines_whose_period_is_no_binary_number(
    tmp_path: Path,
) -> None:
    """A period of 63/1000 s, twice: as a float it is no multiple of a sample."""
    loop = lag_loop(tmp_path)
    found = measure(loop, ["controller.u"], lowest=Fraction(16), quick=True)
    assert found.ended == (found.settled + 1) * Fraction(63, 1000)
    equations, told = beside(loop, found)
    assert equations is not None, told
    assert np.allclose(found.S, 1 + equations.G, atol=1e-6)
