"""Whole numbers of integer inputs: rounded, and kept in their range by a map."""

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
    return Whole(mapped.range, least, most)
