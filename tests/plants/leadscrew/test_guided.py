"""The guided axis: the plain one when its parts are off, its own equations when on."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus.model import flat, pack, unpack
from plants.leadscrew import axis, guided
from plants.leadscrew.guided import Input, Parameters, State

P = Parameters(axis.Parameters(M=17.5, T_c=0.052, K_n=3.34e7, C_n=9200.0), T_s=0.104)
OFF = P._replace(T_s=P.screw.T_c, F_g=0.0)


def held(x: State, u: float, p: Parameters, h: float, n: int) -> State:
    for _ in range(n):
        x = guided.advance(x, Input(u), p, h)
    return x


def integrated(x: State, u: float, p: Parameters, t: float) -> State:
    def rhs(_: float, vector: np.ndarray) -> np.ndarray:
        return pack(guided.derivative(unpack(State(), vector), Input(u), p))

    found = solve_ivp(rhs, (0, t), pack(x), "LSODA", rtol=1e-10, atol=1e-18)
    return unpack(State(), found.y[:, -1])


def test_without_guide_and_static_level_it_is_the_plain_axis() -> None:
    plain, full = axis.State(), State()
    for u in (0.5, -0.4, 0.2):
        for _ in range(200):
            plain = axis.advance(plain, Input(u), OFF.screw, 1e-5)
            full = guided.advance(full, Input(u), OFF, 1e-5)
    assert tuple(flat(full)) == pytest.approx((*flat(plain), 0.0), rel=1e-9, abs=1e-18)


@pytest.mark.parametrize("u", [0.3, 2.0], ids=["presliding", "sliding"])
def test_the_rule_agrees_with_an_independent_integrator(u: float) -> None:
    ours, exact = State(), State()
    for way in (u, -u, u):
        ours = held(ours, way, P, 1e-5, 200)
        exact = integrated(exact, way, P, 2e-3)
    # m: a fortieth of a step of the sensor
    assert ours.screw.x == pytest.approx(exact.screw.x, abs=3e-11)
    assert ours.w == pytest.approx(exact.w, abs=3e-11)


def test_sliding_it_takes_coulomb_friction_at_the_rotor_and_all_of_the_guide() -> None:
    r = P.screw.lead / (2 * np.pi)
    wanted = P.screw.T_c + r * P.F_g
    omega = 60.0  # far above omega_s
    z, w = P.screw.T_c / P.screw.sigma_0, P.F_g / P.sigma_0g
    F = P.F_g / P.screw.K_n  # the joint's deflection that carries the guide
    x = State(axis.State(F / r, 0.0, omega, r * omega, z), w)
    u = (wanted + P.screw.C_sd * omega) / P.screw.K_m
    k = guided.derivative(x, Input(u), P)
    assert k.screw.omega == pytest.approx(0, abs=1e-6 * wanted / P.screw.J)
    assert k.screw.v == pytest.approx(0, abs=1e-9)
    assert k.w == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(("omega", "T"), [(1e-3, P.T_s), (-1e-3, -P.T_s), (60, 0.052)])
def test_crawling_the_rotor_s_bristle_holds_the_static_level(
    omega: float, T: float
) -> None:
    x = State(axis.State(omega=omega, z=T / P.screw.sigma_0))
    rate = guided.derivative(x, Input(0.0), P).screw.z
    assert rate == pytest.approx(0, abs=1e-6 * abs(omega))
