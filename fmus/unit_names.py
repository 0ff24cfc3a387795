"""The units that models and scenarios may name: our own table over FMI's base units.

Every unit has its exponents and an exact factor (pi to 36 digits).  Besides the
usual symbols it knows the spellings that exporters write, each with one meaning.
What an FMU defines itself is taken from the FMU, never from here.  Factors: BIPM SI
Brochure, 9th ed. (2019); inch, pound, horsepower: NIST SP 811 (2008), appendix B.
"""

from collections.abc import Mapping
from difflib import get_close_matches
from fractions import Fraction
from functools import cache
from typing import NamedTuple

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
PI = Fraction("3.14159265358979323846264338327950288")
_INCH = Fraction("0.0254")


class Named(NamedTuple):
    """Exponents by base unit, exact factor and offset."""

    exponents: Mapping[str, int]
    factor: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)


def _unit(
    factor: Fraction | str | int = 1, offset: str = "0", **exponents: int
) -> Named:
    return Named(exponents, Fraction(factor), Fraction(offset))


_PREFIXES = {
    **{"P": 15, "T": 12, "G": 9, "M": 6, "k": 3, "h": 2},
    **{"d": -1, "c": -2, "m": -3, "u": -6, "µ": -6, "n": -9, "p": -12, "f": -15},
}
PREFIXED = {  # symbols that take the prefixes
    "m": _unit(m=1),
    "g": _unit("1e-3", kg=1),
    "s": _unit(s=1),
    "A": _unit(A=1),
    "K": _unit(K=1),
    "mol": _unit(mol=1),
    "cd": _unit(cd=1),
    "rad": _unit(rad=1),
    "Hz": _unit(s=-1),
    "N": _unit(kg=1, m=1, s=-2),
    "Pa": _unit(kg=1, m=-1, s=-2),
    "J": _unit(kg=1, m=2, s=-2),
    "W": _unit(kg=1, m=2, s=-3),
    "C": _unit(A=1, s=1),
    "V": _unit(kg=1, m=2, s=-3, A=-1),
    "F": _unit(kg=-1, m=-2, s=4, A=2),
    "ohm": _unit(kg=1, m=2, s=-3, A=-2),
    "S": _unit(kg=-1, m=-2, s=3, A=2),
    "Wb": _unit(kg=1, m=2, s=-2, A=-1),
    "T": _unit(kg=1, s=-2, A=-1),
    "H": _unit(kg=1, m=2, s=-2, A=-2),
    "L": _unit("1e-3", m=3),
    "bar": _unit(100_000, kg=1, m=-1, s=-2),
    "eV": _unit("1.602176634e-19", kg=1, m=2, s=-2),
    "VA": _unit(kg=1, m=2, s=-3),
    "Wh": _unit(3600, kg=1, m=2, s=-2),
    "Ah": _unit(3600, A=1, s=1),
    "Nm": _unit(kg=1, m=2, s=-2),
    "Vs": _unit(kg=1, m=2, s=-2, A=-1),
    "As": _unit(A=1, s=1),
    "Ws": _unit(kg=1, m=2, s=-2),
    "Nms": _unit(kg=1, m=2, s=-1),
}
PLAIN = {  # those that do not
    "1": _unit(),
    "percent": _unit("0.01"),
    "ppm": _unit("1e-6"),
    "min": _unit(60, s=1),
    "h": _unit(3600, s=1),
    "day": _unit(86_400, s=1),
    "deg": _unit(PI / 180, rad=1),
    "arcmin": _unit(PI / 10_800, rad=1),
    "arcsec": _unit(PI / 648_000, rad=1),
    "gon": _unit(PI / 200, rad=1),
    "rev": _unit(2 * PI, rad=1),
    "rpm": _unit(PI / 30, rad=1, s=-1),
    "rps": _unit(2 * PI, rad=1, s=-1),
    "degC": _unit(1, "273.15", K=1),
    "degF": _unit(Fraction(5, 9), str(Fraction("459.67") * 5 / 9), K=1),
    "t": _unit(1000, kg=1),
    "micron": _unit("1e-6", m=1),
    "inch": _unit(_INCH, m=1),
    "ft": _unit("0.3048", m=1),
    "lb": _unit("0.45359237", kg=1),
    "oz": _unit(Fraction("0.45359237") / 16, kg=1),
    "lbf": _unit("4.4482216152605", kg=1, m=1, s=-2),
    "kgf": _unit("9.80665", kg=1, m=1, s=-2),
    "psi": _unit(
        Fraction("4.4482216152605") / Fraction("0.0254") ** 2, kg=1, m=-1, s=-2
    ),
    "atm": _unit(101_325, kg=1, m=-1, s=-2),
    "PS": _unit("735.49875", kg=1, m=2, s=-3),
    "hp": _unit("745.69987158227022", kg=1, m=2, s=-3),
    "kph": _unit(Fraction(5, 18), m=1, s=-1),
    "lpm": _unit(Fraction(1, 60_000), m=3, s=-1),
    "Nmm": _unit("1e-3", kg=1, m=2, s=-2),
    "Ncm": _unit("1e-2", kg=1, m=2, s=-2),
    "kgm": _unit(kg=1, m=1),
    "kgm2": _unit(kg=1, m=2),
    "kgcm2": _unit("1e-4", kg=1, m=2),
    "kgmm2": _unit("1e-6", kg=1, m=2),
    "gcm2": _unit("1e-7", kg=1, m=2),
    "gmm2": _unit("1e-9", kg=1, m=2),
}
_PRODUCTS = {"Nm", "Vs", "As", "Ws", "Nms", "Nmm", "Ncm", "kgm", "Wh", "Ah", "VA"}
_SPELLED = {  # other spellings of the above
    **{"Ω": "ohm", "Ohm": "ohm", "Ohms": "ohm", "ohms": "ohm", "OHM": "ohm"},
    **{"%": "percent", "-": "1", "null": "1", "none": "1", "unitless": "1"},
    **{"°": "deg", "degree": "deg", "degrees": "deg", "Deg": "deg"},
    **{"arcminute": "arcmin", "arcsecond": "arcsec"},
    **{"r": "rev", "U": "rev", "turn": "rev", "turns": "rev", "revs": "rev"},
    **{"revolution": "rev", "revolutions": "rev", "Umdr": "rev", "Rev": "rev"},
    **{"RPM": "rpm", "Rpm": "rpm", "radian": "rad", "radians": "rad", "Rad": "rad"},
    **{"sec": "s", "second": "s", "seconds": "s", "minute": "min", "minutes": "min"},
    **{"hr": "h", "hour": "h", "hours": "h", "d": "day", "days": "day"},
    **{"meter": "m", "metre": "m", "meters": "m", "metres": "m"},
    **{"millimeter": "mm", "micrometer": "um", "kilogram": "kg", "gram": "g"},
    **{"newton": "N", "Newton": "N", "newtons": "N", "volt": "V", "Volt": "V"},
    **{"volts": "V", "ampere": "A", "amp": "A", "Amp": "A", "amps": "A"},
    **{"watt": "W", "Watt": "W", "joule": "J", "pascal": "Pa", "kelvin": "K"},
    **{
        "hertz": "Hz",
        "hz": "Hz",
        "HZ": "Hz",
        "kelvins": "K",
        "degK": "K",
        "Kelvin": "K",
    },
    **{"°C": "degC", "Celsius": "degC", "celsius": "degC", "°F": "degF"},
    **{"l": "L", "ml": "mL", "liter": "L", "litre": "L", "var": "VA"},
    **{"in": "inch", "tonne": "t", "lbs": "lb", "lbm": "lb", "KG": "kg", "Kg": "kg"},
}


