"""What the whole cascades P/PI and NP/PI share: ports, memory, the speed loop.

One record of ports for both, so that one can take the other's place.
"""

from typing import Annotated, Any, NamedTuple

from controllers.filters._sections import LowPass
from controllers.xy_table import speed_pi, velocity_estimator
from fmus.model import Var


class State(NamedTuple):
    estimator: velocity_estimator.State = velocity_estimator.State()
    velocity: speed_pi.State = speed_pi.State()


class Input(NamedTuple):
    z_ref: Annotated[float, Var("mm", "position reference")] = 0.0
    y: Annotated[float, Var("mm", "position")] = 0.0
    v: Annotated[float, Var("mm/s", "measured velocity, if taken")] = 0.0
    g: Annotated[float, Var("1", "factor on k_v in gain tests")] = 1.0


class Output(NamedTuple):
    u: Annotated[float, Var("V", "control signal")]
    e: Annotated[float, Var("mm", "tracking error")]
    v_ref: Annotated[float, Var("mm/s", "velocity reference")]


def control(
    x: State, u: Input, e: Any, v_ref: Any, p: Any, T_s: float, d: LowPass
) -> tuple[State, Output]:
    """Run the estimator and the speed loop of the gains p.k_p, p.k_i."""
    x_est, estimate = velocity_estimator.step(
        x.estimator, velocity_estimator.Input(u.y, u.v), p.estimator, T_s, d
    )
    x_vel, speed = speed_pi.step(
        x.velocity,
        speed_pi.Input(v_ref, estimate.v_est),
        speed_pi.Parameters(p.k_p, p.k_i),
        T_s,
    )
    return State(x_est, x_vel), Output(speed.u, e, v_ref)
