"""Linearise a model's own traced equations at a point.

    continuous   ẋ = A x + B u,   y = C x + D u
    sampled      x⁺ = A x + B u,  y = C x + D u      every T_s

The Jacobians are exact (CasADi, from the graph that becomes the FMU's C), never
finite differences.  A quantiser's slope is that of the graph: zero.
"""

from collections.abc import Iterable, Sequence

import casadi as ca
import control as ct
import numpy as np

from fmus.model import Continuous, FloatArray, Model, Record, leaves, pack, size
from fmus.trace import trace


def linearise(
    model: Model,
    *,
    parameters: Record | None = None,
    state: Record | None = None,
    input: Record | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
    T_s: float | None = None,
) -> ct.StateSpace:
    """Return a model's linearisation, with the names of its states and signals.

    Args:
        model: a continuous or sampled model.
        parameters, state, input: the point; the model's start values by default.
        inputs, outputs: which signals to keep, in this order (all by default);
            element j of an array signal is called ``name[j]``, from 1.
        T_s: sample time of a sampled model (s), its own period by default.

    Returns:
        State-space system, continuous or with ``dt = T_s``; states are called as
        in the FMU, ``state.x_1``.

    Raises:
        LookupError: the model has no signal of that name.
        ValueError: the model is a source, it has no input.
    """
    if not size(model.input):
        raise ValueError(f"{model.name} is a source: it has no input to linearise for")
    traced = trace(model)
    parameters = model.parameters if parameters is None else parameters
    state = model.state if state is None else state
    input = model.input if input is None else input
    continuous = isinstance(model, Continuous)
    period = 0.0
    if not isinstance(model, Continuous):
        period = float(model.period) if T_s is None else float(T_s)

    p = pack(parameters)
    d = np.ravel(traced.functions["prepare"](p, period).full())
    point: dict[str, FloatArray] = {"x": pack(state), "u": pack(input), "p": p, "d": d}
    if continuous:
        A, B = _jacobians(traced.functions["derivative"], "der_x", point)
        C, D = _jacobians(traced.functions["output"], "y", point)
    else:
        point["T_s"] = np.array([period])
        A, B = _jacobians(traced.functions["step"], "x_next", point)
        C, D = _jacobians(traced.functions["step"], "y", point)

    input_names = _names(model.input)
    output_names = _names(traced.output_like)
    columns = _select(input_names, inputs, f"input of {model.name}")
    rows = _select(output_names, outputs, f"output of {model.name}")
    return ct.ss(
        A,
        B[:, columns],
        C[rows, :],
        D[np.ix_(rows, columns)],
        *(() if continuous else (period,)),
        states=_names(model.state, "state."),
        inputs=[input_names[j] for j in columns],
        outputs=[output_names[i] for i in rows],
        name=model.name,
        remove_useless_states=False,
    )


def without_bystanders(system: ct.StateSpace) -> ct.StateSpace:
    """Drop the states that no input reaches or no output shows, by structure.

    Exact zeros decide, no tolerance: a part that is switched off goes, a mode that
    the numbers happen to cancel stays.
    """
    links = np.eye(system.nstates, dtype=bool) | (system.A != 0)
    for _ in range(system.nstates.bit_length()):
        links = links @ links
    reached = links @ np.any(system.B != 0, axis=1)
    shown = np.any(system.C != 0, axis=0) @ links
    (kept,) = np.nonzero(reached & shown)
    return ct.ss(
        system.A[np.ix_(kept, kept)],
        system.B[kept, :],
        system.C[:, kept],
        system.D,
        system.dt,
        states=[system.state_labels[i] for i in kept],
        inputs=system.input_labels,
        outputs=system.output_labels,
        name=system.name,
        remove_useless_states=False,
    )


def _jacobians(
    function: ca.Function, result: str, point: dict[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    wanted = [f"jac:{result}:x", f"jac:{result}:u"]
    jacobian = function.factory(f"{result}_jacobian", function.name_in(), wanted)
    by_x, by_u = jacobian(*(point[name] for name in function.name_in()))
    return by_x.full(), by_u.full()


def _names(record: Record, prefix: str = "") -> list[str]:
    names: list[str] = []
    for leaf in leaves(record, prefix):
        if np.ndim(leaf.value) == 0:
            names.append(leaf.name)
            continue
        indices = np.ndindex(np.shape(leaf.value))
        names += [f"{leaf.name}[{','.join(str(i + 1) for i in at)}]" for at in indices]
    return names


def _select(names: list[str], wanted: Iterable[str] | None, what: str) -> list[int]:
    if wanted is None:
        return list(range(len(names)))
    indices = []
    for name in wanted:
        if name not in names:
            raise LookupError(f"{what}: no {name!r}, there are {', '.join(names)}")
        indices.append(names.index(name))
    return indices
