"""Clocks of an FMI 3.0 FMU: which the master ticks, and why it does not tick another.

An FMU with one input clock of a fixed period, and no other input clock, is sampled by
it: the master activates it in event mode.  No importer can tick an FMU for
co-simulation that declares no event mode: it runs, and a warning says so.  Clocks that
are outputs tick by themselves and carry no value.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from orchestrator.quantities.quantity import exact


@dataclass(frozen=True)
class Clock:
    """One of them; ``period`` and ``shift`` (s) where they are fixed beforehand.

    ``tickable``: there is a mode in which an importer could activate it.
    """

    name: str
    reference: int
    is_input: bool
    variability: str
    period: Fraction | None
    shift: Fraction
    tickable: bool


def clocks_of(root: Any) -> Mapping[str, Clock]:
    """Return the clocks of a model description by their names.

    Raises:
        ValueError: an interval or shift is none.
    """
    told = root.find("CoSimulation")
    events = told is None or told.get("hasEventMode") in ("true", "1")
    found = {}
    for one in root.iterfind("ModelVariables/Clock"):
        variability = one.get("intervalVariability", "")
        fixed = variability in ("constant", "fixed")
        period = _time(one, "interval") if fixed else None
        found[one.get("name")] = Clock(
            one.get("name"),
            int(one.get("valueReference")),
            one.get("causality") == "input",
            variability,
            period if period and period > 0 else None,
            _time(one, "shift") or Fraction(0),
            events,
        )
    return found


def _time(one: Any, key: str) -> Fraction | None:
    counter, resolution = one.get(f"{key}Counter"), one.get("resolution")
    if counter and resolution and one.get("supportsFraction") in ("true", "1"):
        return Fraction(int(counter), int(resolution))
    decimal = one.get(f"{key}Decimal")
    return exact(decimal) if decimal else None


def ticked(clocks: Mapping[str, Clock], root: Any) -> Clock | None:
    """Return the clock that the master ticks."""
    inputs = [clock for clock in clocks.values() if clock.is_input and clock.tickable]
    told = root.find("CoSimulation")
    if told is None or len(inputs) != 1 or inputs[0].period is None or inputs[0].shift:
        return None
    return inputs[0]


def left_alone(clocks: Mapping[str, Clock]) -> list[str]:
    """Return the input clocks that no importer could tick."""
    return [c.name for c in clocks.values() if c.is_input and not c.tickable]


def unticked(clocks: Mapping[str, Clock]) -> str | None:
    """Return what of an FMU would never tick, in words; of one that is not ticked."""
    inputs = [clock for clock in clocks.values() if clock.is_input and clock.tickable]
    if not inputs:
        return None
    if len(inputs) > 1:
        names = ", ".join(clock.name for clock in inputs)
        return f"has the input clocks {names}, and one only is ticked"
    clock = inputs[0]
    if clock.period is None:
        return (
            f"has the input clock {clock.name}, {clock.variability or 'of no kind'}, "
            f"and only clocks of a constant or fixed interval are ticked"
        )
    if clock.shift:
        return (
            f"has the input clock {clock.name}, shifted by {clock.shift} s, and only "
            f"clocks that begin at 0 are ticked"
        )
    return (
        f"has the input clock {clock.name} and no co-simulation, in whose event mode "
        f"it could be ticked"
    )
