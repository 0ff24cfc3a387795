"""All items there are, by number; importing this registers them."""

from functools import cache

from orchestrator.checks import (
    compiling,
    dependencies,
    derivatives,
    exchange,
    extra,
    files,
    hosting,
    loading,
    resimulation,
    sources,
    states,
    stepping,
    values,
    variables,
)
from orchestrator.checks.item import REGISTRY, Item
from orchestrator.errors import PluginError
from orchestrator.plugins import load, named

MODULES = (
    compiling,
    dependencies,
    derivatives,
    exchange,
    extra,
    files,
    hosting,
    loading,
    resimulation,
    sources,
    states,
    stepping,
    values,
    variables,
)

FIRST_OF_OTHERS = 100  # numbers of items that other packages add


def catalogue() -> list[Item]:
    """Return all items by number, the static one of a number first.

    Raises:
        PluginError: what another package adds is no module of items, or takes a number
            of ours.
    """
    _of_others()
    return sorted(REGISTRY.values(), key=lambda i: (i.number, i.part != "static"))


@cache
def _of_others() -> None:
    for name in named("checks"):
        ours = dict(REGISTRY)
        load("checks", name)
        added = [item for key, item in REGISTRY.items() if ours.get(key) is not item]
        if low := [item for item in added if item.number < FIRST_OF_OTHERS]:
            REGISTRY.clear()
            REGISTRY.update(ours)
            raise PluginError(
                f"feeddrive.checks: {name} registers item {low[0].number}, but numbers "
                f"below {FIRST_OF_OTHERS} are feeddrive's; give it one from there on"
            )
