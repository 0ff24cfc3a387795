"""One axis of a leadscrew mechanism: rotor, table, screw-nut joint, friction.

    J θ̈ = K_m i - T_fric(θ̇) - C_sd θ̇ - r F
    M ẍ = F,    F = K_n (r θ - x) + C_n (r θ̇ - ẋ),    r = lead / 2π
    |i| <= i_max,    |K_e θ̇ + R i| <= V

The amplifier gives the current u unless its own limit or the supply voltage stops
it.  T_fric is LuGre friction, so that the table springs back after a stop.
Source: Maeda 2007, fig. 2-3 and 2-4, table 2-1 (light payload); lead, R and the
presliding values are not published (docs/studies/leadscrew_nctf.md).
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Continuous, Var, add
from plants.leadscrew._lugre import TINY, bristle, slip


class State(NamedTuple):
    theta: Annotated[float, Var("rad", "rotor angle")] = 0.0
    x: Annotated[float, Var("m", "table position")] = 0.0
    omega: Annotated[float, Var("rad/s", "rotor speed")] = 0.0
    v: Annotated[float, Var("m/s", "table speed")] = 0.0
    z: Annotated[float, Var("rad", "bristle deflection", nominal=1e-4)] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("A", "current command")] = 0.0


class Output(NamedTuple):
    x: Annotated[float, Var("m", "table position")]
    v: Annotated[float, Var("m/s", "table speed")]
    omega: Annotated[float, Var("rad/s", "rotor speed")]
    i: Annotated[float, Var("A", "motor current")]


class Parameters(NamedTuple):
    J: Annotated[float, Var("kg.m2", "rotating inertia", min=1e-12)] = 1.81e-4
    K_m: Annotated[float, Var("N.m/A", "torque constant")] = 0.172
    M: Annotated[float, Var("kg", "mass of the table", min=1e-9)] = 3.57
    T_c: Annotated[float, Var("N.m", "Coulomb friction", min=0)] = 0.046
    C_sd: Annotated[float, Var("N.m.s/rad", "viscous friction", min=0)] = 9.7e-4
    sigma_0: Annotated[float, Var("N.m/rad", "presliding stiffness", min=1e-9)] = 107.0
    sigma_1: Annotated[float, Var("N.m.s/rad", "presliding damping", min=0)] = 0.03
    K_n: Annotated[float, Var("N/m", "stiffness of screw and nut", min=0)] = 8.3e7
    C_n: Annotated[float, Var("N.s/m", "damping of screw and nut", min=0)] = 1700.0
    lead: Annotated[float, Var("m", "lead of the screw", min=1e-9)] = 2e-3
    i_max: Annotated[float, Var("A", "current limit of the amplifier", min=0)] = 6.0
    V: Annotated[float, Var("V", "supply voltage", min=0)] = 45.0
    K_e: Annotated[float, Var("V.s/rad", "back-EMF constant", min=0)] = 0.086
    R: Annotated[float, Var("ohm", "effective resistance", min=1e-9)] = 4.05


def current(u: Any, omega: Any, p: Parameters) -> Any:
    """Return the motor current (A) that both limits leave of the command."""
    highest = np.minimum(p.i_max, (p.V - p.K_e * omega) / p.R)
    lowest = np.maximum(-p.i_max, (-p.V - p.K_e * omega) / p.R)
    return np.minimum(np.maximum(u, lowest), highest)


def accelerations(x: State, u: Input, p: Parameters) -> tuple[Any, Any]:
    """Return ω̇ and v̇."""
    r = p.lead / (2 * np.pi)
    F = p.K_n * (r * x.theta - x.x) + p.C_n * (r * x.omega - x.v)
    T_fric = p.sigma_0 * x.z + p.sigma_1 * rate(x, p)
    T_m = p.K_m * current(u.u, x.omega, p)
    return (T_m - T_fric - p.C_sd * x.omega - r * F) / p.J, F / p.M


def rate(x: State, p: Parameters) -> Any:
    """Return the rate of the bristle, ż (rad/s)."""
    return slip(x.z, x.omega, p.T_c, p.sigma_0) * x.omega


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return ẋ."""
    return State(x.omega, x.v, *accelerations(x, u, p), rate(x, p))


def advance(x: State, u: Input, p: Parameters, h: float) -> State:
    """Fourth order: one step up to the next kink of the equations, one from there."""
    smooth = up_to_kink(x, u, p, h)
    return along(along(x, u, p, smooth), u, p, h - smooth)


def up_to_kink(x: State, u: Input, p: Parameters, h: float) -> Any:
    """Return the part of h before the rotor reverses or meets the voltage limit."""
    alpha, _ = accelerations(x, u, p)
    return time_to_kink(x, u, alpha, p, h)


def time_to_kink(x: State, u: Input, alpha: Any, p: Parameters, h: Any) -> Any:
    """Return the same at a rotor's acceleration alpha (rad/s²)."""
    alpha = np.where(alpha == 0, TINY, alpha)
    drop = p.R * np.minimum(np.maximum(u.u, -p.i_max), p.i_max)
    K_e = np.maximum(p.K_e, TINY)
    part: Any = h
    for kink in (0.0, (p.V - drop) / K_e, (-p.V - drop) / K_e):
        t = (kink - x.omega) / alpha
        part = np.where(t > 0, np.minimum(t, part), part)
    return part


def along(x: State, u: Input, p: Parameters, h: Any) -> State:
    """Return the state h later by Runge-Kutta 4, z exact in the angle turned."""

    def ahead(h: Any, k: State) -> State:
        z = bristle(x.z, h * k.theta, p.T_c, p.sigma_0)
        return add(x, [(h, k)])._replace(z=z)

    k_1 = derivative(x, u, p)
    k_2 = derivative(ahead(h / 2, k_1), u, p)
    k_3 = derivative(ahead(h / 2, k_2), u, p)
    k_4 = derivative(ahead(h, k_3), u, p)
    stages = zip(k_1, k_2, k_3, k_4, strict=True)
    return ahead(h, State(*((a + 2 * b + 2 * c + d) / 6 for a, b, c, d in stages)))


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the table's motion, the rotor's speed and the current."""
    return Output(x.x, x.v, x.omega, current(u.u, x.omega, p))


model = Continuous(
    "Leadscrew",
    derivative,
    output,
    State(),
    Input(),
    Parameters(),
    advance=advance,
)
