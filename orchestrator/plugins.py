"""What other packages add: entry points of their ``pyproject.toml``, by group.

    feeddrive.models    a package whose public modules are models
    feeddrive.metrics   f(time, values, unit, **arguments) -> {figure: (value, unit)}
    feeddrive.checks    a module that registers items with ``@static`` and ``@dynamic``
    feeddrive.peers     an ``orchestrator.peers.environment.Peer``
    feeddrive.writers   f(tables, target), by the suffix that the entry is named after

Who installs such a package has chosen to execute it; without an entry point nothing
of an installed package is.
"""

from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

from orchestrator.errors import PluginError

Group: TypeAlias = Literal["models", "metrics", "checks", "peers", "writers"]


@cache
def named(group: Group) -> Mapping[str, EntryPoint]:
    """Return the entry points of a group by name, none of them imported.

    Raises:
        PluginError: two packages use one name.
    """
    found: dict[str, EntryPoint] = {}
    for entry in entry_points(group=f"feeddrive.{group}"):
        if (other := found.get(entry.name)) is not None and other.value != entry.value:
            raise PluginError(
                f"feeddrive.{group}: {entry.name} is added by {_package(other)} and by "
                f"{_package(entry)}; uninstall one of them"
            )
        found[entry.name] = entry
    return MappingProxyType(found)


def load(group: Group, name: str) -> Any:
    """Return what an entry point names.

    Raises:
        PluginError: it cannot be imported; the message names its package.
    """
    entry = named(group)[name]
    try:
        return entry.load()
    except Exception as error:
        raise PluginError(
            f"{_package(entry)} adds {name} to feeddrive.{group}, but {entry.value} "
            f"cannot be imported: {type(error).__name__}: {error}"
        ) from error


def _package(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist is not None else entry.value
