"""A table of recorded signals as a sampled FMU: row k at t = k T_s, then the last.

Its numbers lie as ``resources/table.bin`` in the archive and are read when it is
instantiated: nothing of them is compiled.  ``table.c`` stands for the equations.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from keyword import iskeyword
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fmus.build import BuildError, build_made
from fmus.model import Sampled, Var, leaves, size, unpack
from fmus.subject import Fmi, Subject

HERE = Path(__file__).parent
RESOURCE = "resources/table.bin"
NOT_IN_NAMES = "letters, digits, _ and dots, no Python keyword, no _ in front"


class State(NamedTuple):
    k: Annotated[float, Var("1", "row that is next")] = 0.0


class Nothing(NamedTuple):
    pass


@dataclass(frozen=True)
class Table:
    """Signals (rows, columns) every ``period`` s from t = 0 on; ``text`` tells of them.

    ``about`` is what each column's description says.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    about: tuple[str, ...]
    values: NDArray[np.float64]
    period: Fraction
    text: str


def build_signals(
    name: str,
    told: object,
    read: Callable[[], Table],
    *,
    fmi: Fmi = 2,
    clock: bool = True,
    platforms: Sequence[str] | None = None,
    folder: Path | None = None,
) -> Path:
    """Return the FMU of the table that ``read`` returns, from the cache if it is there.

    ``told`` is all that decides what the table is.

    Raises:
        BuildError: a name or unit is none that an FMU can have.
        OSError: the file cannot be written.
    """
    make = partial(_contents, name, read, fmi, clock)
    options: dict[str, Any] = {"fmi": fmi, "platforms": platforms, "folder": folder}
    return build_made(name, make, ("signals", told, clock), **options)


def _contents(
    name: str,
    read: Callable[[], Table],
    fmi: Fmi,
    clock: bool,
    platforms: Sequence[str],
    cache: Path,
) -> Mapping[str, bytes]:
    from fmus.package import native_contents

    return native_contents(subject_of_table(name, read(), clock), fmi, platforms, cache)


def subject_of_table(name: str, table: Table, clock: bool = True) -> Subject:
    """Return what the FMU of a table is made of.

    Raises:
        BuildError: a name is none that an FMU can have.
    """
    from fmus.checks import check_model
    from fmus.layout import layout
    from fmus.package import OWN_COPYRIGHT
    from fmus.trace import trace

    output = _record("Output", _tree(table))
    order = [table.names.index(leaf.name) for leaf in leaves(output)]
    rows = np.ascontiguousarray(table.values[:, order])

    def step(x: State, u: Any, p: Any, T_s: float) -> tuple[State, Any]:
        k = int(min(max(x.k, 0.0), len(rows) - 1))
        return State(x.k + 1), unpack(output, rows[k])

    def stand_in(x: State, u: Any, p: Any, T_s: float) -> tuple[State, Any]:
        """What depends on what; the trace has no tables."""
        return State(x.k + 1), _filled(output, np.floor(x.k))

    model = Sampled(name, step, State(), Nothing(), Nothing(), table.period)
    check_model(model)
    traced = trace(Sampled(name, stand_in, State(), Nothing(), Nothing(), table.period))
    code = (HERE / "table.c").read_text(encoding="utf-8")
    return Subject(
        model,
        traced,
        layout(model, output),
        f"signals.{name}",
        table.text,
        author=f"{OWN_COPYRIGHT}; the numbers are their owner's",
        copyright=f"© {OWN_COPYRIGHT}, without the numbers",
        license="MIT, without the numbers",
        clock=clock,
        equations=f"enum {{ ROWS = {len(rows)}, COLUMNS = {size(output)} }};\n\n{code}",
        resources={RESOURCE: rows.astype("<f8").tobytes()},
    )


def _tree(table: Table) -> dict[str, Any]:
    """Return the columns as names or, at a dot, as further columns."""
    tree: dict[str, Any] = {}
    for name, unit, about in zip(table.names, table.units, table.about, strict=True):
        place = tree
        *outer, last = name.split(".")
        for part in outer:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise BuildError(f"{name} and {part} cannot both name a signal")
        if last in place:
            raise BuildError(f"{name} names two signals")
        place[last] = Var(unit, about)
        for part in (*outer, last):
            if not part.isidentifier() or iskeyword(part) or part.startswith("_"):
                raise BuildError(f"{name!r} cannot name a signal: {NOT_IN_NAMES}")
    return tree


def _record(name: str, tree: Mapping[str, Any]) -> Any:
    """Return a record of zeros with the fields of a tree."""
    values = {
        k: _record(k.capitalize(), v) if isinstance(v, dict) else 0.0
        for k, v in tree.items()
    }
    fields = [
        (k, type(values[k]) if isinstance(v, dict) else Annotated[float, v])
        for k, v in tree.items()
    ]
    made: Any = NamedTuple(name, fields)  # type: ignore[misc]
    return made(**values)


def _filled(record: Any, value: Any) -> Any:
    parts = (_filled(v, value) if isinstance(v, tuple) else value for v in record)
    return record._make(parts)
