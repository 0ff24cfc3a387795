"""A sampled model as plain C for a controller board: no FMI, no heap, no files.

    <Model>.h        a struct of parameters, inputs, outputs and states; init, step
    <Model>.c        the traced equations, in double (the bits of the FMU) or float
    <Model>_test.c   a program that steps through a test vector and tells the error

In double the elementary functions are those of the FMUs (their headers come
along); in float they are the C library's, and a model that calculates with whole
numbers beyond those a float holds is refused.
"""

import ctypes
import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from fmus.bare_c_texts import HEADER, SINGLE, SOURCE, STEPS_OF, TEST
from fmus.compile import compile_alone, host_platform
from fmus.layout import Block, Layout, Variable
from fmus.load import BuildError
from fmus.model import FloatArray, Sampled
from fmus.native_source import QUIET, adapter_sources, number
from fmus.subject import Subject
from fmus.trace import OWN, c_code

Real: TypeAlias = Literal["double", "float"]
REALS: tuple[Real, ...] = ("double", "float")
STEPS = 64  # of the test vector
MEMBERS: Mapping[str, Block] = {
    "p": "parameter",
    "u": "input",
    "y": "output",
    "x": "state",
}
MEANING = {
    "p": "parameters: call {name}_prepare after a change",
    "u": "inputs, to be set before a step",
    "y": "outputs of the last step",
    "x": "states",
}
KEYWORDS = re.compile(
    "auto|break|case|char|const|continue|default|do|double|else|enum|extern|float|for|"
    "goto|if|inline|int|long|register|restrict|return|short|signed|sizeof|static|"
    "struct|switch|typedef|union|unsigned|void|volatile|while"
)
LOST = "{} {} with {:.17g}, which is no number of single precision: build it in double"
SPLITTER = 2.0**27 + 1  # cuts a double in two; 2¹² + 1 cuts a float
DOUBLE = re.compile(r"(?<![\w.])((?:\d+\.\d*|\.\d+)(?:[eE][-+]?\d+)?|\d+[eE][-+]?\d+)")


def bare_c(subject: Subject, real: Real, cache: Path) -> dict[str, str]:
    """Return the C files by name.

    Raises:
        BuildError: the model is continuous, two names are one in C, or float is short.
    """
    if not isinstance(subject.model, Sampled):
        raise BuildError(
            f"{subject.model.name} is continuous: plain C is for controllers and other "
            f"sampled models; build an FMU of it"
        )
    name = subject.model.name
    files = {f"{name}.h": _header(subject, real), f"{name}.c": _source(subject, real)}
    headers = ("sums.h", "angles.h", "elementary.h")
    ours = {header: adapter_sources()[header] for header in headers}
    if real == "double":
        files |= ours
    exact = {
        f"{name}.h": _header(subject, "double"),
        f"{name}.c": _source(subject, "double"),
    }
    inputs = _inputs(subject.layout)
    outputs = _run(name, exact | ours, inputs, subject.layout, cache)
    return files | {f"{name}_test.c": _test(subject, inputs, outputs)}


def _header(subject: Subject, real: Real) -> str:
    name, layout = subject.model.name, subject.layout
    assert isinstance(subject.model, Sampled)
    num, den = subject.model.period.as_integer_ratio()
    members = [_member(name, member, layout) for member in MEMBERS]
    if n_d := subject.traced.derived_size:
        members.append(f"    {name}_real d[{n_d}]; /* from p, by prepare */\n")
    return HEADER.format(
        name=name,
        guard=f"{name.upper()}_H",
        summary=subject.summary.rstrip("."),
        real=real,
        num=num,
        den=den,
        members="".join(members),
        single="" if real == "double" else SINGLE.format(2**24 * num / den),
    )


def _member(name: str, member: str, layout: Layout) -> str:
    variables = layout.block(MEMBERS[member])
    if not variables:
        return ""
    lines = [f"    struct {{ /* {MEANING[member].format(name=name)} */\n"]
    seen: dict[str, str] = {}
    for v in variables:
        field = _field(v)
        if field in seen:
            raise BuildError(
                f"{name}: {v.name} and {seen[field]} are both {field} in C: rename one"
            )
        seen[field] = v.name
        size = f"[{v.size}]" if v.shape else ""
        unit = "0 or 1" if v.boolean else v.var.unit
        meaning = v.var.description.replace("*/", "* /")
        lines.append(f"        {name}_real {field}{size}; /* {unit}: {meaning} */\n")
    return "".join([*lines, f"    }} {member};\n"])


def _field(v: Variable) -> str:
    field = v.name.removeprefix("state.").replace(".", "_")
    return f"{field}_" if KEYWORDS.fullmatch(field) else field


