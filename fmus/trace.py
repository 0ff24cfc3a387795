"""Trace a model's own equations into CasADi functions, ready for C.

Functions take and return stacked vectors in the order of ``fmus.model.pack``:

    prepare(p, T_s) -> d                       d is empty without ``prepare``
    step(x, u, p, d, T_s) -> (x_next, y)       sampled
    derivative(x, u, p, d) -> der_x            continuous
    output(x, u, p, d) -> y
    advance(x, u, p, d, h) -> x_next           only where the model has one

Refused: a NaN constant, the mark of ``math.f(x)`` or ``float(x)`` on a signal.
Constant parameters are baked in as numbers; their places in p are not read.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from fmus.model import Continuous, Model, Record, is_record, leaves
from fmus.returned import called, pair_of, record_of

# of fmus/native/elementary.h, instead of the C library's
OWN = "exp|expm1|log|sin|cos|tan|atan|sinh|cosh|tanh|pow|fmin|fmax"
# what importers of CasADi's own kind would ask the C code
UNNEEDED = (
    r"(?ms)^CASADI_SYMBOL_EXPORT [^\n]*\{(?: return [^\n]*)?\}\n+",
    r"(?ms)^CASADI_SYMBOL_EXPORT [^\n]*?(?:_version|_checkout|_release|_incref|_decref"
    r"|_n_in|_n_out|_default_in|_name_in|_name_out|_sparsity_in|_sparsity_out|_work"
    r"|_work_bytes)\(.*?^\}\n+",
    r"(?m)^(?:static const casadi_int casadi_s|#define casadi_s)\d+[^\n]*\n+",
)


@dataclass(frozen=True)
class Traced:
    """The equations of one model as CasADi functions, and their output shapes.

    ``output_like`` is a record of the output class filled with zeros of the
    right shapes; ``derived_size`` the length of d.
    """

    functions: Mapping[str, ca.Function]
    output_like: Record
    derived_size: int


@contextmanager
def numpy_on_symbols() -> Iterator[None]:
    """Let NumPy act elementwise on symbols, and keep (a + b) - b as written."""
    mode = ca.GlobalOptions.getNumpyMode()
    simplify = ca.GlobalOptions.getSimplificationOnTheFly()
    ca.GlobalOptions.setNumpyMode(-1)
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        ca.GlobalOptions.setNumpyMode(mode)
        ca.GlobalOptions.setSimplificationOnTheFly(simplify)


def trace(model: Model) -> Traced:
    """Return the model's equations as CasADi functions of stacked vectors.

    Raises:
        ValueError: an equation lost a symbol to a Python float, or a function
            takes or returns what it should not.
    """
    with numpy_on_symbols():
        return _trace(model)


def _trace(model: Model) -> Traced:
    x, u, p = (symbols_like(r) for r in (model.state, model.input, model.parameters))
    X, U, P = column(x), column(u), column(p)
    T_s, h = ca.SX.sym("T_s"), ca.SX.sym("h")
    p = bake_constants(model.parameters, p)

    functions = {}
    extra: dict[str, Any] = {}
    D = ca.SX(0, 1)
    if model.prepare is not None:
        timing = {} if isinstance(model, Continuous) else {"T_s": T_s}
        derived = record_of(model.prepare, called(model.prepare, p=p, **timing))
        functions["prepare"] = _function("prepare", {"p": P, "T_s": T_s}, d=derived)
        placeholders = symbols_like(derived)
        D, extra = column(placeholders), {"d": placeholders}
    else:
        functions["prepare"] = ca.Function(
            "prepare", [P, T_s], [D], ["p", "T_s"], ["d"]
        )

    signals = {"x": X, "u": U, "p": P, "d": D}
    if isinstance(model, Continuous):
        told = {"x": x, "u": u, "p": p}
        y = record_of(model.output, called(model.output, **told, **extra))
        der_x = called(model.derivative, **told, **extra)
        record_of(model.derivative, der_x, model.state)
        functions["derivative"] = _function("derivative", signals, der_x=der_x)
        functions["output"] = _function("output", signals, y=y)
        if model.advance is not None:
            x_next = called(model.advance, **told, h=h, **extra)
            record_of(model.advance, x_next, model.state)
            timed = signals | {"h": h}
            functions["advance"] = _function("advance", timed, x_next=x_next)
    else:
        result = called(model.step, x=x, u=u, p=p, T_s=T_s, **extra)
        x_next, y = pair_of(model.step, result)
        record_of(model.step, x_next, model.state)
        record_of(model.step, y)
        timed = signals | {"T_s": T_s}
        functions["step"] = _function("step", timed, x_next=x_next, y=y)
    return Traced(functions, zeros_like(y), D.numel())


def _function(name: str, arguments: dict[str, ca.SX], **results: Record) -> ca.Function:
    columns = [column(record) for record in results.values()]
    function = ca.Function(
        name,
        list(arguments.values()),
        ca.cse(columns),
        list(arguments),
        list(results),
    )
    for i in range(function.n_instructions()):
        if function.instruction_id(i) != ca.OP_CONST:
            continue
        if np.isnan(function.instruction_constant(i)):
            raise ValueError(
                f"{name} lost a symbol to a Python float: use NumPy functions on "
                f"signals, never math.f(x) or float(x)"
            )
    return function


def symbols_like(record: Record, prefix: str = "") -> Record:
    """Return a record of fresh symbols shaped as ``record`` (numbers or symbols)."""

    def fresh(name: str, value: Any) -> Any:
        if is_record(value):
            return symbols_like(value, f"{name}.")
        return ca.SX.sym(name, *_shape(value))

    pairs = zip(record._fields, record, strict=True)
    return record._make(fresh(prefix + name, value) for name, value in pairs)


def zeros_like(record: Record) -> Record:
    """Return a record of zeros shaped as a traced one; (n, 1) becomes (n,)."""

    def zero(value: Any) -> Any:
        if is_record(value):
            return zeros_like(value)
        rows, columns = _shape(value)
        if rows == columns == 1:
            return 0.0
        return np.zeros(rows) if columns == 1 else np.zeros((rows, columns))

    return record._make(zero(value) for value in record)


def _shape(value: Any) -> tuple[int, int]:
    if isinstance(value, ca.SX):
        rows, columns = value.shape
        return int(rows), int(columns)
    shape = np.shape(value)
    return (*shape, *(1, 1))[:2] if len(shape) < 2 else shape


def bake_constants(values: Record, symbols: Record) -> Record:
    """Put the numbers of constant parameters in place of their symbols."""
    constant = iter([leaf.var.constant for leaf in leaves(values)])

    def choose(value: Any, symbol: Any) -> Any:
        if is_record(value):
            pairs = zip(value, symbol, strict=True)
            return value._make(choose(*pair) for pair in pairs)
        return value if next(constant) else symbol

    return choose(values, symbols)


def column(record: Record) -> ca.SX:
    """Stack a record of symbols in the order of ``fmus.model.pack``."""
    parts = []
    for value in record:
        parts.append(column(value) if is_record(value) else ca.vec(ca.SX(value).T))
    return ca.vertcat(ca.SX(0, 1), *parts)


def dependencies(function: ca.Function, result: str, argument: str) -> ca.Sparsity:
    """Return which rows of ``result`` depend on which entries of ``argument``."""
    names_in, names_out = function.name_in(), function.name_out()
    return function.jac_sparsity(names_out.index(result), names_in.index(argument))


def c_code(model: Model, functions: Iterable[ca.Function]) -> str:
    """Return C99 source of some of the model's functions, static data free.

    It includes ``elementary.h`` and calls its functions, which give the same
    bits on every machine.  Callers give every argument and result a place: CasADi's
    question at each of them whether it has one is taken out, which compiles in a
    fifth of the time to half of the code.
    """
    generator = ca.CodeGenerator(f"{model.name}.c", {"with_header": False})
    for function in functions:
        generator.add(function)
    code: str = generator.dump()
    for unneeded in UNNEEDED:
        code = re.sub(unneeded, "", code)
    theirs = rf"casadi_(?:fabs|{OWN})"  # for compilers before C99
    code = re.sub(rf"#define {theirs} .*\n", "", code)
    code = re.sub(rf"casadi_real {theirs}\(.*?\n}}\n\n", "", code, flags=re.DOTALL)
    code = code.replace("casadi_fabs(", "fabs(")
    code = re.sub(r"(?m)^casadi_real casadi_", "static casadi_real casadi_", code)
    code = re.sub(rf"\b(?:casadi_)?({OWN})\(", r"own_\1(", code)
    code = re.sub(r"\barg\[(\d+)\]\? (arg\[\1\]\[\d+\]) : 0", r"\2", code)
    code = re.sub(r"\bif \(res\[(\d+)\]!=0\) (?=res\[\1\]\[)", "", code)
    return code.replace("#include <math.h>", '#include "elementary.h"')
