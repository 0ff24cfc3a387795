"""What becomes of a number on its way: units first, then the transformation.

SSP says that both act but not in which order; where the order would matter it is
refused.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from fmus.units import UnitError
from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.records import Looked, Transformation
from orchestrator.fmu.ports import Affine
from orchestrator.quantities.unit import UndefinedUnit, Unit, conversion

NOTHING = Affine()


@dataclass(frozen=True)
class Hop:
    """One connection or mapping: the unit at its end, what it says of numbers."""

    unit: Unit | None
    how: Transformation | None
    suppress: bool
    where: str


def _affine(hop: Hop) -> Affine:
    """Return a transformation as numbers."""
    if isinstance(hop.how, Looked):
        raise ScenarioError(
            f"{hop.where}: maps single values on a way that has units or other "
            f"transformations, or leads to a parameter; map where the value is said"
        )
    return NOTHING if hop.how is None else Affine(*map(float, hop.how))


def passed(unit: Unit | None, hops: Iterable[Hop]) -> tuple[Affine, bool]:
    """Return sink = gain * source + offset over hops, and whether units alone did it.

    Raises:
        ScenarioError: units do not fit, or an order that SSP leaves open matters.
    """
    whole, plain = NOTHING, True
    for hop in hops:
        convert = NOTHING if hop.suppress else _converted(unit, hop.unit, hop.where)
        linear = _affine(hop)
        shifts = convert.offset or linear.offset
        if convert.converts and linear.converts and shifts:
            raise ScenarioError(
                f"{hop.where}: converts {unit} to {hop.unit} and transforms with an "
                f"offset, and SSP leaves open which comes first; set "
                f"suppressUnitConversion and put both into one transformation"
            )
        whole = whole.then(convert).then(linear)
        changes = linear.converts or (hop.suppress and differ(unit, hop.unit))
        plain = plain and not changes
        unit = hop.unit or (None if changes else unit)
    return whole, plain


def differ(one: Unit | None, other: Unit | None) -> bool:
    """Tell whether two units are known not to be the same."""
    if one is None or other is None or None in (one.base, other.base):
        return False
    return one.base != other.base


def _converted(source: Unit | None, sink: Unit | None, where: str) -> Affine:
    if source is None or sink is None:
        return NOTHING
    try:
        gain, offset, _ = conversion(source, sink)
    except UndefinedUnit:
        return NOTHING
    except UnitError as error:
        raise ScenarioError(f"{where}: {error}") from None
    return Affine(gain, offset)
