"""The C sources of a native FMU: hand-written adapters and one generated file.

``fmus/native`` holds the FMI functions and the integration, the same for every
model.  ``model_data.c`` holds the compiled equations and a table of what the
adapters must know about them (``model.h`` declares it).  ``all.c`` includes them
all: one translation unit, in C99 or C++.
"""

from collections.abc import Iterable, Mapping
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

from fmus.layout import Layout, Variable
from fmus.model import Continuous, Model
from fmus.quantities import nominal

if TYPE_CHECKING:  # imports CasADi, which only new builds need
    from fmus.trace import Traced

NATIVE = Path(__file__).with_name("native")
MODEL_DATA = "model_data.c"
ALL = "all.c"
SHORTEST = 16  # steps of h_max / 16 fit into a delay line (simulation.c)
WORK = ("arg", "res", "iw", "w")  # vectors that the equations work in
NAME = 32  # words for the name of an instance in a static pool

_BLOCKS = {
    "parameter": "PARAMETER",
    "input": "INPUT",
    "output": "OUTPUT",
    "state": "STATE",
    "derivative": "DERIVATIVE",
    "period": "PERIOD",
}
QUIET = """\
/* Local, so that models linked into one program do not meet. */
#define CASADI_SYMBOL_EXPORT static
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-parameter"
"""
# in the order of model.h; what a model does not have is 0
EQUATIONS = ("prepare", "step", "derivative", "output", "advance", "tangent", "open")
POOL = """\
#ifdef FEEDDRIVE_INSTANCES
#include "component.h"
enum {{
    BYTES = sizeof(Component) + {delays} * sizeof(DelayLine) +
            {changes} * sizeof(Change),
    PLACE = (BYTES + sizeof(double) - 1) / sizeof(double) + {words}
}};
double feeddrive_pool[(size_t)FEEDDRIVE_INSTANCES * PLACE];
const size_t feeddrive_place = PLACE;
#endif
"""


def adapter_sources() -> dict[str, str]:
    """Return the hand-written C files and headers by name."""
    files = sorted(NATIVE.glob("*.[ch]"))
    return {file.name: file.read_text(encoding="utf-8") for file in files}


def native_sources(
    model: Model,
    traced: "Traced",
    layout: Layout,
    identifier: str,
    token: str,
    clock: bool = True,
    written: str = "",
) -> dict[str, str]:
    """Return the generated C files by name: equations and data of one model.

    ``written`` is C that has ``written_prepare``, ``written_step`` and
    ``written_open`` in place of the traced equations.

    ``token`` is what an importer must show to instantiate it (FMI 2: guid);
    without ``clock`` a sampled model has no event mode.

    Raises:
        ValueError: a delay names no input or parameter, or their sizes differ.
    """
    told = dict.fromkeys(EQUATIONS, "0")
    if written:
        work = {"sz_arg": 5, "sz_res": 2, "sz_iw": 0, "sz_w": 0}
        told |= {name: f"written_{name}" for name in ("prepare", "step", "open")}
        code = f'#include "model.h"\n\n{written}'
    else:
        code, work, found = _traced(model, traced)
        told |= {name: name for name in found}
    parts = [
        QUIET,
        code,
        *_tables(model, layout),
        _model(model, traced, layout, identifier, token, clock, work, told),
        _pool(model, traced, layout, work),
    ]
    return {MODEL_DATA: "\n".join(parts)}


def _traced(model: Model, traced: "Traced") -> tuple[str, dict[str, int], list[str]]:
    """Return C of the traced equations, the sizes of their work, their names."""
    from fmus.tangent import tangent
    from fmus.trace import c_code

    direction = tangent(model, traced)
    functions = [*traced.functions.values(), *([direction] if direction else [])]
    work = {f"sz_{of}": max(getattr(f, f"sz_{of}")() for f in functions) for of in WORK}
    code = c_code(model, functions) + '\n#include "model.h"\n'
    return code, work, [function.name() for function in functions]


