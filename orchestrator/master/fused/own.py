"""A component of ours in the fused loop, and the C of what is done with it alone."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from fmus.equations import Equations
from orchestrator.fmu.description import FmuVariable
from orchestrator.fmu.ports import Affine
from orchestrator.master.layout import Part


@dataclass(frozen=True)
class Own:
    """A component of ours: its number among the parts, its model, its equations."""

    index: int
    model: int
    part: Part
    equations: Equations

    @property
    def function(self) -> str:
        return f"m{self.model}"

    @property
    def instance(self) -> str:
        return f"(e->parts + {self.index})"

    def value(self, reference: int) -> str:
        return f"e->parts[{self.index}].values[{reference}]"


def model(own: Own, often: bool) -> Iterator[str]:
    equations, name = own.equations, own.function
    for equation, statements in equations.functions.items():
        called = {"step": "tick"}.get(equation, equation)
        # carried out once: nothing is gained by optimising it, minutes may be lost
        how = "ONCE" if equation == "prepare" else "static inline"
        yield f"{how} void {name}_{called}(const V *const *arg, V *const *res) {{"
        yield "    (void)arg, (void)res;"
        yield from (f"    {line}" for line in statements)
        yield "}"
    numbers = {
        "CONTINUOUS": equations["continuous"],
        "SIZE": equations["size"],
        "U": equations["u"],
        "Y": equations["y"],
        "X": equations["x"],
        "DER_X": equations["der_x"],
        "T_S": equations["T_s"],
        "N_U": equations["n_u"],
        "N_X": equations["n_x"],
        "H_MAX": equations.numbers["h_max"].hex(),
        "N_DELAYS": len(equations.delays),
    }
    if equations.delays:
        pairs = ", ".join(f"{{{u}, {tau}}}" for u, tau, _ in equations.delays)
        numbers["DELAYS"] = f"{{ {pairs} }}"
    if "advance" in equations.functions:
        numbers["ADVANCE"] = ""
    defined: dict[str, object] = {"MODEL": name, **numbers}
    defined["STEP"] = "static NEVER_INLINE" if often else "static inline"
    yield from (f"#define {macro} {value}" for macro, value in defined.items())
    yield '#include "stepping.h"'
    yield from (f"#undef {macro}" for macro in defined)


def elements(
    variables: Iterable[FmuVariable], first: int
) -> Iterator[tuple[int, int, bool]]:
    """Yield place, reference and whether it is Boolean, number by number."""
    place = first
    for variable in variables:
        for i in range(variable.size):
            yield place, variable.reference + i, variable.sort == "boolean"
            place += 1


def values_read(own: Own) -> Iterator[str]:
    for place, reference, boolean in elements(own.part.read, own.part.raw):
        value = own.value(reference)
        yield f"z[{place}] = {f'truth({value} != 0)' if boolean else value};"


def written(own: Own) -> Iterator[str]:
    for place, reference, boolean in elements(own.part.inputs, own.part.first_input):
        value = f"truth(z[{place}] != 0)" if boolean else f"z[{place}]"
        yield f"{own.value(reference)} = {value};"


def published(own: Own) -> Iterator[str]:
    part = own.part
    if part.published != part.raw:
        size = f"{part.read_size} * sizeof(V)"
        yield f"memcpy(z + {part.published}, z + {part.raw}, {size});"


def held(own: Own) -> Iterator[str]:
    part, here = own.part, f"e->parts[{own.index}]"
    n, latency = part.delayed, part.component.latency
    yield (f"memcpy({here}.held + {here}.head * {n}, z + {part.raw}, {n} * sizeof(V));")
    yield f"{here}.head = {here}.head + 1 == {latency} ? 0 : {here}.head + 1;"
    if rest := part.read_size - n:
        yield (
            f"memcpy(z + {part.published + n}, z + {part.raw + n}, {rest} * sizeof(V));"
        )


def released(own: Own) -> Iterator[str]:
    n, here = own.part.delayed, f"e->parts[{own.index}]"
    source = f"{here}.held + {here}.head * {n}"
    yield f"memcpy(z + {own.part.published}, {source}, {n} * sizeof(V));"


def affine_text(value: str, affine: Affine) -> str:
    if not affine.converts:
        return value
    return f"{number_text(affine.gain)} * {value} + {number_text(affine.offset)}"


def number_text(value: float) -> str:
    return f"({value.hex()})"
