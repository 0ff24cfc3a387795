"""A model with other start values: designed gains, say, packed into its FMU."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from fmus.load import BuildError
from fmus.model import Continuous, Model, Record, is_record, leaves

Value: TypeAlias = float | bool | tuple[float, ...]
ELEMENT = re.compile(r"(.+)\[([\d,]+)\]")


@dataclass(frozen=True)
class Preset:
    """What replaces a model's own: its period (s) and start values by FMI name.

    ``origin`` tells a reader where the values come from.
    """

    period: Fraction | None = None
    values: Mapping[str, Value] = field(default_factory=dict)
    origin: str = ""


def preset(model: Model, wanted: Preset) -> Model:
    """Return the model with period and start values of the preset.

    Raises:
        BuildError: a period that it does not take, a name that it does not have, a
            constant, or a value of another size.
    """
    if wanted.period is not None:
        if isinstance(model, Continuous):
            raise BuildError(
                f"{model.name} is continuous and has no period: it takes any step; "
                f"its longest substep is h_max = {model.h_max} s"
            )
        if model.period_fixed and wanted.period != model.period:
            raise BuildError(
                f"{model.name} is sampled every {model.period} s alone, which its "
                f"numbers are designed for: a period of {wanted.period} s takes "
                f"another design"
            )
        model = replace(model, period=wanted.period)
    if not wanted.values:
        return model
    left = dict(wanted.values)
    records = {
        role: _filled(getattr(model, role), left, prefix, model.name)
        for role, prefix in (("parameters", ""), ("input", ""), ("state", "state."))
    }
    if left:
        raise BuildError(
            f"{model.name} has no parameter, input or state {', '.join(sorted(left))}"
        )
    return replace(model, **records)


def _filled(record: Record, left: dict[str, Value], prefix: str, model: str) -> Record:
    """Put values into a record; those that found their place leave ``left``."""
    var = {leaf.name: leaf for leaf in leaves(record, prefix)}
    elements: dict[str, dict[tuple[int, ...], Value]] = {}
    for name in list(left):
        match = ELEMENT.fullmatch(name)
        whole = match[1] if match and match[1] in var else name
        if whole not in var:
            continue
        if var[whole].var.constant:
            raise BuildError(f"{model}: {name} is a constant")
        index = tuple(int(i) - 1 for i in match[2].split(",")) if match else ()
        elements.setdefault(whole, {})[index] = left.pop(name)

    values = iter(
        [
            _value(f"{model}: {leaf.name}", leaf.value, elements.get(leaf.name))
            for leaf in var.values()
        ]
    )

    def fill(record: Record) -> Record:
        return record._make(fill(v) if is_record(v) else next(values) for v in record)

    return fill(record)


def _value(where: str, old: Any, new: Mapping[tuple[int, ...], Value] | None) -> Any:
    if new is None:
        return old
    if isinstance(old, bool):
        return bool(new[()])
    array = np.array(old, dtype=float)
    for index, value in new.items():
        given = np.asarray(value, dtype=float)
        try:
            array[index] = given.reshape(array[index].shape)
        except (IndexError, ValueError):
            size = f"{array.size} elements, not {given.size} at {index or 'all'}"
            raise BuildError(f"{where} has {size}") from None
    return array if array.shape else float(array)
