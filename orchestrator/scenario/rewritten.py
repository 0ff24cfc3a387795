"""Numbers that a scenario wrote in one unit, in the unit that its variable has now.

A swap may give a variable another unit: by its map, or by a name that has no map.
"""

from collections.abc import Sequence
from typing import TypeAlias

from fmus.units import UnitError
from orchestrator.errors import ScenarioError
from orchestrator.quantities.unit import Conversion, Unit, conversion
from orchestrator.system import Value
from orchestrator.warned import warn

Units: TypeAlias = Sequence[Unit | None]


def rewritten(where: str, value: Value, written: Units, now: Units) -> Value:
    """Return a value in the units that its numbers have now, one unit for each.

    Switches and texts stay; so do numbers that had, or have, no unit.  A value of
    another count than its variable stays too: it is refused where it is written.

    Raises:
        ScenarioError: one unit cannot become the other.
    """
    given = value if isinstance(value, tuple) else (value,)
    steps = [_step(where, value, *ends) for ends in _ends(len(given), written, now)]
    if all(step[:2] == (1.0, 0.0) for step in steps):
        return value
    found = tuple(
        one if isinstance(one, str | bool) else step.gain * one + step.offset
        for one, step in zip(given, steps, strict=True)
    )
    return found if isinstance(value, tuple) else found[0]


def _ends(
    count: int, written: Units, now: Units
) -> list[tuple[Unit | None, Unit | None]]:
    ends = list(zip(written, now, strict=False))
    if len(set(ends)) == 1:
        return ends[:1] * count
    return ends if len(written) == len(now) == count else []


def _step(
    where: str, value: Value, written: Unit | None, now: Unit | None
) -> Conversion:
    texts = value if isinstance(value, tuple) else (value,)
    if written is None or now is None or all(isinstance(v, str) for v in texts):
        return Conversion()
    try:
        found = conversion(written, now)
    except UnitError as error:
        raise ScenarioError(
            f"{where} = {value}: {error}; give the map a unit in which it can be had, "
            f"or the value a unit of its own"
        ) from None
    for doubt in found.doubts:
        warn(f"{where}: {doubt}")
    return found
