"""How late an answer may be by what is known of the components on its way."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from fmus.load import load_model
from orchestrator.fmu.start_values import start_values
from orchestrator.response.places import Rates
from orchestrator.scenario.compose import Composition


@dataclass(frozen=True)
class Late:
    """The longest time (s) that periods, offsets, latencies and dead times add up to.

    ``whole`` says that all models are ours, so that no dead time is unknown.
    """

    seconds: Fraction
    whole: bool


def lateness(composition: Composition, rates: Rates) -> Late:
    """Return how late anything may come that goes through all on the way once."""
    seconds, whole = Fraction(0), True
    for name in rates.way:
        part = composition.system.components[name]
        seconds += part.period * (1 + part.latency) + part.offset
        if composition.sources[name].endswith(".fmu"):
            whole = False
        else:
            seconds += max(_dead_times(composition, name), default=Fraction(0))
    return Late(seconds, whole)


def _dead_times(composition: Composition, name: str) -> Iterator[Fraction]:
    fmu = composition.fmus[name]
    given = start_values(composition.system.components[name], fmu)
    written = {variable.name: values for variable, values in given}
    delay = getattr(load_model(composition.module(name)), "delay", {})
    for tau in set(delay.values()):
        variable = fmu.variables[tau]
        values = written.get(tau) or (variable.start or "0").split()
        yield from (Fraction(repr(float(value))) for value in values)
