"""Filter pack h(s) of either gantry motor, feed-forward added after it.

    u_i = h v_i + u_ff,i
    h = LP_450 · Lead_154 · ∏ (s² + 2ζ_N ω_N s + ω_N²)/(s² + 2ζ_D ω_N s + ω_N²)

LP is of second order; the lead gives φ_lead at ω_lead and has unit gain at zero
frequency.  Pole-zero matched.
Source: Gordon 2010, sec. 4.4.2; damping of the low-pass (1/√2) and the lead's
gain are our reading.
"""

from fractions import Fraction
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.filters._sections import (
    First,
    Section,
    filtered,
    lead,
    led,
    notch,
    second_order_low_pass,
)
from fmus.model import Sampled, Var


class Memory(NamedTuple):
    """Of one motor's filters."""

    w_11: Annotated[float, Var("V", "first memory of the first notch")] = 0.0
    w_12: Annotated[float, Var("V", "second memory of the first notch")] = 0.0
    w_21: Annotated[float, Var("V", "first memory of the second notch")] = 0.0
    w_22: Annotated[float, Var("V", "second memory of the second notch")] = 0.0
    w_31: Annotated[float, Var("V", "first memory of the third notch")] = 0.0
    w_32: Annotated[float, Var("V", "second memory of the third notch")] = 0.0
    w_41: Annotated[float, Var("V", "first memory of the fourth notch")] = 0.0
    w_42: Annotated[float, Var("V", "second memory of the fourth notch")] = 0.0
    w_51: Annotated[float, Var("V", "first memory of the low-pass")] = 0.0
    w_52: Annotated[float, Var("V", "second memory of the low-pass")] = 0.0
    w_lead: Annotated[float, Var("V", "memory of the lead")] = 0.0


class State(NamedTuple):
    left: Memory = Memory()
    right: Memory = Memory()


class Input(NamedTuple):
    v_1: Annotated[float, Var("V", "feedback signal of the left motor")] = 0.0
    v_2: Annotated[float, Var("V", "feedback signal of the right motor")] = 0.0
    u_ff1: Annotated[float, Var("V", "feed-forward of the left motor")] = 0.0
    u_ff2: Annotated[float, Var("V", "feed-forward of the right motor")] = 0.0


class Output(NamedTuple):
    u_1: Annotated[float, Var("V", "control signal of the left motor")]
    u_2: Annotated[float, Var("V", "control signal of the right motor")]


class Parameters(NamedTuple):
    omega_N1_hz: Annotated[float, Var("Hz", "first notch", min=0)] = 110.0
    zeta_N1: Annotated[float, Var("1", "damping of its zeros", min=0)] = 0.5
    zeta_D1: Annotated[float, Var("1", "damping of its poles", min=0)] = 0.7
    omega_N2_hz: Annotated[float, Var("Hz", "second notch", min=0)] = 320.0
    zeta_N2: Annotated[float, Var("1", "damping of its zeros", min=0)] = 0.2
    zeta_D2: Annotated[float, Var("1", "damping of its poles", min=0)] = 0.9
    omega_N3_hz: Annotated[float, Var("Hz", "third notch", min=0)] = 400.0
    zeta_N3: Annotated[float, Var("1", "damping of its zeros", min=0)] = 0.15
    zeta_D3: Annotated[float, Var("1", "damping of its poles", min=0)] = 1.0
    omega_N4_hz: Annotated[float, Var("Hz", "fourth notch", min=0)] = 940.0
    zeta_N4: Annotated[float, Var("1", "damping of its zeros", min=0)] = 0.6
    zeta_D4: Annotated[float, Var("1", "damping of its poles", min=0)] = 0.75
    omega_lpf_hz: Annotated[float, Var("Hz", "low-pass", min=0)] = 450.0
    zeta_lpf: Annotated[float, Var("1", "its damping ratio", min=0)] = np.sqrt(0.5)
    lead_on: Annotated[bool, Var("1", "lead is in the pack")] = True
    omega_lead_hz: Annotated[float, Var("Hz", "lead, largest phase", min=0)] = 154.0
    phi_lead: Annotated[float, Var("rad", "its phase there", min=0, max=1.57)] = (
        np.deg2rad(70)
    )


class Derived(NamedTuple):
    notch_1: Section
    notch_2: Section
    notch_3: Section
    notch_4: Section
    lpf: Section
    lead: First


def prepare(p: Parameters, T_s: float) -> Derived:
    """Match the six sections at the sample time."""
    gamma = np.sqrt((1 + np.sin(p.phi_lead)) / (1 - np.sin(p.phi_lead)))
    omega = 2 * np.pi * p.omega_lead_hz
    section = lead(omega / gamma, omega * gamma, T_s)
    return Derived(
        notch(p.omega_N1_hz, p.zeta_N1, p.zeta_D1, T_s),
        notch(p.omega_N2_hz, p.zeta_N2, p.zeta_D2, T_s),
        notch(p.omega_N3_hz, p.zeta_N3, p.zeta_D3, T_s),
        notch(p.omega_N4_hz, p.zeta_N4, p.zeta_D4, T_s),
        second_order_low_pass(2 * np.pi * p.omega_lpf_hz, p.zeta_lpf, T_s),
        # off: a section that lets everything through
        First(
            np.where(p.lead_on, section.b_0, 1.0),
            np.where(p.lead_on, section.b_1, 0.0),
            np.where(p.lead_on, section.p, 0.0),
        ),
    )


def step(
    x: State, u: Input, p: Parameters, T_s: float, d: Derived
) -> tuple[State, Output]:
    """Filter both feedback signals and add the feed-forward."""
    left, v_1 = pack(x.left, u.v_1, d)
    right, v_2 = pack(x.right, u.v_2, d)
    return State(left, right), Output(v_1 + u.u_ff1, v_2 + u.u_ff2)


def pack(x: Memory, v: Any, d: Derived) -> tuple[Memory, Any]:
    """Run one sample of one motor through the sections."""
    w_11, w_12, v = filtered(x.w_11, x.w_12, v, d.notch_1)
    w_21, w_22, v = filtered(x.w_21, x.w_22, v, d.notch_2)
    w_31, w_32, v = filtered(x.w_31, x.w_32, v, d.notch_3)
    w_41, w_42, v = filtered(x.w_41, x.w_42, v, d.notch_4)
    w_51, w_52, v = filtered(x.w_51, x.w_52, v, d.lpf)
    w_lead, v = led(x.w_lead, v, d.lead)
    memory = Memory(w_11, w_12, w_21, w_22, w_31, w_32, w_41, w_42, w_51, w_52, w_lead)
    return memory, v


model = Sampled(
    "GantryFilters",
    step,
    State(),
    Input(),
    Parameters(),
    period=Fraction(1, 15_000),
    prepare=prepare,
)