@cache
def find(name: str) -> Named | None:
    """Return a unit by its symbol or by another spelling of it."""
    name = name.replace("μ", "µ").replace("\N{OHM SIGN}", "Ω")
    name = _SPELLED.get(name, name)
    if name in PREFIXED:
        return PREFIXED[name]
    if name in PLAIN:
        return PLAIN[name]
    whole = PREFIXED.get(name[1:])
    power = _PREFIXES.get(name[:1])
    if whole is not None and power is not None:
        return whole._replace(factor=whole.factor * Fraction(10) ** power)
    ohm = name.removesuffix("Ω").removesuffix("Ohm")  # kΩ, MOhm
    return find(f"{ohm}ohm") if ohm != name and len(ohm) == 1 else None


def is_product(name: str) -> bool:
    """Tell whether a name runs several units together, as ``kNm`` does."""
    return any(name.removeprefix(p) in _PRODUCTS for p in ("", *_PREFIXES))


def nearest(name: str) -> str:
    """Return a remedy for a unit that is not known."""
    whole = ("N.m", "rad/s", "rad/s2", "m/s", "m/s2", "rev/min", "1/min", "kg.m2")
    prefixed = (f"{p}{name}" for name in (*PREFIXED, "Ohm") for p in "kmu")
    known = [*PLAIN, *_SPELLED, *PREFIXED, *whole, *prefixed]
    near = get_close_matches(name, known, n=3, cutoff=0.5)
    if near:
        return f"did you mean {' or '.join(map(repr, near))}?"
    return f"known are, with the usual prefixes, {', '.join((*PREFIXED, *PLAIN))}"
