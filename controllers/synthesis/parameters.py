"""Parameters by name: from plain numbers to the records of models."""

from collections.abc import Mapping
from typing import Any, TypeVar, get_type_hints

from fmus.model import Record, inner_prefix, is_record, leaves

R = TypeVar("R")


def with_values(record: R, values: Mapping[str, Any]) -> R:
    """Return the record with some fields replaced, nested ones as ``outer.inner``.

    Raises:
        LookupError: the record has no field of that name.
    """
    known = [leaf.name for leaf in leaves(record)]
    for name in values:
        if name not in known:
            raise LookupError(f"no parameter {name!r}, there are {', '.join(known)}")

    def replace(part: Any, prefix: str) -> Any:
        hints = get_type_hints(type(part), include_extras=True)
        return part._make(
            replace(value, inner_prefix(hints[name], prefix, name))
            if is_record(value)
            else values.get(prefix + name, value)
            for name, value in zip(part._fields, part, strict=True)
        )

    replaced: R = replace(record, "")
    return replaced


def share(
    parameters: Mapping[str, Any], records: Mapping[str, Record]
) -> tuple[Record, ...]:
    """Give every parameter to all records that have it, or to the one it names.

    Args:
        parameters: ``name`` or ``record.name`` -> value.
        records: the records to fill, by the name that addresses each.

    Returns:
        The records in their order, filled.

    Raises:
        LookupError: no record has a parameter of that name.
    """
    fields = {key: {leaf.name for leaf in leaves(r)} for key, r in records.items()}
    given: dict[str, dict[str, Any]] = {key: {} for key in records}
    for name, value in parameters.items():
        key, _, rest = name.partition(".")
        targets = [k for k in records if name in fields[k]]
        if key in records and rest in fields[key]:
            targets, name = [key], rest
        if not targets:
            raise LookupError(f"no parameter {name!r} in {' or '.join(records)}")
        for target in targets:
            given[target][name] = value
    return tuple(with_values(records[key], given[key]) for key in records)
