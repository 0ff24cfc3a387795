"""Small models: continuous and sampled, with arrays, dead time, ``advance``."""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Model, Sampled, Var


class ShaftState(NamedTuple):
    theta_m: Annotated[float, Var("rad", "motor angle")] = 0.1
    omega_m: Annotated[float, Var("rad/s", "motor speed")] = 0.0
    theta_l: Annotated[float, Var("rad", "load angle")] = 0.0
    omega_l: Annotated[float, Var("rad/s", "load speed", nominal=10.0)] = 0.0


class ShaftInput(NamedTuple):
    tau: Annotated[float, Var("N.m", "motor torque")] = 0.5
    d: Annotated[float, Var("N.m", "disturbance")] = 0.0


class ShaftOutput(NamedTuple):
    omega: Annotated[float, Var("rad/s", "speeds")]
    felt: Annotated[float, Var("N.m", "torque in shaft and motor")]


class ShaftParameters(NamedTuple):
    J_m: Annotated[float, Var("kg.m2", "motor inertia")] = 2e-3
    J_l: Annotated[float, Var("kg.m2", "load inertia", fixed=True)] = 1.5e-3
    K: Annotated[float, Var("N.m/rad", "stiffness")] = 700.0
    C: Annotated[float, Var("N.m.s/rad", "damping", constant=True)] = 0.05
    T_c: Annotated[float, Var("N.m", "Coulomb friction")] = 0.3
    friction: Annotated[bool, Var("1", "friction acts")] = True


def shaft_derivative(x: ShaftState, u: ShaftInput, p: ShaftParameters) -> ShaftState:
    tau_s = p.K * (x.theta_m - x.theta_l) + p.C * (x.omega_m - x.omega_l)
    friction = p.friction * p.T_c * np.tanh(x.omega_l / 0.5)
    return ShaftState(
        x.omega_m, (u.tau - tau_s) / p.J_m, x.omega_l, (tau_s - friction - u.d) / p.J_l
    )


def shaft_output(x: ShaftState, u: ShaftInput, p: ShaftParameters) -> ShaftOutput:
    return ShaftOutput(x.omega_m - x.omega_l, p.K * (x.theta_m - x.theta_l) + u.tau)


class PiState(NamedTuple):
    q: Annotated[float, Var("N.m", "integral")] = 0.25
    k: Annotated[float, Var("1", "tick")] = 0.0


class PiInput(NamedTuple):
    r: Annotated[float, Var("rad/s", "reference")] = 0.0
    y: Annotated[float, Var("rad/s", "measured")] = 0.0


class PiOutput(NamedTuple):
    u: Annotated[float, Var("N.m", "torque")]
    ticks: Annotated[float, Var("1", "ticks run, this one included")]


class PiParameters(NamedTuple):
    K_p: Annotated[float, Var("N.m.s/rad", "gain")] = 0.5
    T_i: Annotated[float, Var("s", "reset time")] = 0.025


class PiDerived(NamedTuple):
    K_i: float


def pi_prepare(p: PiParameters, T_s: float) -> PiDerived:
    return PiDerived(p.K_p * T_s / p.T_i)


def pi_step(
    x: PiState, u: PiInput, p: PiParameters, T_s: float, d: PiDerived
) -> tuple[PiState, PiOutput]:
    e = u.r - u.y
    return PiState(x.q + d.K_i * e, x.k + 1), PiOutput(p.K_p * e + x.q, x.k + 1)


class MixState(NamedTuple):
    s: Annotated[Any, Var("1", "sums")] = np.array([1.0, -1.0])


class MixInput(NamedTuple):
    u: Annotated[Any, Var("1", "inputs")] = np.array([0.0, 0.0, 0.0])
    v: Annotated[float, Var("1", "another")] = 2.0


class MixOutput(NamedTuple):
    y: Annotated[Any, Var("1", "outputs")]
    z: Annotated[float, Var("1", "another")]


class MixParameters(NamedTuple):
    K: Annotated[Any, Var("1", "gains")] = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])


def mix_step(
    x: MixState, u: MixInput, p: MixParameters, T_s: float
) -> tuple[MixState, MixOutput]:
    y = p.K @ u.u + x.s
    return MixState(x.s + u.v * T_s), MixOutput(y, u.v + p.K[1, 0])


class OneState(NamedTuple):
    x: Annotated[float, Var("1", "state")] = 1.0


class OneInput(NamedTuple):
    u: Annotated[float, Var("1", "input")] = 0.0


class OneOutput(NamedTuple):
    y: Annotated[float, Var("1", "output")]


class OneParameters(NamedTuple):
    a: Annotated[float, Var("1/s", "rate")] = 300.0


def one_derivative(x: OneState, u: OneInput, p: OneParameters) -> OneState:
    return OneState(p.a * (u.u - x.x))


def one_advance(x: OneState, u: OneInput, p: OneParameters, h: float) -> OneState:
    return OneState(u.u + (x.x - u.u) * np.exp(-p.a * h))


def one_output(x: OneState, u: OneInput, p: OneParameters) -> OneOutput:
    return OneOutput(x.x + u.u)


def explode(x: OneState, u: OneInput, p: OneParameters) -> OneState:
    return OneState(p.a * x.x**2 + u.u)


def count(x: OneState, u: OneInput, p: OneParameters, h: float) -> OneState:
    return OneState(x.x + 1)


class LateState(NamedTuple):
    x: Annotated[Any, Var("1", "integrals")] = np.array([0.0, 0.0])
    w: Annotated[float, Var("1", "double integral")] = 0.0


class LateInput(NamedTuple):
    u: Annotated[Any, Var("1", "delayed")] = np.array([0.0, 0.0])
    v: Annotated[float, Var("1", "not delayed")] = 0.0


class LateOutput(NamedTuple):
    y: Annotated[Any, Var("1", "delayed inputs")]


class LateParameters(NamedTuple):
    tau: Annotated[float, Var("s", "dead time")] = 3.3e-4


def late_derivative(x: LateState, u: LateInput, p: LateParameters) -> LateState:
    return LateState(u.u + u.v, x.x[0])


def late_output(x: LateState, u: LateInput, p: LateParameters) -> LateOutput:
    return LateOutput(u.u)


SHAFT = Continuous(
    "Shaft",
    shaft_derivative,
    shaft_output,
    ShaftState(),
    ShaftInput(),
    ShaftParameters(),
)
PI = Sampled(
    "Pi", pi_step, PiState(), PiInput(), PiParameters(), Fraction(1, 20_000), pi_prepare
)
ONE = (OneState(), OneInput(), OneParameters())
MODELS: dict[str, Model] = {
    "shaft": SHAFT,
    "pi": PI,
    "third": Sampled(
        "Third",
        pi_step,
        *(PI.state, PI.input, PI.parameters),
        Fraction(1, 3000),
        pi_prepare,
    ),
    "mix": Sampled("Mix", mix_step, MixState(), MixInput(), MixParameters()),
    "exact": Continuous(
        "Exact", one_derivative, one_output, *ONE, advance=one_advance, h_max=1e-3
    ),
    "explosive": Continuous("Explosive", explode, one_output, *ONE, h_max=1e-3),
    "counter": Continuous("Counter", one_derivative, one_output, *ONE, advance=count),
    "late": Continuous(
        "Late",
        late_derivative,
        late_output,
        LateState(),
        LateInput(),
        LateParameters(),
        delay={"u": "tau"},
    ),
}
