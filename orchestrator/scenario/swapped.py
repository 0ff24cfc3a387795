"""What a swap may not do: name what is not there, or leave an input unfed."""

from collections.abc import Mapping
from dataclasses import replace

from orchestrator.errors import WiringError, did_you_mean
from orchestrator.fmu.description import FmuDescription, read_fmu
from orchestrator.fmu.ports import ports
from orchestrator.scenario.locate import component_of, locate
from orchestrator.scenario.maps import with_gains
from orchestrator.scenario.reading import Scenario
from orchestrator.scenario.stars import open_connections, open_record
from orchestrator.scenario.takeover import Swap
from orchestrator.scenario.values import Values
from orchestrator.system import Component, Value, split_name


def refuse_unknown_names(component: Component, fmu: FmuDescription) -> None:
    """Raise ``WiringError`` if a component's map names a variable the FMU lacks, or
    a unit that its variable cannot be had in."""
    for ours, mapped in component.map.items():
        try:
            ports(replace(component, map={}), fmu, mapped.name)
        except WiringError:
            raise WiringError(
                f"components.{component.name}.map: {ours} is {mapped.name!r} there, "
                f"but {fmu.path.name} has no such variable; "
                f"{did_you_mean(mapped.name, fmu.variables)}"
            ) from None
        ports(component, fmu, ours)


def swaps(scenario: Scenario, fmus: Mapping[str, FmuDescription]) -> dict[str, Swap]:
    """Return the components whose place another FMU takes, by name."""
    if not scenario.carried:
        return {}
    spec = scenario.nominal
    old_fmus, components, connections = _original(scenario)
    ends = {*connections, *connections.values()}
    ends |= open_record(spec, components, old_fmus).keys()
    used: dict[str, set[str]] = {name: set() for name in components}
    for end in ends:
        owner, name = split_name(end)
        used[owner].add(name)
    return {
        name: Swap(
            components[name],
            old_fmus[name],
            fmus[name],
            carried,
            {*used[name], *(key for keys in carried.values() for key in keys)},
            scenario.of_swap.get(name, ()),
            name in {text.partition("=")[0] for text in scenario.swapped},
        )
        for name, carried in scenario.carried.items()
    }


def _original(
    scenario: Scenario,
) -> tuple[dict[str, FmuDescription], dict[str, Component], dict[str, str]]:
    """Return FMUs, components and connections as they are without a swap."""
    before = scenario.nominal
    found = {n: locate(scenario, before, n, c) for n, c in before.components.items()}
    fmus = {name: read_fmu(place.path) for name, place in found.items()}
    components = {
        name: component_of(name, c, found[name])
        for name, c in before.components.items()
    }
    values = Values(list(components), lambda name: (components[name], fmus[name]))
    for name, c in before.components.items():
        components[name], _ = with_gains(
            components[name], c.map, fmus[name], values.quantity
        )
    return fmus, components, open_connections(before, components, fmus)[0]


def refuse_lost_inputs(
    scenario: Scenario,
    connections: Mapping[str, str],
    constants: Mapping[str, Mapping[str, Value]],
) -> None:
    """Refuse a swap after which an input elsewhere, fed by a star, is fed no more."""
    spec, before = scenario.spec, scenario.nominal
    swapped = [
        name
        for name, c in spec.components.items()
        if name in before.components
        and (c.fmu, c.map) != (before.components[name].fmu, before.components[name].map)
    ]
    if not swapped:
        return
    _, _, original = _original(scenario)
    for sink, source in original.items():
        component, variable = split_name(sink)
        fed = sink in connections or variable in constants.get(component, {})
        if not fed and component in spec.components and component not in swapped:
            owner, output = split_name(source)
            raise WiringError(
                f"components.{owner}: nothing feeds {sink} any more, which {output} "
                f"of the original fed; say in the map what {output} is called in "
                f"{spec.components[owner].fmu}"
            )
