"""Rates that a scenario names, where a period may stand."""

import re
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from pydantic import ValidationInfo

from orchestrator.errors import did_you_mean
from orchestrator.quantities.quantity import parse_period


@dataclass
class RateContext:
    """The rates of the scenario being validated, and whether they could be read."""

    rates: dict[str, Fraction] = field(default_factory=dict)
    readable: bool = True


def named_period(value: Any, info: ValidationInfo) -> Fraction:
    """Return a period (s) written as a time, a rate, or the name of one.

    Raises:
        ValueError: it is none of these.
    """
    rates = info.context.rates if info.context else {}
    if isinstance(value, str) and value in rates:
        period: Fraction = rates[value]
        return period
    if isinstance(value, str) and re.fullmatch(r"[A-Za-z_]\w*", value):
        if info.context and not info.context.readable:
            return Fraction(1)  # the scenario is refused for its rates alone
        raise ValueError(f"there is no rate {value!r}; {did_you_mean(value, rates)}")
    return parse_period(value)
