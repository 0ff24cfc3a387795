"""The equations of a native FMU, read back from its ``model_data.c``.

CasADi writes one operation a line, on numbers ``a0``, ``a1``, ....  Here each
line becomes the same operation on values of the C type ``V``: one double, or a
vector of doubles with a member of a sweep in each lane.  Nothing is reordered,
so that every lane has the bits of the FMU (``orchestrator/native/fused/lanes.h``
declares what is written).
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

EQUATIONS = ("prepare", "step", "derivative", "output", "advance")
_NUMBER = r"-?(?:a\d+|\d[\d.]*(?:e[+-]?\d+)?|\.\d+)"
_BODY = r"static int (casadi_f\d+)\(const casadi_real\*\* arg.*?\{(.*?)\n\}"
_ENTRY = (
    r"CASADI_SYMBOL_EXPORT int (\w+)\(const casadi_real\*\* arg"
    r".*?return (casadi_f\d+)\("
)
_COMPARISON = re.compile(rf"\(({_NUMBER})(<=|>=|==|!=|<|>)({_NUMBER})\)")
_ARITHMETIC = re.compile(rf"\(({_NUMBER})([-+*/])({_NUMBER})\)")
_LOGIC = re.compile(rf"\(({_NUMBER})(&&|\|\|)({_NUMBER})\)")
_CHOICE = re.compile(rf"\(({_NUMBER})\?({_NUMBER}):0\)")
_UNARY = re.compile(rf"\(([-!])({_NUMBER})\)")
_CALL = re.compile(rf"(\w+)\(({_NUMBER})(?:,({_NUMBER}))?\)")
_INPUT = re.compile(r"arg\[\d+\]\[\d+\]")
_ASSIGN = re.compile(r"(a\d+)=(.*);")
_RESULT = re.compile(r"res\[(\d+)\]\[(\d+)\]=(a\d+);")
_DECLARED = re.compile(r"casadi_real (a\d+(?:, a\d+)*);")
_FIELD = re.compile(r"(?m)^    (-?[\d.]+(?:e[+-]?\d+)?), /\* (\w+) \*/$")
_DELAY = re.compile(r"\{(\d+), (\d+), (\d+)\}")
_LOGICAL = {"&&": "both", "||": "either"}


class Unreadable(ValueError):
    """A line of the generated source is in no form that is known."""


@dataclass(frozen=True)
class Equations:
    """A model's equations as C statements on ``V``, and the numbers beside them.

    ``functions`` are statements on ``arg`` and ``res``, by name; ``numbers`` the
    fields of ``Model`` in ``model.h`` that are numbers; ``start`` the values by
    reference; ``delays`` the references of each delayed input, of its dead time,
    and the room its line has.
    """

    functions: Mapping[str, tuple[str, ...]]
    numbers: Mapping[str, float]
    start: tuple[float, ...]
    delays: tuple[tuple[int, int, int], ...]

    def __getitem__(self, name: str) -> int:
        return int(self.numbers[name])


def read_equations(source: str) -> Equations:
    """Return what a ``model_data.c`` says.

    Raises:
        Unreadable: it has a form that ``fmus.native_source`` does not write.
    """
    bodies = dict(re.findall(_BODY, source, flags=re.DOTALL))
    entries = dict(re.findall(_ENTRY, source, flags=re.DOTALL))
    table = source.partition("const Model feeddrive_model = {")[2]
    numbers = {name: float(value) for value, name in _FIELD.findall(table)}
    delays = source.partition("Delay delays[] = {")[2].partition("};")[0]
    start = source.partition("double start[] = {")[2].partition("};")[0]
    if "n_d" not in numbers or not entries:
        raise Unreadable("the table of the model is in no form that is known")
    found = [tuple(map(int, row)) for row in _DELAY.findall(delays)]
    return Equations(
        {n: tuple(_statements(bodies[entries[n]])) for n in EQUATIONS if n in entries},
        numbers,
        tuple(map(float, filter(None, re.split(r"[,\s]+", start)))),
        tuple((u, tau, room) for u, tau, room in found[: int(numbers["n_delays"])]),
    )


def _statements(body: str) -> Iterator[str]:
    for line in filter(None, map(str.strip, body.splitlines())):
        if line in ("return 0;",):
            continue
        if match := _DECLARED.fullmatch(line):
            yield f"V {match[1]};"
        elif match := _RESULT.fullmatch(line):
            yield f"if (res[{match[1]}]) res[{match[1]}][{match[2]}] = {match[3]};"
        elif match := _ASSIGN.fullmatch(line):
            yield f"{match[1]} = {_operation(match[2])};"
        else:
            raise Unreadable(f"generated equations hold an unknown line: {line}")


def _operation(text: str) -> str:
    if _INPUT.fullmatch(text):
        return text
    if re.fullmatch(_NUMBER, text):
        return f"(V)({text})"
    if match := _ARITHMETIC.fullmatch(text):
        return f"{match[1]} {match[2]} {match[3]}"
    if match := _COMPARISON.fullmatch(text):
        return f"truth({match[1]} {match[2]} {match[3]})"
    if match := _LOGIC.fullmatch(text):
        return f"{_LOGICAL[match[2]]}({match[1]}, {match[3]})"
    if match := _CHOICE.fullmatch(text):
        return f"given({match[1]}, {match[2]})"
    if match := _UNARY.fullmatch(text):
        return f"-{match[2]}" if match[1] == "-" else f"negated({match[2]})"
    if match := _CALL.fullmatch(text):
        name = match[1].removeprefix("casadi_").removeprefix("own_")
        rest = f", {match[3]}" if match[3] else ""
        return f"v_{name}({match[2]}{rest})"
    raise Unreadable(f"generated equations hold an unknown operation: {text}")
