"""What a variable measures: quantity, display unit, usual size, natural bound.

Written once per unit; a field's own ``Var`` goes before.  Usual sizes are those of
machine-tool axes: a millimetre of travel between communication points and in
deflections, a tenth of a radian at the screw, so that a solver's tolerance sees
micrometres.  Units of gains, filters and fits measure no named quantity.
"""

from typing import NamedTuple

from fmus.layout import Variable


class Kind(NamedTuple):
    """``usual`` is the nominal value of signals; ``shown`` the display unit."""

    quantity: str | None = None
    usual: float = 1.0
    shown: str | None = None


KINDS = {
    "m": Kind("Length", 1e-3, "mm"),
    "mm": Kind("Length", 1.0),
    "um": Kind("Length", 1.0),
    "m/s": Kind("Velocity", 0.1, "mm/s"),
    "mm/s": Kind("Velocity", 10.0),
    "m/s2": Kind("Acceleration", 1.0),
    "m/s3": Kind("Jerk", 1e2),
    "m/s4": Kind("Snap", 1e5),
    "rad": Kind("Angle", 0.1, "deg"),
    "rad/s": Kind("AngularVelocity", 10.0, "1/min"),
    "rad/s2": Kind("AngularAcceleration", 1e3),
    "rad/s3": Kind("AngularJerk", 1e5),
    "rad/s4": Kind("AngularSnap", 1e7),
    "s": Kind("Time", 1e-3, "ms"),
    "Hz": Kind("Frequency", 1e2),
    "kg": Kind("Mass", 10.0),
    "kg.m2": Kind("MomentOfInertia", 1e-3),
    "kg/m3": Kind("Density", 1e3),
    "N": Kind("Force", 1e2),
    "N.m": Kind("Torque", 1.0),
    "N/m": Kind("Stiffness", 1e8),
    "N.m/rad": Kind("RotationalStiffness", 1e2),
    "N.s/m": Kind("DampingCoefficient", 1e3),
    "N.m.s/rad": Kind("RotationalDampingCoefficient", 1e-2),
    "N.m/A": Kind("TorqueConstant", 1.0),
    "V": Kind("ElectricPotential", 1.0),
    "A": Kind("ElectricCurrent", 1.0),
    "J": Kind("Energy", 1.0),
    "ohm": Kind("Resistance", 1.0),
    "H": Kind("Inductance", 1e-2),
    "Pa": Kind("Pressure", 1e9),
    "V.s2/m": Kind(None, 1.0),
    "A.s/mm": Kind(None, 1.0),
    "m.s": Kind(None, 1e-4),
    "rad.s": Kind(None, 1e-2),
    "A.s": Kind(None, 1e-2),
    "N.s": Kind(None, 1.0),
    "N.s2": Kind(None, 1e-2),
    "1/s": Kind("Frequency", 1e6),  # increments of an encoder; a gain has none
    "1": Kind(None, 1.0),
}
# what a display unit is of the unit: shown = factor * value
FACTORS = {
    ("m", "mm"): 1e3,
    ("m", "um"): 1e6,
    ("m/s", "mm/s"): 1e3,
    ("rad", "deg"): 57.29577951308232,
    ("rad/s", "1/min"): 9.549296585513721,
    ("s", "ms"): 1e3,
}
SMALL = 1e-5  # m: shown in micrometres
NEVER_NEGATIVE = ("Hz", "kg", "kg.m2", "kg/m3", "H", "ohm", "N.m/A")
SIGNALS = ("input", "output", "state")


def quantity(variable: Variable) -> str | None:
    """Return the name of what a variable measures, None if it has none."""
    return None if variable.boolean else _kind(variable).quantity


def nominal(variable: Variable) -> float | None:
    """Return the usual size of a signal or state, None of anything else."""
    if variable.boolean or variable.var.nominal is not None:
        return variable.var.nominal
    return _kind(variable).usual if variable.block in SIGNALS else None


def shown(variable: Variable) -> str | None:
    """Return the unit a tool should show a variable in, None: its own."""
    if variable.boolean:
        return None
    usual = variable.var.nominal
    if variable.var.unit == "m" and usual is not None and usual <= SMALL:
        return "um"
    return _kind(variable).shown


def bounds(variable: Variable) -> tuple[float | None, float | None]:
    """Return the bounds of a variable: its own, and what nature forbids."""
    low, high = variable.var.min, variable.var.max
    natural = variable.block == "parameter" and variable.var.unit in NEVER_NEGATIVE
    positive = all(start >= 0 for start in variable.start)
    return (0.0 if low is None and natural and positive else low), high


def why_empty(variable: Variable, cell: str) -> str | None:
    """Return why a variable has no such cell, None if it should have one.

    ``cell`` is "quantity", "nominal", "display", "min" or "max".
    """
    if variable.boolean:
        return "a switch"
    match cell:
        case "quantity":
            known = variable.var.unit in KINDS and _kind(variable).quantity
            return None if known else "its unit names a ratio, not a quantity"
        case "nominal":
            signal = variable.block in SIGNALS
            return None if signal else "its start or its state tells the size"
        case "display":
            return "shown in its own unit"
        case _ if variable.var.constant:
            return "a constant"
        case "min" if variable.block == "parameter":
            return "either sign has a meaning"
        case "min" if variable.block in SIGNALS:
            return "a signal of either sign"
        case "max" if variable.block in SIGNALS:
            return "the drive limits it, not nature"
        case "min" | "max":
            return "nature sets no bound"
    return None


def _kind(variable: Variable) -> Kind:
    if variable.var.unit == "1/s" and variable.block not in SIGNALS:
        return Kind()
    return KINDS.get(variable.var.unit, Kind())
