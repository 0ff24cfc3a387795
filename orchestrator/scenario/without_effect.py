"""What a scenario sets that cannot change its run, or hardly."""

from collections.abc import Iterator, Mapping

from orchestrator.fmu.description import FmuDescription
from orchestrator.fmu.laid import numbers
from orchestrator.system import Component, System, split_name


def without_effect(system: System, fmus: Mapping[str, FmuDescription]) -> Iterator[str]:
    """Yield a sentence for each such value.

    These are values of inputs that a connection drives, which are only where the
    initialisation begins, and latencies that outlast the run.
    """
    for name, component in system.components.items():
        driven = {
            input_: source
            for sink, source in system.connections.items()
            for input_ in _numbers(component, fmus[name], sink)
        }
        for variable in (*component.parameters, *component.start):
            for input_ in _numbers(component, fmus[name], f"{name}.{variable}"):
                if input_ in driven:
                    yield (
                        f"{name}.{variable} is set, but {driven[input_]} drives it: "
                        f"the value is only where the initialisation begins; to hold "
                        f"it, remove the connection"
                    )
                    break
        published = component.offset + component.latency * component.period
        if component.latency and published > system.stop:
            yield (
                f"{name}.latency = {component.latency} samples are "
                f"{float(component.latency * component.period):g} s: nothing that "
                f"{name} computes is published before the run ends at "
                f"{float(system.stop):g} s"
            )


def _numbers(
    component: Component, fmu: FmuDescription, full: str
) -> list[tuple[str, int]]:
    """Return the numbers of a component that a name stands for; none of others."""
    owner, name = split_name(full)
    return sorted(numbers(component, fmu, name)) if owner == component.name else []
