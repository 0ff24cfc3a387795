"""What a model description says of its variables, their declared types included.

A variable has the attributes of its type (``declaredType``) where it gives none of
its own.  Refused is what makes a value ambiguous: a value reference that is none, a
name twice, a dimension below 1, two model descriptions, a ``modelIdentifier`` that is
a path.  Everything else that breaks the standard is for ``check`` to find.  Documents
come without comments and processing instructions.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, prod
from pathlib import Path
from typing import Any

from fmus.unit_names import BASE
from fmus.units import BaseUnit
from orchestrator.errors import FmuError
from orchestrator.fmu.archive import checked_members

REFERENCES = 2**32  # of UInt32
MOST_NUMBERS = 10_000_000  # of all variables of an FMU


@dataclass(frozen=True)
class Item:
    """One value of an enumeration, and its name."""

    name: str
    value: int


@dataclass(frozen=True)
class Declared:
    """Attributes of one variable; ``starts`` has one word per number or text.

    A dimension is a number or the value reference of a structural parameter, as text.
    """

    min: str | None = None
    max: str | None = None
    nominal: str | None = None
    quantity: str | None = None
    relative: bool = False
    items: tuple[Item, ...] = ()
    starts: tuple[str, ...] = ()
    dimensions: tuple[int | str, ...] = ()


def declared(root: Any) -> dict[str, Declared]:
    """Return the attributes of every variable by its name."""
    types = {}
    for type_ in root.iterfind("TypeDefinitions/*"):
        own = type_[0] if type_.tag == "SimpleType" and len(type_) else type_
        types[type_.get("name")] = own
    return {v.get("name"): _declared(v, types) for v in _variables(root)}


def _declared(variable: Any, types: Mapping[str, Any]) -> Declared:
    own = (
        variable[0] if variable.tag == "ScalarVariable" and len(variable) else variable
    )
    type_ = types.get(own.get("declaredType"))

    def said(key: str) -> str | None:
        written = own.get(key)
        inherited = type_.get(key) if type_ is not None else None
        return str(written or inherited) if written or inherited else None

    items = type_.iterfind("Item") if type_ is not None else ()
    return Declared(
        said("min"),
        said("max"),
        said("nominal"),
        said("quantity"),
        said("relativeQuantity") in ("true", "1"),
        tuple(
            Item(item.get("name", ""), int(item.get("value", position)))
            for position, item in enumerate(items, 1)
        ),
        _starts(own),
        tuple(
            int(d.get("start")) if d.get("start") else str(d.get("valueReference"))
            for d in variable.iterfind("Dimension")
        ),
    )


def _starts(element: Any) -> tuple[str, ...]:
    """Return the start values; texts of FMI 3.0 stand in elements of their own."""
    inside = [start.get("value", "") for start in element.iterfind("Start")]
    written = element.get("start")
    if inside or written is None:
        return tuple(inside)
    return (written,) if element.tag == "String" else tuple(written.split())


def units(definitions: Sequence[Any]) -> Iterator[tuple[str, BaseUnit]]:
    """Yield every unit that is defined; a factor of zero defines nothing."""
    for unit in definitions:
        written = unit.baseUnit
        if written is None:
            continue
        factor, offset = float(written.factor), float(written.offset)
        if factor and isfinite(factor) and isfinite(offset):
            exponents = {name: int(getattr(written, name) or 0) for name in BASE}
            yield unit.name, BaseUnit(**exponents, factor=factor, offset=offset)


def refuse_two_descriptions(path: Path) -> None:
    """Refuse an archive of which two tools may read different descriptions.

    Raises:
        FmuError: there are several files modelDescription.xml.
    """
    members = [member.filename.casefold() for member in checked_members(path)]
    if members.count("modeldescription.xml") > 1:
        raise FmuError(
            f"{path}: holds several files modelDescription.xml; ask its supplier for a "
            f"valid export"
        )


def refuse_other_fmi(path: Path, root: Any) -> None:
    """Refuse, by FmuError, a model description whose root is not FMI 2.0 or 3.0."""
    version = str(root.get("fmiVersion"))
    if not version.startswith(("2.", "3.")):
        raise FmuError(
            f"{path}: is FMI {version}, which is not supported; ask for an export as "
            f"FMI 2.0 or 3.0"
        )


def refuse_vast(path: Path, md: Any) -> None:
    """Refuse arrays for which there would be no room.

    Raises:
        FmuError: all variables together are more numbers than are accepted.
    """
    total = sum(prod(v.shape or ()) for v in md.modelVariables)
    if total > MOST_NUMBERS:
        raise FmuError(
            f"{path}: its variables are {total} numbers; at most {MOST_NUMBERS} are "
            f"accepted"
        )


def refuse_ambiguous(path: Path, root: Any) -> None:
    """Refuse a model description in which a value may mean several things.

    Raises:
        FmuError: see the contract above.
    """
    for fault in _ambiguous(root):
        raise FmuError(f"{path}: {fault}; ask its supplier for a valid export")


def _ambiguous(root: Any) -> Iterator[str]:
    for interface in ("CoSimulation", "ModelExchange", "ScheduledExecution"):
        for element in root.iterfind(interface):
            identifier = element.get("modelIdentifier", "")
            if set(identifier) & set("/\\:") or identifier in (".", ".."):
                yield f"modelIdentifier {identifier!r} is a path, not a name"
    aliases = list(root.iterfind("ModelVariables/*/Alias"))
    for element in (*root.iterfind("ModelVariables/*"), *aliases):
        if not element.get("name"):
            yield f"a {element.tag} of ModelVariables has no name"
    names = Counter(v.get("name") for v in (*_variables(root), *aliases))
    twice = next((name for name, count in names.items() if count > 1), None)
    if twice is not None:
        yield f"two variables have the name {twice!r}"
    sizes = {}
    for variable in _variables(root):
        name, written = variable.get("name"), variable.get("valueReference", "")
        if not written.isdecimal() or int(written) >= REFERENCES:
            yield f"{name}: valueReference {written!r} is no number from 0 to 2^32 - 1"
        sizes[written] = variable.get("start", "")
    for variable in _variables(root):
        for dimension in variable.iterfind("Dimension"):
            size = dimension.get("start") or sizes.get(
                dimension.get("valueReference", ""), ""
            )
            if not size.isdecimal() or int(size) < 1:
                yield (
                    f"{variable.get('name')}: a dimension of {size or 'no size'} is "
                    f"not allowed; the least is 1"
                )


def _variables(root: Any) -> Iterator[Any]:
    """Yield the variables of FMI 2.0 or 3.0, of which aliases are no part."""
    yield from root.iterfind("ModelVariables/*[@name]")
