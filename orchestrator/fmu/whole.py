"""Whole numbers of inputs: rounded and kept in their range by a map, or looked up."""

from dataclasses import dataclass
from math import floor, isfinite, isnan

from orchestrator.errors import WiringError
from orchestrator.fmu.description import FmuVariable
from orchestrator.system import Component, Mapped, Range


@dataclass(frozen=True)
class Whole:
    """Whole numbers from ``low`` to ``high``, and what becomes of others there."""

    law: Range
    low: float
    high: float

    def of(self, value: float) -> float:
        """Return a number rounded, half a one upwards, and brought into the range.

        Raises:
            ValueError: it is none, or has more digits than a double holds.
        """
        whole = floor(value + 0.5) if isfinite(value) else value
        if self.law == "saturate" and not isnan(whole):
            return float(min(max(whole, self.low), self.high))
        if not abs(whole) < 2**53:
            raise ValueError(f"{value} is no number that could be wrapped")
        return self.low + (whole - self.low) % (self.high - self.low + 1)


@dataclass(frozen=True)
class Listed:
    """What becomes of some whole numbers; no others are taken."""

    pairs: tuple[tuple[int, int], ...]

    def of(self, value: float) -> float:
        """Return what a number becomes.

        Raises:
            ValueError: it is not listed.
        """
        for given, becomes in self.pairs:
            if value == given:
                return becomes
        listed = ", ".join(str(given) for given, _ in self.pairs)
        raise ValueError(f"{value:g} is none of {listed}, which its table lists")


def listed_of(
    component: Component, variable: FmuVariable, mapped: Mapped, fmi_major: int
) -> Listed | None:
    """Return the table by which a map looks up what an input gets.

    Raises:
        WiringError: it is no input of whole numbers or switches, or does not take
            what is listed.
    """
    if mapped.table is None:
        return None
    where = f"components.{component.name}.map: {mapped.name} is {variable.kind}"
    if variable.causality != "input" or variable.sort not in ("integer", "boolean"):
        raise WiringError(
            f"{where} {variable.causality}, and a table is for inputs that are "
            f"integers, switches or enumerations; remove it"
        )
    items = {item.value for item in variable.declared.items}
    low, high = _bounds(variable, fmi_major)
    for _, becomes in mapped.table:
        if becomes not in items if items else not low <= becomes <= high:
            takes = f"items {sorted(items)}" if items else f"{low:.0f} to {high:.0f}"
            raise WiringError(f"{where} and takes {takes}, not {becomes}")
    return Listed(mapped.table)


def whole_of(
    component: Component, variable: FmuVariable, mapped: Mapped, fmi_major: int
) -> Whole | None:
    """Return the range of an integer input of which a map says how it is kept.

    Raises:
        WiringError: it is no input, or no integer of at most 32 bits.
    """
    if mapped.range is None:
        return None
    where = f"components.{component.name}.map: {mapped.name} is {variable.kind}"
    is_integer = variable.sort == "integer" and not variable.declared.items
    if variable.causality != "input" or not is_integer:
        raise WiringError(
            f"{where} {variable.causality}, and range = {mapped.range!r} is for "
            f"integer inputs; remove it"
        )
    if variable.dtype != "float64":
        raise WiringError(f"{where}, and range is for integers of at most 32 bits")
    return Whole(mapped.range, *_bounds(variable, fmi_major))


def _bounds(variable: FmuVariable, fmi_major: int) -> tuple[float, float]:
    if variable.sort == "boolean":
        return 0, 1
    if variable.declared.items:
        return -(2**53), 2**53
    bits = 32 if fmi_major == 2 else int(variable.fmi_type.rpartition("t")[2])
    low, high = (
        (0, 2**bits - 1)
        if variable.fmi_type[0] == "U"
        else (
            -(2 ** (bits - 1)),
            2 ** (bits - 1) - 1,
        )
    )
    ends = (variable.min, low), (variable.max, high)
    least, most = (float(written) if written else end for written, end in ends)
    return least, most
