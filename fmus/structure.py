"""Which unknown depends on which known, read from the traced graph.

Unknowns are outputs and state derivatives, knowns are named by value reference
as well.  While stepping the knowns are inputs and continuous states; in
initialisation also parameters and discrete states (FMI 2.0.5 section 2.2.8).
"""

from collections.abc import Mapping
from typing import Literal, TypeAlias

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from fmus.layout import Block, Layout
from fmus.trace import Traced, dependencies

Kind: TypeAlias = Literal["constant", "fixed", "tunable", "dependent"]
Structure: TypeAlias = Mapping[int, Mapping[int, Kind]]
STRENGTH: tuple[Kind, ...] = ("constant", "fixed", "tunable", "dependent")

# Their derivative is zero though the value changes: a Jacobian misses them.
STEPS = {
    ca.OP_FLOOR,
    ca.OP_CEIL,
    ca.OP_SIGN,
    ca.OP_LT,
    ca.OP_LE,
    ca.OP_EQ,
    ca.OP_NE,
    ca.OP_NOT,
    ca.OP_AND,
    ca.OP_OR,
}


def stepping(traced: Traced, layout: Layout) -> Structure:
    """Return the dependencies at communication points and between them.

    A known that enters linearly says what its factor depends on.
    """
    continuous = "derivative" in traced.functions
    knowns: dict[str, Block] = {"u": "input"}
    if continuous:
        knowns = {"x": "state", "u": "input"}
    table: dict[int, dict[int, Kind]] = {}
    for function, result, unknown in _unknowns(traced):
        for argument, known in knowns.items():
            kinds = _kinds(function, result, argument, layout)
            _enter(table, kinds, layout.offset[unknown], layout.offset[known])
    return _sorted(table)


def initial(traced: Traced, layout: Layout) -> Structure:
    """Return the dependencies in initialisation, all of no particular kind."""
    knowns: dict[str, Block] = {"p": "parameter", "u": "input", "x": "state"}
    prepare = _pattern(traced.functions["prepare"], "d", "p")
    table: dict[int, dict[int, Kind]] = {}
    for function, result, unknown in _unknowns(traced):
        for argument, known in knowns.items():
            pattern = _pattern(function, result, argument)
            if argument == "p":
                pattern = pattern | (_pattern(function, result, "d") @ prepare)
            kinds = {(int(i), int(j)): "dependent" for i, j in np.argwhere(pattern)}
            _enter(table, kinds, layout.offset[unknown], layout.offset[known])
    return _sorted(table)


def strongest(kinds: set[Kind]) -> Kind:
    """Return the kind that holds for all: the one that promises least."""
    return max(kinds, key=STRENGTH.index)


def _unknowns(traced: Traced) -> list[tuple[ca.Function, str, Block]]:
    functions = traced.functions
    if "derivative" not in functions:
        return [(functions["step"], "y", "output")]
    return [
        (functions["output"], "y", "output"),
        (functions["derivative"], "der_x", "derivative"),
    ]


def _enter(
    table: dict[int, dict[int, Kind]],
    kinds: Mapping[tuple[int, int], Kind] | Mapping[tuple[int, int], str],
    unknown: int,
    known: int,
) -> None:
    for (i, j), kind in kinds.items():
        table.setdefault(unknown + i, {})[known + j] = kind  # type: ignore[assignment]


def _sorted(table: dict[int, dict[int, Kind]]) -> Structure:
    return {unknown: dict(sorted(row.items())) for unknown, row in table.items()}


def _pattern(function: ca.Function, result: str, argument: str) -> NDArray[np.bool_]:
    sparsity = dependencies(function, result, argument)
    pattern = np.zeros(sparsity.shape, dtype=bool)
    rows, columns = sparsity.get_triplet()
    pattern[rows, columns] = True
    return pattern


def _kinds(
    function: ca.Function, result: str, argument: str, layout: Layout
) -> dict[tuple[int, int], Kind]:
    """Classify each structural entry of d result / d argument."""
    pattern = _pattern(function, result, argument)
    entries = [(int(i), int(j)) for i, j in np.argwhere(pattern)]
    operations = (function.instruction_id(i) for i in range(function.n_instructions()))
    if not entries or any(operation in STEPS for operation in operations):
        return dict.fromkeys(entries, "dependent")
    arguments = function.sx_in()
    results = function.call(arguments)
    y = results[function.index_out(result)]
    jacobian = ca.jacobian(y, arguments[function.index_in(argument)])
    factors = ca.vertcat(*(jacobian[i, j] for i, j in entries))
    factor = ca.Function(
        "factor", arguments, [ca.densify(factors)], function.name_in(), ["f"]
    )
    varies = {name: _pattern(factor, "f", name) for name in ("x", "u", "p", "d")}
    tunable, fixed = _parameters(layout)
    kinds: dict[tuple[int, int], Kind] = {}
    for row, entry in enumerate(entries):
        if varies["x"][row].any() or varies["u"][row].any():
            kinds[entry] = "dependent"
        elif varies["d"][row].any() or varies["p"][row][tunable].any():
            kinds[entry] = "tunable"
        else:
            kinds[entry] = "fixed" if varies["p"][row][fixed].any() else "constant"
    return kinds


def _parameters(layout: Layout) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return masks over p: what may change while stepping, and what may not."""
    parameters = layout.block("parameter")
    fixed = [v.var.fixed for v in parameters for _ in range(v.size)]
    mask = np.array(fixed, dtype=bool)
    return ~mask, mask
