"""What a value has to be for a variable of each type of FMI 2.0 and 3.0.

    Real, Float64, Float32   a finite number (Float32: within its range)
    integers                 a whole number within the type's range, of any size
    Boolean                  true, false, 0 or 1
    Enumeration              the name of an item, or its number
    String                   a text
    Binary                   a text of hexadecimal digits, as in FMI's descriptions

Nothing is cut or rounded; minimum and maximum of variable or type hold.
"""

from fractions import Fraction
from math import inf, isfinite
from typing import TypeAlias

import numpy as np

from orchestrator.errors import WiringError, did_you_mean
from orchestrator.fmu.description import FmuVariable
from orchestrator.fmu.ports import Affine, Port
from orchestrator.quantities.quantity import exact
from orchestrator.system import Scalar

Held: TypeAlias = float | str | bytes  # what an FMU is given and gives back

_FLOAT32_MAX = float(np.finfo(np.float32).max)
_FRACTIONS = {
    "Real": (-inf, inf),
    "Float64": (-inf, inf),
    "Float32": (-_FLOAT32_MAX, _FLOAT32_MAX),
}


def bounds(fmi_type: str, fmi_major: int) -> tuple[float, float]:
    """Return the least and the greatest number of an FMI type."""
    if fmi_type in _FRACTIONS:
        return _FRACTIONS[fmi_type]
    if fmi_type == "Boolean":
        return 0, 1
    if fmi_type in ("Integer", "Enumeration"):
        bits = 32 if fmi_major == 2 else 64
    else:
        bits = int(fmi_type.rpartition("t")[2])
    if fmi_type.startswith("U"):
        return 0, 2**bits - 1
    return -(2 ** (bits - 1)), 2 ** (bits - 1) - 1


def fits(fmi_type: str, fmi_major: int, value: float) -> bool:
    """Tell whether an FMI type holds a number (Float32: rounded)."""
    if fmi_type in ("Real", "Float64"):
        return True
    low, high = bounds(fmi_type, fmi_major)
    return low <= value <= high and (fmi_type == "Float32" or value == value // 1)


def held(where: str, port: Port, given: Scalar, fmi_major: int) -> Held:
    """Return a value as an FMU's own.

    Raises:
        WiringError: it is none of the variable's type, or out of its bounds.
    """
    variable = port.variable
    wrong = f"{where} = {_written(given)}: {port.full_name} is {variable.kind}"
    if variable.is_text:
        return _text(wrong, variable, given)
    if variable.declared.items:
        return _item(wrong, variable, given)
    if isinstance(given, str):
        raise WiringError(f"{wrong}; give {_asked(port)}, not a text")
    if isinstance(given, bool) and variable.sort != "boolean":
        raise WiringError(f"{wrong} and no switch; give {_asked(port)}")
    if not _is_finite(given, variable):
        raise WiringError(f"{wrong}; give a finite number")
    return _number(wrong, port, given, fmi_major)


def _number(wrong: str, port: Port, given: float, fmi_major: int) -> float:
    variable, affine = port.variable, port.to_theirs
    number = _applied(affine, given)
    if not fits(variable.fmi_type, fmi_major, number):
        low, high = bounds(variable.fmi_type, fmi_major)
        became = f", and {number!r} there" if affine.converts else ""
        asked = (
            "true or false" if (low, high) == (0, 1) else _range(variable, low, high)
        )
        raise WiringError(f"{wrong}{became}; give {asked}")
    for bound, word in ((variable.min, "least"), (variable.max, "most")):
        limit = _limit(bound, variable.sort)
        if limit is None:
            continue
        beyond = Fraction(number) - limit
        if beyond < 0 if word == "least" else beyond > 0:
            unit = f" {variable.unit}" if variable.unit else ""
            raise WiringError(
                f"{wrong.partition(':')[0]}: the FMU allows at {word} {bound}{unit}"
            )
    return number if variable.sort == "real" else int(number)


def _is_finite(given: float, variable: FmuVariable) -> bool:
    try:
        return isfinite(given)
    except OverflowError:  # a whole number beyond all floats
        return variable.sort != "real"


def _applied(affine: Affine, given: float) -> float:
    return affine.gain * given + affine.offset if affine.converts else given


def _limit(bound: str | None, sort: str) -> Fraction | None:
    """Return a bound as the FMU has it: of a real number the nearest double."""
    try:
        limit = exact(bound.strip()) if bound else None
        return Fraction(float(limit)) if limit is not None and sort == "real" else limit
    except (ValueError, OverflowError):  # an infinity bounds nothing
        return None


def _text(wrong: str, variable: FmuVariable, given: Scalar) -> Held:
    if not isinstance(given, str):
        raise WiringError(f"{wrong}; give a text in quotes")
    if variable.sort == "string":
        return given
    try:
        return bytes.fromhex(given)
    except ValueError:
        raise WiringError(
            f'{wrong}; give its bytes as hexadecimal digits, such as "00 ff"'
        ) from None


def _item(wrong: str, variable: FmuVariable, given: Scalar) -> int:
    items = variable.declared.items
    for item in items:
        asked = item.name if isinstance(given, str) else item.value
        if given == asked and not isinstance(given, bool):
            return item.value
    listed = ", ".join(f"{item.name} ({item.value})" for item in items)
    if isinstance(given, str):
        listed = did_you_mean(given, [item.name for item in items])
        raise WiringError(f"{wrong} without this item; {listed}")
    raise WiringError(f"{wrong}; its items are {listed}")


def _asked(port: Port) -> str:
    if port.variable.sort == "boolean":
        return "true or false"
    if port.variable.sort == "integer":
        return "a whole number"
    return f"a number in {port.unit or '1'}"


def _range(variable: FmuVariable, low: float, high: float) -> str:
    kind = "number" if variable.sort == "real" else "whole number"
    return f"a {kind} from {low} to {high}"


def _written(given: Scalar) -> str:
    if isinstance(given, bool):
        return str(given).lower()
    return f'"{given}"' if isinstance(given, str) else repr(given)
