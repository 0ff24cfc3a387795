"""Directional derivatives of a model, from its traced equations.

    tangent(x, u, p, d, T_s, dx, du) -> (d_der_x, d_y)

The change of the state derivatives (none for a sampled model) and outputs for a
change of states and inputs, at given parameters.  A comparison or sign does not
change.  A model that rounds (an encoder's counts) has no tangent: its derivative
is zero almost everywhere, and whoever asked would be misled.
"""

import casadi as ca

from fmus.trace import Traced

ROUNDING = {ca.OP_FLOOR, ca.OP_CEIL}


def tangent(traced: Traced) -> ca.Function | None:
    """Return the directional derivatives of derivative, output and step, if any."""
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
