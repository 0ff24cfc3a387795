"""A state-space filter with arrays, a nested record and a bank it sums.

    x⁺ = A x + B u,  y = C x,  gate as a switch

Source: any textbook (2026).
"""

from fractions import Fraction
from typing import Annotated, NamedTuple

import numpy as np

from fmus.model import FloatArray, Sampled, Var


class Bank(NamedTuple):
    w: Annotated[FloatArray, Var("V", "filter states")] = np.array([0.1, -0.2])


class State(NamedTuple):
    bank: Bank = Bank()
    k: Annotated[float, Var("1", "ticks so far")] = 0.0


class Input(NamedTuple):
    u: Annotated[FloatArray, Var("V", "two voltages")] = np.zeros(2)


class Output(NamedTuple):
    y: Annotated[FloatArray, Var("V", "filtered voltages")]
    passed: Annotated[float, Var("V", "first voltage as it came in")]


class Gains(NamedTuple):
    A: Annotated[FloatArray, Var("1", "system matrix", fixed=True)] = np.array(
        [[0.9, 0.05], [-0.1, 0.8]]
    )
    B: Annotated[FloatArray, Var("1", "input gains")] = np.array([0.5, 0.25])


class Parameters(NamedTuple):
    gains: Gains = Gains()
    gate: Annotated[bool, Var("1", "let the first voltage pass")] = True


def step(x: State, u: Input, p: Parameters, T_s: float) -> tuple[State, Output]:
    w = p.gains.A @ x.bank.w + p.gains.B * u.u
    passed = np.where(p.gate, u.u[0], 0.0)
    return State(Bank(w), x.k + 1), Output(x.bank.w, passed)


model = Sampled(
    "Matrices", step, State(), Input(), Parameters(), period=Fraction(1, 1000)
)