def _tables(model: Model, layout: Layout) -> list[str]:
    variables = [_variable(v) for v in layout.variables]
    variables.append(f'{{"time", {layout.size}, 1, TIME, 0, 0, 0}}')
    owner = [i for i, v in enumerate(layout.variables) for _ in range(v.size)]
    start = [x for v in layout.variables for x in v.start or (0.0,) * v.size]
    usual = [nominal(v) or 1.0 for v in layout.block("state") for _ in range(v.size)]
    delays = [
        f"{{{u}, {tau}, {capacity}}}" for u, tau, capacity in _delays(model, layout)
    ]
    return [
        _array("Variable", "variables", variables),
        _array(
            "unsigned", "variable_of", [*map(str, owner), str(len(layout.variables))]
        ),
        _array("double", "start", map(number, [*start, 0.0])),
        _array("double", "nominal", map(number, usual or [1.0])),
        _array("Delay", "delays", delays or ["{0, 0, 0}"]),
    ]


def _variable(v: Variable) -> str:
    flags = (v.boolean, v.var.constant, v.var.fixed)
    fields = [_text(v.name), str(v.reference), str(v.size), _BLOCKS[v.block]]
    return "{" + ", ".join([*fields, *(str(int(flag)) for flag in flags)]) + "}"


def _delays(model: Model, layout: Layout) -> list[tuple[int, int, int]]:
    """Return, of each delayed input element, its reference, that of its dead time
    and how many changes its line holds: at the longest dead time that the model
    names, and the shortest usual step."""
    if not isinstance(model, Continuous):
        return []
    triples = []
    for input_name, parameter_name in model.delay.items():
        u = _named(model, layout, "input", input_name)
        tau = _named(model, layout, "parameter", parameter_name)
        if tau.size != 1:
            raise ValueError(
                f"{model.name}: dead time {tau.name!r} has {tau.size} elements; give "
                f"one for all of {u.name!r}"
            )
        capacity = ceil(max(tau.start) / model.h_max * SHORTEST) + 2
        triples += [(u.reference + i, tau.reference, capacity) for i in range(u.size)]
    return triples


def _named(model: Model, layout: Layout, block: str, name: str) -> Variable:
    for variable in layout.variables:
        if variable.block == block and variable.name == name:
            return variable
    raise ValueError(f"{model.name}: delay names {name!r}, which is no {block}")


def _model(
    model: Model,
    traced: "Traced",
    layout: Layout,
    identifier: str,
    token: str,
    clock: bool,
    work: Mapping[str, int],
    equations: Mapping[str, str],
) -> str:
    offset, count = layout.offset, layout.count
    continuous = isinstance(model, Continuous)
    period = (
        (0, 1) if isinstance(model, Continuous) else model.period.as_integer_ratio()
    )
    fields = {
        "identifier": _text(identifier),
        "token": _text(token),
        "variables": "variables",
        "variable_of": "variable_of",
        "start": "start",
        "nominal": "nominal",
        "size": layout.size + 1,
        "u": offset["input"],
        "y": offset["output"],
        "x": offset["state"],
        "der_x": offset["derivative"],
        "T_s": offset["period"],
        "n_u": count["input"],
        "n_y": count["output"],
        "n_x": count["state"],
        "n_d": traced.derived_size,
        "continuous": int(continuous),
        "clock": int(clock and not continuous),
        "h_max": number(model.h_max if isinstance(model, Continuous) else 0.0),
        "period_num": period[0],
        "period_den": period[1],
        "delays": "delays",
        "n_delays": len(_delays(model, layout)),
        **equations,
        **work,
    }
    lines = [f"    {value}, /* {name} */" for name, value in fields.items()]
    return "\n".join(["const Model feeddrive_model = {", *lines, "};\n"])


def _pool(
    model: Model, traced: "Traced", layout: Layout, work: Mapping[str, int]
) -> str:
    """Return the static memory of instances, for importers without a heap."""
    n_x, n_u, n_y = (layout.count[block] for block in ("state", "input", "output"))
    words = layout.size + 1 + traced.derived_size + NAME
    words += 7 * n_x + 2 * n_u + n_y + sum(work.values())
    delays = _delays(model, layout)
    changes = sum(capacity for _, _, capacity in delays)
    return POOL.format(words=words, delays=len(delays), changes=changes)


def _array(kind: str, name: str, elements: Iterable[str]) -> str:
    body = "".join(f"    {element},\n" for element in elements)
    return f"static const {kind} {name}[] = {{\n{body}}};\n"


def _text(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def number(value: float) -> str:
    return repr(float(value))


def source_names(sources: Mapping[str, str]) -> list[str]:
    """Return the files to be compiled one by one: all but headers and ``all.c``."""
    return sorted(name for name in sources if name.endswith(".c") and name != ALL)
