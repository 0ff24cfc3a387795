"""Loops of the gantry against theory and a computation without our models."""

import numpy as np
import pytest

from controllers.synthesis import multivariable as mv
from controllers.synthesis.gantry import loops as gl

F_HZ = np.array([5.0, 57.55, 94.0])


def test_the_averaged_loop_does_not_see_the_yaw_mode():
    response = gl.continuous_response("mimo", 0.1, {"beta": 0.0, "k_i": 0.0}, F_HZ)
    averaged = gl.continuous_response(
        "mimo", 0.1, {"beta": 0.0, "k_i": 0.0, "plant.k": 1e9}, F_HZ
    )
    eigenvalues = np.sort(np.abs(np.linalg.eigvals(response.L)), axis=1)
    stiff = np.sort(np.abs(np.linalg.eigvals(averaged.L)), axis=1)
    # rank one: the centre of mass only, whatever the stiffness of the yaw (eq. 4.24)
    assert eigenvalues[:, 0] == pytest.approx(0, abs=1e-9)
    assert eigenvalues[:, 1] == pytest.approx(stiff[:, 1], rel=1e-9)


def test_sampled_and_continuous_loops_agree_at_low_frequency():
    f_hz = np.array([0.5, 2.0])
    late = mv.respond(gl.sampled_loop("mimo", 0.0, {}, latency=0), f_hz)
    ideal = gl.continuous_response("mimo", 0.0, {}, f_hz)
    assert np.abs(late.L - ideal.L) / np.abs(ideal.L) == pytest.approx(0, abs=2e-3)


def test_active_damping_is_what_keeps_the_loop_stable():
    damped, free = (gl.figures("mimo", **p) for p in ({}, {"beta": 0.0}))
    assert (damped["radius"] < 1, damped["turns"]) == (True, 0)
    assert (free["radius"] > 1, free["turns"]) == (True, 2)
    assert free["growing_frequency"] == pytest.approx(94.13, rel=3e-3)
    assert free["growing_damping"] == pytest.approx(-0.0236, rel=0.05)
    assert free["growth_time"] == pytest.approx(0.0717, rel=0.05)


def test_without_damping_the_integral_limit_is_that_of_the_negative_damping():
    # k_i takes k_i |h| a_1 a_2/omega^2 of the yaw's damping c
    assert gl.integral_limit(beta=0.0) == pytest.approx(5.84e6, rel=0.01)


def test_the_pid_baseline_is_unstable_when_both_drives_lag():
    figures = gl.figures("pid", **{"plant.amplifier.on": True})
    assert figures["s_max"] == pytest.approx(26, rel=0.02)
    assert (figures["radius"] > 1, figures["turns"]) == (True, 2)


def test_unknown_names_are_refused():
    with pytest.raises(LookupError, match="mimo and pid"):
        gl.figures("lqg")
    with pytest.raises(LookupError, match="z or s"):
        gl.figures("mimo", domain="w")
    with pytest.raises(LookupError, match="no parameter"):
        gl.figures("mimo", K_p=1.0)
