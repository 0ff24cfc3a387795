"""The linearisation of a model's own traced equations at a point, as matrices.

    continuous   ẋ = A x + B u,   y = C x + D u
    sampled      x⁺ = A x + B u,  y = C x + D u      every T_s

The Jacobians are exact (CasADi, from the graph that becomes the FMU's C), never
finite differences.  A quantiser's slope is that of the graph, zero, or of the line
through the middle of its steps, one, where it is asked for without its steps.
"""

from typing import NamedTuple

import casadi as ca
import numpy as np

from fmus.model import Continuous, FloatArray, Model
from fmus.trace import Traced, numpy_on_symbols, trace


class Jacobians(NamedTuple):
    """A (n, n), B (n, m), C (p, n), D (p, m) in the order of ``fmus.model.pack``."""

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray


def jacobians(
    model: Model,
    p: FloatArray,
    x: FloatArray,
    u: FloatArray,
    T_s: float = 0.0,
    *,
    traced: Traced | None = None,
    without_steps: bool = False,
) -> Jacobians:
    """Return a model's linearisation at packed parameters, state and input.

    ``T_s`` is the sample time (s) of a sampled model; ``without_steps`` takes every
    rounding ⌊v + 1/2⌋ for v; ``traced`` saves tracing again.
    """
    functions = (traced or trace(model)).functions
    d = np.ravel(functions["prepare"](p, T_s).full())
    point: dict[str, FloatArray] = {"x": x, "u": u, "p": p, "d": d}
    point["T_s"] = np.array([T_s])
    continuous = isinstance(model, Continuous)
    changes = ("derivative", "der_x") if continuous else ("step", "x_next")
    outputs = ("output", "y") if continuous else ("step", "y")
    found: list[FloatArray] = []
    for name, result in (changes, outputs):
        function = functions[name]
        function = _without_steps(function) if without_steps else function
        found += _of_one(function, result, point)
    return Jacobians(*found)


def _of_one(
    function: ca.Function, result: str, point: dict[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    wanted = [f"jac:{result}:x", f"jac:{result}:u"]
    jacobian = function.factory(f"{result}_jacobian", function.name_in(), wanted)
    by_x, by_u = jacobian(*(point[name] for name in function.name_in()))
    return by_x.full(), by_u.full()


def _without_steps(function: ca.Function) -> ca.Function:
    """Return a function in which every ⌊v + 1/2⌋ is v."""
    count = function.n_instructions()
    codes = [function.instruction_id(i) for i in range(count)]
    if ca.OP_FLOOR not in codes:
        return function
    work: dict[int, ca.SX] = {}
    rounded: dict[int, ca.SX] = {}  # by place: v, where v + 1/2 stands there
    inputs = [
        ca.SX.sym(name, function.sparsity_in(i))
        for i, name in enumerate(function.name_in())
    ]
    outputs = [ca.SX.zeros(*function.size_out(i)) for i in range(function.n_out())]
    with numpy_on_symbols():
        for i, code in enumerate(codes):
            to = function.instruction_output(i)
            of = function.instruction_input(i)
            if code == ca.OP_OUTPUT:
                outputs[to[0]][to[1]] = work[of[0]]
                continue
            before = None
            if code == ca.OP_INPUT:
                value = inputs[of[0]].nz[of[1]]
            elif code == ca.OP_CONST:
                value = ca.SX(function.instruction_constant(i))
            elif code == ca.OP_FLOOR and of[0] in rounded:
                value = rounded[of[0]]
            elif len(of) == 1:
                value = ca.SX.unary(code, work[of[0]])
            else:
                value = ca.SX.binary(code, work[of[0]], work[of[1]])
                before = _before_half(code, work[of[0]], work[of[1]])
            work[to[0]] = value
            rounded.pop(to[0], None)
            if before is not None:
                rounded[to[0]] = before
    names = function.name_in(), function.name_out()
    return ca.Function(function.name(), inputs, outputs, *names)


def _before_half(code: int, one: ca.SX, other: ca.SX) -> ca.SX | None:
    if code != ca.OP_ADD:
        return None
    for half, value in ((one, other), (other, one)):
        if half.is_constant() and float(half) == 0.5:
            return value
    return None
