"""All items there are, by number; importing this registers them."""

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


def catalogue() -> list[Item]:
    """Return all items by number, the static one of a number first."""
    return sorted(REGISTRY.values(), key=lambda i: (i.number, i.part != "static"))
