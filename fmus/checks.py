"""What is refused of a model before an FMU is made of it."""

import re
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np

from fmus.layout import Block, Layout
from fmus.load import BuildError
from fmus.model import (
    Continuous,
    FloatArray,
    Model,
    Record,
    Sampled,
    is_record,
    leaves,
    pack,
    unpack,
)
from fmus.simulation import derived
from fmus.trace import Traced

IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
LONGEST_TUNABLE = 64
POINTS = 3
AGREEMENT = 1e-6  # of the largest result: far above rounding, far below a mistake


def check_model(model: Model) -> None:
    """Refuse what would only fail in C or in the importer.

    Raises:
        BuildError: name, period, substep, a field or a delay is not usable.
    """
    if not isinstance(model.name, str) or not IDENTIFIER.fullmatch(model.name):
        raise BuildError(f"model name {model.name!r} is no C identifier")
    if isinstance(model, Sampled):
        _check_period(model)
    elif not 0 < model.h_max < np.inf:
        raise BuildError(f"{model.name}: h_max = {model.h_max} s is no substep")
    for role in ("state", "input", "parameters"):
        _check_record(model.name, role, getattr(model, role))
    try:
        for record in (model.state, model.input, model.parameters):
            tuple(leaves(record))
    except TypeError as error:
        raise BuildError(f"{model.name}: {error}") from error
    _check_arrays(model)
    if isinstance(model, Continuous):
        _check_delay(model)


def _check_period(model: Sampled) -> None:
    exact = isinstance(model.period, Fraction | int)
    num, den = model.period.as_integer_ratio() if exact else (0, 1)
    if num <= 0 or max(num, den) >= 2**53:
        raise BuildError(
            f"{model.name}: period = {model.period!r} is no sample time; write it in "
            f"seconds as period=Fraction(1, 1000)"
        )


def _check_record(name: str, role: str, record: Any) -> None:
    if is_record(record):
        return
    if isinstance(record, type) and hasattr(record, "_fields"):
        raise BuildError(
            f"{name}: {role} is the class {record.__name__}; give the start values, "
            f"{record.__name__}()"
        )
    kind = record if isinstance(record, type) else type(record)
    raise BuildError(
        f"{name}: {role} is a {kind.__name__}, which is no NamedTuple; write "
        f"class {role.capitalize()}(NamedTuple): and give {role.capitalize()}()"
    )


def _check_arrays(model: Model) -> None:
    for leaf in leaves(model.parameters):
        n, frozen = np.size(leaf.value), leaf.var.fixed or leaf.var.constant
        if n > LONGEST_TUNABLE and not frozen:
            raise BuildError(
                f"{model.name}: {leaf.name} has {n} elements; over "
                f"{LONGEST_TUNABLE}, declare it Var(..., fixed=True) or constant=True"
            )


def _check_delay(model: Continuous) -> None:
    inputs = {leaf.name for leaf in leaves(model.input)}
    parameters = leaves(model.parameters)
    scalars = {leaf.name for leaf in parameters if not np.ndim(leaf.value)}
    for delayed, dead_time in model.delay.items():
        if delayed not in inputs or dead_time not in scalars:
            raise BuildError(
                f"{model.name}: delay {delayed!r}: {dead_time!r} must name an input "
                f"and a scalar parameter"
            )


def check_traced(model: Model, traced: Traced, layout: Layout) -> None:
    """Compare traced and NumPy equations near the start values.

    NumPy and CasADi disagree silently on a few things, such as a matrix times a
    vector by broadcasting.

    Raises:
        BuildError: a result differs by more than rounding.
    """
    random = np.random.default_rng(0)

    def near(record: Record) -> Record:
        start = pack(record)
        reach = np.where(start == 0, 0.1, 0.1 * np.abs(start))
        return unpack(record, start + reach * random.normal(size=start.size))

    for _ in range(POINTS):
        x, u = near(model.state), near(model.input)
        for block, numpy, casadi in _results(model, traced, x, u):
            names = [n for v in layout.block(block) for n, _ in v.elements()]
            scale = np.max(np.abs(numpy), initial=1e-300, where=np.isfinite(numpy))
            wrong = np.abs(numpy - casadi) > AGREEMENT * scale
            if wrong.any():
                i = int(np.argmax(wrong))
                raise BuildError(
                    f"{model.name}: traced, {names[i]} = {casadi[i]:.6g}, but NumPy "
                    f"gives {numpy[i]:.6g}: write A @ x for a matrix times a vector, "
                    f"and K[0, :] for a row"
                )


def _results(
    model: Model, traced: Traced, x: Record, u: Record
) -> Iterator[tuple[Block, FloatArray, FloatArray]]:
    """Yield block, result of NumPy and of the trace, at the start parameters."""
    p, functions = model.parameters, traced.functions
    with np.errstate(all="ignore"):
        d = derived(model, p)
        vectors = [pack(x), pack(u), pack(p), pack(d[0]) if d else np.zeros(0)]
        if isinstance(model, Continuous):
            pairs: list[tuple[Block, Record, Any]] = [
                ("output", model.output(x, u, p, *d), functions["output"]),
                ("derivative", model.derivative(x, u, p, *d), functions["derivative"]),
            ]
            for block, record, function in pairs:
                yield block, pack(record), np.ravel(function(*vectors).full())
            return
        T_s = float(model.period)
        x_next, y = model.step(x, u, p, T_s, *d)
        traced_next, traced_y = functions["step"](*vectors, T_s)
        yield "state", pack(x_next), np.ravel(traced_next.full())
        yield "output", pack(y), np.ravel(traced_y.full())
