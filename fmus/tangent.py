"""Directional derivatives of a model, from its traced equations.

    tangent(x, u, p, d, T_s, dx, du) -> (d_der_x, d_y)

The change of the state derivatives (none for a sampled model) and outputs for a
change of states and inputs, at given parameters.  A comparison or sign does not
change.  A model that rounds (an encoder's counts) has no tangent: its derivative
is zero almost everywhere, and whoever asked would be misled.  Nor has one that
starts on a kink, where the slopes of its outputs are not what differences show.
"""

import casadi as ca
import numpy as np

from fmus.model import Model, Sampled, pack
from fmus.trace import Traced

DELTA = 1e-6  # of an input
ROUNDING = {ca.OP_FLOOR, ca.OP_CEIL}


def tangent(model: Model, traced: Traced) -> ca.Function | None:
    """Return the directional derivatives of derivative, output and step, if any."""
    found = _tangent(traced)
    if found is None or not _shows_differences(model, traced, found):
        return None
    return found


def _tangent(traced: Traced) -> ca.Function | None:
    functions = traced.functions
    names = ["derivative", "output"] if "derivative" in functions else ["step"]
    if any(_rounds(functions[name]) for name in names):
        return None
    first = functions[names[0]]
    arguments = dict(zip(first.name_in(), first.sx_in(), strict=True))
    arguments.setdefault("T_s", ca.SX.sym("T_s"))
    place = ca.vertcat(arguments["x"], arguments["u"])
    change = {n: ca.SX.sym(f"d{n}", arguments[n].numel()) for n in ("x", "u")}
    seed = ca.vertcat(*change.values())

    def along(function: ca.Function, result: str) -> ca.SX:
        values = function.call([arguments[name] for name in function.name_in()])
        return ca.jtimes(values[function.index_out(result)], place, seed)

    if names == ["step"]:
        results = [ca.SX(0, 1), along(first, "y")]
    else:
        results = [along(first, "der_x"), along(functions["output"], "y")]
    inputs = [arguments[name] for name in ("x", "u", "p", "d", "T_s")]
    return ca.Function(
        "tangent",
        [*inputs, *change.values()],
        ca.cse([ca.densify(result) for result in results]),
        ["x", "u", "p", "d", "T_s", "dx", "du"],
        ["d_der_x", "d_y"],
    )


def _rounds(function: ca.Function) -> bool:
    operations = map(function.instruction_id, range(function.n_instructions()))
    return not ROUNDING.isdisjoint(operations)


def _shows_differences(model: Model, traced: Traced, found: ca.Function) -> bool:
    """Compare slopes by the inputs with central differences at the start values."""
    functions = traced.functions
    x, u, p = map(pack, (model.state, model.input, model.parameters))
    T_s = [float(model.period)] if isinstance(model, Sampled) else []
    d = functions["prepare"](p, *(T_s or [0.0]))
    equation = functions["step" if T_s else "output"]
    for i in range(u.size):
        delta = np.zeros(u.size)
        delta[i] = DELTA * max(1.0, abs(u[i]))
        sides = [equation.call([x, u + s * delta, p, d, *T_s])[-1] for s in (1, -1)]
        above, below = (np.ravel(ca.DM(side).full()) for side in sides)
        slope = (above - below) / (2 * delta[i])
        told = found(x, u, p, d, *(T_s or [0.0]), 0 * x, delta / delta[i])[1]
        allowed = 1e-3 * np.abs(slope) + 1e-6 + 1e-14 * np.abs(above) / delta[i]
        error = np.abs(np.ravel(ca.DM(told).full()) - slope)
        if not (error <= allowed).all():  # nor is NaN a slope
            return False
    return True
