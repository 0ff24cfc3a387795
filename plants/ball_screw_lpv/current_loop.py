"""Motor winding under its PI current controller.

    L_m i̇ = k_cp (k_a v_m - i) + k_ci q - R_m i - k_emf θ̇,     q̇ = k_a v_m - i
    τ_m = k_t i

Source: Hanifzadegan 2014, eq. 3.6 and 3.7, Table 3.1 (k_cp, k_ci printed there as
k_ap, k_ai); the feedback of the current, left out of (3.6), is in (3.7).
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    i: Annotated[float, Var("A", "motor current")] = 0.0
    q: Annotated[float, Var("A.s", "integral of the current error", nominal=1e-3)] = 0.0


class Input(NamedTuple):
    v_m: Annotated[float, Var("V", "command to the amplifier")] = 0.0
    omega: Annotated[float, Var("rad/s", "motor speed")] = 0.0


class Output(NamedTuple):
    i: Annotated[float, Var("A", "motor current")]
    tau_m: Annotated[float, Var("N.m", "motor torque")]


class Parameters(NamedTuple):
    L_m: Annotated[float, Var("H", "inductance", min=1e-9)] = 0.0375
    R_m: Annotated[float, Var("V/A", "resistance", min=0)] = 6.5
    k_a: Annotated[float, Var("A/V", "gain of the amplifier", min=0)] = 0.887
    k_cp: Annotated[float, Var("V/A", "proportional gain", min=0)] = 111.55
    k_ci: Annotated[float, Var("V/(A.s)", "integral gain", min=0)] = 3.0019e5
    k_emf: Annotated[float, Var("V.s/rad", "back-EMF constant", min=0)] = 0.4173
    k_t: Annotated[float, Var("N.m/A", "torque constant")] = 0.72


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ (eq. 3.6 with the current fed back)."""
    e = p.k_a * u.v_m - x.i
    v = p.k_cp * e + p.k_ci * x.q
    return State((v - p.R_m * x.i - p.k_emf * u.omega) / p.L_m, e)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return current and torque."""
    return Output(x.i, p.k_t * x.i)


model = Continuous(
    "CurrentLoop", derivative, output, State(), Input(), Parameters(), h_max=2e-5
)
