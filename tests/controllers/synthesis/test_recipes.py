"""Recipes keep what they promise: bandwidth, margin, damping, the mode's width."""

import control as ct
import numpy as np
import pytest

from controllers.ball_screw import filter_pack
from controllers.synthesis.ball_screw import recipes as ball_screw
from controllers.synthesis.linearise import linearise
from controllers.synthesis.recipes import (
    cascade,
    current_loop,
    notch_of,
    of_bandwidths,
    position_gain,
    symmetrical_optimum,
)
from controllers.synthesis.xy_table import recipes as xy_table

S = ct.tf("s")


def test_a_current_loop_is_of_first_order_with_its_bandwidth() -> None:
    L, R = 3e-3, 0.8
    K_p, K_i = current_loop(L, R, 800.0)
    closed = ct.minreal(ct.feedback((K_p + K_i / S) / (L * S + R)), verbose=False)
    assert closed.poles() == pytest.approx([-2 * np.pi * 800.0])
    assert closed.dcgain() == pytest.approx(1.0)


@pytest.mark.parametrize("degrees", [30.0, 45.0, 60.0])
def test_the_symmetrical_optimum_crosses_over_with_its_phase_margin(
    degrees: float,
) -> None:
    m, T_sigma = 2.2e-3, 6e-4
    K_p, K_i = symmetrical_optimum(m, T_sigma, np.deg2rad(degrees))
    L = (K_p + K_i / S) / (m * S * (1 + T_sigma * S))
    _, margin, _, omega_c = ct.margin(L)
    assert margin == pytest.approx(degrees, rel=1e-6)
    assert omega_c == pytest.approx(K_p / m, rel=1e-6)
    # it is the largest there: symmetrical about the crossover
    around = np.angle(L(1j * omega_c * np.array([0.9, 1.0, 1.1])), deg=True)
    assert np.argmax(np.mod(around, -360)) == 1


@pytest.mark.parametrize("damping", [0.5, 0.7, 1.0])
def test_a_position_loop_has_its_damping_over_a_lag(damping: float) -> None:
    T_e = 1.5e-3
    closed = ct.feedback(position_gain(T_e, damping) / (S * (1 + T_e * S)))
    assert ct.damp(closed, doprint=False)[1] == pytest.approx(damping, rel=1e-6)


def test_bandwidths_become_gains() -> None:
    K_v, (K_p, K_i) = of_bandwidths(2e-3, 60.0, 20.0, 30.0)
    turn = 2 * np.pi
    assert (K_v, K_p, K_i) == pytest.approx(
        (turn * 30, turn * 60 * 2e-3, turn * 20 * turn * 60 * 2e-3)
    )
    named = ball_screw.p_pi_of_bandwidths(1.5e-3, 0.5e-3, 60.0, 20.0, 30.0)
    assert list(named.values()) == pytest.approx([K_v, K_p, K_i])


def test_a_notch_has_the_frequency_and_width_of_the_sharpest_resonance() -> None:
    f_hz = np.geomspace(1, 2000, 20_000)
    s = 2j * np.pi * f_hz
    found = {}
    for f_n, zeta in ((150.0, 0.2), (420.0, 0.02)):
        w = 2 * np.pi * f_n
        found[f_n] = w * w / (s * s + 2 * zeta * w * s + w * w)
    notch = notch_of(f_hz, (1 + 0.3 * found[150.0] + 0.5 * found[420.0]) / s)
    assert notch.f_hz == pytest.approx(420, rel=1e-2)
    assert notch.zeta_z == pytest.approx(0.02, rel=0.1)
    assert notch.zeta_p == 0.7
    with pytest.raises(ValueError, match="no peak"):
        notch_of(f_hz, 1 / s)


def test_a_filter_packs_lag_is_that_of_its_phase_at_low_frequency() -> None:
    law = linearise(filter_pack.model, inputs=["v"], outputs=["u"], T_s=1e-6)
    omega = 2 * np.pi * 2.0
    phase = np.angle(law(np.exp(1j * omega * 1e-6)))
    lag = ball_screw.lag(filter_pack.Parameters())
    assert -phase / omega == pytest.approx(lag, rel=0.01)


def test_recipes_of_drives_are_near_the_published_gains() -> None:
    """Published: 189, 0.91, 119 of the ball screw's set A."""
    near = ball_screw.p_pi(1.858e-3, 0.379e-3, phase_margin_deg=60.0)
    for name, published in {"K_px": 189.0, "K_pv": 0.91, "K_iv": 119.0}.items():
        assert 0.5 < near[name] / published < 2
    found = xy_table.p_pi(78020.0, 1.2e-3)
    assert found.keys() == {"k_v", "k_p", "k_i"}


def test_numbers_that_make_no_loop_are_refused() -> None:
    for wrong in (
        lambda: current_loop(0.0, 1.0, 100.0),
        lambda: cascade(1.0, 1e-3, np.pi / 2),
        lambda: symmetrical_optimum(-1.0, 1e-3, 0.5),
        lambda: xy_table.p_pi(0.0, 1e-3),
    ):
        with pytest.raises(ValueError, match="is not"):
            wrong()
