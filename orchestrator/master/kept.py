"""Whether an FMU keeps what is written to it before its initialisation.

Some exporters overwrite start values while their experiment is set up; then the
values of scenario and lock are not those that run.  Compared are parameters and
start values, also of inputs that nothing drives, not those of driven inputs.
"""

import logging
from collections.abc import Sequence
from itertools import groupby
from typing import TypeAlias

from orchestrator.errors import SimulationError
from orchestrator.fmu.description import FmuVariable
from orchestrator.fmu.typed import Held
from orchestrator.instances.protocol import Instance
from orchestrator.master.layout import Part
from orchestrator.warned import warn

LOG = logging.getLogger("feeddrive")
ROUNDED = 1e-6  # relative; by which an FMU may round, as single precision does
Values: TypeAlias = tuple[Held, ...]


def held(part: Part, instance: Instance) -> dict[str, Values]:
    """Return what an FMU now holds of each variable that was written."""
    variables = [variable for variable, _ in _written(part)]
    numbers = iter(instance.read(variables) if variables else [])
    return {v.name: tuple(next(numbers) for _ in range(v.size)) for v in variables}


def refuse_changed(
    part: Part, before: dict[str, Values], after: dict[str, Values]
) -> None:
    """Compare what was written with what was held ``before`` and ``after`` the end of
    the initialisation.

    Raises:
        SimulationError: a parameter or an exact start value differs.
    """
    for variable, given in _written(part):
        name = variable.name
        parameter = variable.causality in ("parameter", "structuralParameter")
        kept = after[name] if parameter else before[name]
        what = f"{part.name}.{name} was given {_text(given)}, but the FMU "
        if variable.initial == "approx":
            if kept != given:
                LOG.info("%sstarts with %s, as it may", what, _text(kept))
        elif not all(map(_same, given, kept)):
            raise SimulationError(
                f"{what}({part.fmu.path.name}) holds {_text(kept)} after its "
                f"initialisation; it overwrites what is set, so set it inside the FMU, "
                f"or ask its supplier"
            )
        elif kept != given:
            warn(f"{what}rounds it to {_text(kept)}")
        elif after[name] != given:
            warn(f"{what}begins with {_text(after[name])}: an event at its start")


def _written(part: Part) -> list[tuple[FmuVariable, Values]]:
    """Return the last value written to each variable that nothing drives."""
    driven = {*(variable.name for variable in part.inputs), *part.heard}
    last = {v.name: (v, values) for v, values in part.start if v.name not in driven}
    return list(last.values())


def _same(given: Held, kept: Held) -> bool:
    if given == kept or isinstance(given, str | bytes) or isinstance(kept, str | bytes):
        return given == kept
    return abs(given - kept) <= ROUNDED * max(abs(given), abs(kept))


def _text(values: Sequence[Held]) -> str:
    runs = [(value, len(list(same))) for value, same in groupby(values)]
    some = [f"{v!r}" + (f" ({n} times)" if n > 1 else "") for v, n in runs]
    return ", ".join(some[:6]) + (", ..." if len(some) > 6 else "")