def _source(subject: Subject, real: Real) -> str:
    name, layout, traced = subject.model.name, subject.layout, subject.traced
    assert isinstance(subject.model, Sampled)
    functions = [traced.functions["prepare"], traced.functions["step"]]
    code = c_code(subject.model, functions)
    if real == "float":
        code = re.sub(rf"\bown_({OWN})\(", r"\1f(", code)
        code = re.sub(r"\b(floor|ceil|fabs|sqrt)\(", r"\1f(", code)
        code = DOUBLE.sub(partial(_single, name), code)
        code = code.replace('"elementary.h"', "<math.h>")
    starts = [
        _start(name, layout.block(block), real)
        for block in MEMBERS.values()
        if layout.count[block]
    ]
    if traced.derived_size:
        starts.append("{0}")
    work = {
        part: max(1, *(getattr(f, f"sz_{part}")() for f in functions))
        for part in ("arg", "res", "iw", "w")
    }
    given = {
        member: f"(const {name}_real *)&m->{member}" if layout.count[block] else "0"
        for member, block in MEMBERS.items()
    }
    return SOURCE.format(
        name=name,
        real=real,
        T_s=number(float(subject.model.period)) + ("f" if real == "float" else ""),
        quiet=QUIET,
        code=code,
        start=",\n        ".join(starts),
        n_x=max(1, layout.count["state"]),
        keep="memcpy(&m->x, next, sizeof m->x);" if layout.count["state"] else "",
        result=f"({name}_real *)&m->y" if layout.count["output"] else "0",
        d="m->d" if traced.derived_size else "0",
        **{f"sz_{part}": size for part, size in work.items()},
        **given,
    )


def _single(name: str, found: re.Match[str]) -> str:
    """Return a constant of the equations in float."""
    exact = float(found[1])
    if exact == SPLITTER:
        return "4097.f"
    if _lost(exact) or (exact % 1 == 0 and float(np.float32(exact)) != exact):
        raise BuildError(LOST.format(name, "calculates", exact))
    return f"{found[1]}f"


def _lost(exact: float) -> bool:
    """Tell whether a float makes 0 or infinity of a number."""
    with np.errstate(over="ignore", under="ignore"):
        single = float(np.float32(exact))
    return single != exact and (single == 0 or np.isinf(single))


def _start(name: str, variables: Sequence[Variable], real: Real) -> str:
    suffix = "f" if real == "float" else ""
    parts = []
    for v in variables:
        if real == "float" and (lost := [x for x in v.start if _lost(x)]):
            raise BuildError(LOST.format(name, f"starts {v.name}", lost[0]))
        numbers = [number(x) + suffix for x in v.start or (0.0,) * v.size]
        parts.append(f"{{{', '.join(numbers)}}}" if v.shape else numbers[0])
    return f"{{{', '.join(parts)}}}"


def _inputs(layout: Layout) -> FloatArray:
    """Return inputs around their starts, exact in binary; (STEPS, n_u)."""
    columns: list[FloatArray] = []
    for v in layout.block("input"):
        for start in v.start:
            i, k = len(columns), np.arange(STEPS)
            wave = ((7 * k + 13 * i) % 32 - 16) / 64
            columns.append((k % 2).astype(float) if v.boolean else start + wave)
    return np.array(columns, dtype=float).reshape(-1, STEPS).T.copy()


def _run(
    name: str, files: Mapping[str, str], inputs: FloatArray, layout: Layout, cache: Path
) -> FloatArray:
    """Return the outputs of the double form, compiled for this machine."""
    steps = STEPS_OF.format(
        name=name,
        n_u=inputs.shape[1],
        n_y=layout.count["output"],
        set_u="memcpy(&m.u, u, sizeof m.u);" if inputs.shape[1] else "",
    )
    sources = {**files, "steps.c": steps}
    library = ctypes.CDLL(str(compile_alone(name, sources, host_platform(), cache)))
    outputs = np.zeros((len(inputs), layout.count["output"]))
    pointers = [ctypes.c_void_p(a.ctypes.data) for a in (inputs, outputs)]
    library.run_test_vector(ctypes.c_int(len(inputs)), *pointers)
    return outputs


def _test(subject: Subject, inputs: FloatArray, outputs: FloatArray) -> str:
    name = subject.model.name

    def table(rows: FloatArray) -> str:
        lines = [", ".join(map(number, row)) or "0" for row in rows]
        return "".join(f"    {{{line}}},\n" for line in lines)

    n_u, n_y = inputs.shape[1], outputs.shape[1]
    assign = f"(({name}_real *)&m.u)[i] = ({name}_real)inputs[k][i];"
    return TEST.format(
        name=name,
        steps=len(inputs),
        n_u=n_u,
        n_y=n_y,
        w_u=max(1, n_u),
        inputs=table(inputs),
        outputs=table(outputs),
        assign=assign if n_u else "(void)inputs;",
    )
