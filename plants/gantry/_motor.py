"""What every linear motor of the gantry adds to the mass it moves.

    ḟ = ω_l (u - f)                    amplifier and motor
    f_r = A_r sin(2π y/λ_r + φ_r)      force ripple

Source: Gordon 2010, eq. 4.17: 130 Hz at 35° ask for 30.43° of lag that the mass,
the filters and the delay do not explain; as one pole it stands at 221.28 Hz.
The ripple is named in ch. 5 and not quantified; its numbers are our choice.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from fmus.model import Var


class Amplifier(NamedTuple):
    on: Annotated[bool, Var("1", "force lags behind the control signal")] = False
    omega_l_hz: Annotated[float, Var("Hz", "bandwidth", min=0)] = 221.28


class Ripple(NamedTuple):
    on: Annotated[bool, Var("1", "force ripples with the position")] = False
    A_r: Annotated[float, Var("V", "amplitude")] = 0.01
    lambda_r: Annotated[float, Var("m", "magnetic pitch", min=1e-9)] = 0.032
    phi_r: Annotated[float, Var("rad", "phase at zero")] = 0.0


def ripple(y: Any, p: Ripple) -> Any:
    """Return the ripple force (V) at the position y (m)."""
    wave = p.A_r * np.sin(2 * np.pi * y / p.lambda_r + p.phi_r)
    return np.where(p.on, wave, 0.0)
