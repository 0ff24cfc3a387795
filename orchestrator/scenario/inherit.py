"""How a layer lies over its base: table by table; ``false`` removes an entry.

Of a connection for which nothing, or a switch, is inherited it is the constant false.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from orchestrator.scenario.last import put_last
from orchestrator.scenario.takeover import TABLES

REMOVABLE = (
    *("components", "connections", "faults", "groups", "design"),
    *("record", "metrics", "responses", "expect"),
)


def inherit(base: Mapping[str, Any], layer: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a base with those of its heir over them, each anew."""
    merged = _merge(base, layer)
    _last_values(merged, base, layer)
    for table in REMOVABLE:
        entries = merged.get(table)
        if not isinstance(entries, dict):
            continue
        gone = [
            key
            for key, value in entries.items()
            if value is False
            and not (table == "connections" and _is_switch(base, merged, key))
        ]
        merged[table] = {k: v for k, v in entries.items() if k not in gone}
        if table == "components":
            _detach(merged, gone, layer)
    return merged


def _is_switch(base: Mapping[str, Any], merged: Mapping[str, Any], sink: str) -> bool:
    """Tell whether ``false`` is the value of a sink: what it had is no source."""
    inherited = _table(base, "connections").get(sink, False)
    owner = sink.partition(".")[0]
    before, now = (owner in _table(t, "components") for t in (base, merged))
    return isinstance(inherited, bool) and not (before and not now)


def _table(tables: Mapping[str, Any], name: str) -> dict[str, Any]:
    found = tables.get(name)
    return found if isinstance(found, dict) else {}


def _last_values(
    merged: dict[str, Any], base: Mapping[str, Any], layer: Mapping[str, Any]
) -> None:
    """Let what the layer says of parameters and start lie over what it inherits."""
    components = layer.get("components", {})
    for name, own in components.items() if isinstance(components, dict) else ():
        both = merged["components"][name]
        if name not in _table(base, "components") or not isinstance(both, dict):
            continue
        found = {table: both[table] for table in TABLES if table in both}
        if not all(isinstance(values, dict) for values in found.values()):
            continue  # refused when the scenario is validated
        both |= {table: dict(values) for table, values in found.items()}
        said = [(table, key) for table in TABLES for key in own.get(table, {})]
        keys = [key for _, key in said]
        for table, key in said:
            if keys.count(key) == 1:  # else refused when it is validated
                put_last(both, table, key, found[table][key])


def _detach(
    merged: dict[str, Any], gone: Sequence[str], layer: Mapping[str, Any]
) -> None:
    """Drop the inherited connections and records of components that were removed."""
    for table in ("connections", "faults", "record"):
        own = layer.get(table, {})
        entries = merged.get(table, {})
        if not isinstance(entries, dict):
            continue  # refused when the scenario is validated
        merged[table] = {
            key: value
            for key, value in entries.items()
            if key in own
            or not any(
                str(end).startswith(f"{component}.")
                for component in gone
                for end in (key, value)
            )
        }


def _merge(base: Mapping[str, Any], layer: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in layer.items():
        old = merged.get(key)
        both = isinstance(old, dict) and isinstance(value, dict)
        merged[key] = _merge(old, value) if both else value  # type: ignore[arg-type]
    return merged
