"""From a scenario to a system: FMUs found or built, designs carried out,
stars opened.  What fits together is checked when the system is wired.

Values of a variable take precedence in the order FMU < design < scenario <
``--set``.  Our own models are built (or taken from the cache) in the form the
scenario asks for; a sampled one with the component's ``step`` as sample time.
"""

import hashlib
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import TypeAlias

from fmus.build import BuildError, build, load_model
from fmus.model import Sampled
from orchestrator.errors import (
    DesignError,
    ScenarioError,
    WiringError,
    did_you_mean,
)
from orchestrator.fmu import FmuDescription, read_fmu
from orchestrator.ports import ports
from orchestrator.quantity import Quantity
from orchestrator.result import Result
from orchestrator.scenario.design import DesignResult, run_step
from orchestrator.scenario.reading import Scenario
from orchestrator.scenario.schema import (
    ComponentSpec,
    DesignSpec,
    FaultSpec,
    Specification,
)
from orchestrator.scenario.stars import open_connections, open_record
from orchestrator.scenario.values import Part, Values
from orchestrator.scenario.without_effect import without_effect
from orchestrator.system import (
    Component,
    Fault,
    Isolation,
    Mapped,
    System,
    Value,
    split_name,
)

LOG = logging.getLogger("feeddrive")
RunEarlier: TypeAlias = Callable[[str], Result]


@dataclass(frozen=True)
class Composition:
    """A system ready to be simulated, and where its parts and values come from.

    ``sources`` says what each FMU was made of: a module, a model file or an
    ``.fmu``; ``digests`` are SHA-256 of the FMU files.
    """

    scenario: Scenario
    system: System
    fmus: Mapping[str, FmuDescription]
    sources: Mapping[str, str]
    digests: Mapping[str, str]
    designs: Mapping[str, DesignResult]
    _values: tuple[Values, Values]

    def parameter(self, name: str) -> Quantity:
        """Return the value and unit of a scalar ``component.parameter``.

        A component that was swapped answers for its predecessor what it lacks.

        Raises:
            ScenarioError: there is none, or it is an array.
        """
        actual, nominal = self._values
        return (actual if actual.has(name) else nominal).quantity(name)

    def unit(self, name: str) -> str:
        """Return the unit in which ``component.variable`` is recorded.

        Raises:
            ScenarioError: there is no such variable.
        """
        return self._values[0].unit(name)


def compose(scenario: Scenario, earlier: RunEarlier) -> Composition:
    """Return the system a scenario describes.

    ``earlier`` runs the scenario a design step takes its signals from.

    Raises:
        ScenarioError, DesignError, FmuError, WiringError, fmus.build.BuildError.
    """
    spec = scenario.spec
    located = {n: locate(scenario, spec, n, c) for n, c in spec.components.items()}
    fmus = {name: read_fmu(found.path) for name, found in located.items()}
    digests = {name: digest(found.path) for name, found in located.items()}
    _refuse_other_content(scenario, digests)
    nominal = _nominal(scenario)
    designs = _design(scenario, nominal, fmus, earlier)
    components = {
        name: _component(
            name, spec.components[name], located[name], nominal.designed[name]
        )
        for name in spec.components
    }
    for name, component in components.items():
        _refuse_unknown_names(component, fmus[name])
    connections, constants = open_connections(spec, components, fmus)
    _refuse_lost_inputs(scenario, connections, constants)
    for name, values in constants.items():
        start = {**components[name].start, **values}
        components[name] = replace(components[name], start=start)
    system = System(
        name=scenario.name,
        stop=spec.stop,
        components=components,
        connections=connections,
        record=open_record(spec, components, fmus),
        faults={k: tuple(map(_fault, v)) for k, v in spec.faults.items()},
    )
    for note in without_effect(system, fmus):
        LOG.warning(note)
    sources = {name: found.source for name, found in located.items()}
    actual = Values(list(components), lambda name: (components[name], fmus[name]))
    return Composition(
        scenario, system, fmus, sources, digests, designs, (actual, nominal)
    )


@dataclass(frozen=True)
class Located:
    """The FMU file of a component, what it was made of, and how often it steps."""

    path: Path
    source: str
    period: Fraction


def locate(
    scenario: Scenario, spec: Specification, name: str, component: ComponentSpec
) -> Located:
    """Return a component's FMU file, built where it is a model of ours.

    Raises:
        ScenarioError: a step is needed and missing, or a file is not there.
        fmus.build.BuildError: the model cannot be built.
    """
    where = f"{scenario.file}: components.{name}"
    written = component.fmu
    if written.endswith(".fmu"):
        path = scenario.file.parent / written
        period = component.step or read_fmu(path).period
        if period is None:
            raise ScenarioError(f'{where}: step is missing, e.g. step = "1/20000"')
        return Located(path, written, period)
    module = written
    if written.endswith(".py"):
        file = scenario.file.parent / written
        if not file.is_file():
            raise ScenarioError(f"{where}.fmu: no such model file: {file}")
        module = str(file)
    try:
        model = load_model(module)
        sampled = isinstance(model, Sampled)
        period = component.step or (
            model.period if isinstance(model, Sampled) else None
        )
        if period is None:
            raise ScenarioError(
                f"{where}: {written} is continuous: give its communication period, "
                f'e.g. step = "1/20000"'
            )
        path = build(module, fmi=spec.fmi, period=period if sampled else None)
    except BuildError as error:
        raise BuildError(f"{where}.fmu: {error}") from None
    return Located(path, written, period)


def digest(path: Path) -> str:
    """Return the SHA-256 of a file as hexadecimal text."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _refuse_other_content(scenario: Scenario, digests: Mapping[str, str]) -> None:
    locked = scenario.spec.lock.get("digests", {})
    for name, found in digests.items():
        used_as_locked = scenario.spec.components[name] == (
            scenario.nominal.components.get(name)
        )
        if name in locked and used_as_locked and locked[name] != found:
            raise ScenarioError(
                f"{scenario.file}: components.{name}: the FMU differs from the one "
                f"that was locked; restore that file, or run {scenario.name} itself"
            )


def _refuse_unknown_names(component: Component, fmu: FmuDescription) -> None:
    for ours, mapped in component.map.items():
        try:
            ports(component, fmu, ours)
        except WiringError:
            raise WiringError(
                f"components.{component.name}.map: {ours} is {mapped.name!r} there, "
                f"but {fmu.path.name} has no such variable; "
                f"{did_you_mean(mapped.name, fmu.variables)}"
            ) from None


def _refuse_lost_inputs(
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
    found = {n: locate(scenario, before, n, c) for n, c in before.components.items()}
    fmus = {name: read_fmu(place.path) for name, place in found.items()}
    components = {
        name: _component(name, c, found[name], {})
        for name, c in before.components.items()
    }
    original, _ = open_connections(before, components, fmus)
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


def _nominal(scenario: Scenario) -> Values:
    """Return the values of the scenario as its file stands, without ``--set``."""
    spec = scenario.nominal

    @cache
    def part(name: str) -> Part:
        found = locate(scenario, spec, name, spec.components[name])
        component = _component(name, spec.components[name], found, {})
        return component, read_fmu(found.path)

    return Values(list(spec.components), part)


def _design(
    scenario: Scenario,
    nominal: Values,
    fmus: Mapping[str, FmuDescription],
    earlier: RunEarlier,
) -> dict[str, DesignResult]:
    """Carry out all design steps, noting in ``nominal`` what they found."""

    def earlier_beside(name: str) -> Result:
        return earlier(scenario.beside(name))

    results: dict[str, DesignResult] = {}
    for name, step in scenario.spec.design.items():
        try:
            results[name] = run_step(name, step, nominal.value, earlier_beside)
            _hand_over(f"design.{name}", step, results[name], nominal, fmus)
        except (DesignError, ScenarioError) as error:
            raise type(error)(f"{scenario.file}: {error}") from None
    return results


def _hand_over(
    where: str,
    step: DesignSpec,
    found: DesignResult,
    nominal: Values,
    fmus: Mapping[str, FmuDescription],
) -> None:
    for key, value in found.values.items():
        takers = [c for c in step.sets if _has(fmus[c], key)]
        for component in takers:
            nominal.designed[component][key] = value
        if step.sets and not takers:
            known = {v for c in step.sets for v in fmus[c].variables}
            have = "has" if len(step.sets) == 1 else "have"
            raise DesignError(
                f"{where}: found {key}, but {' and '.join(step.sets)} {have} no such "
                f"parameter; {did_you_mean(key, known)} Where the component was "
                f"swapped for one that is not designed so, leave the step out with "
                f"--set {where}=false"
            )


def _has(fmu: FmuDescription, name: str) -> bool:
    return any(n == name or n.startswith(f"{name}[") for n in fmu.variables)


def _fault(spec: FaultSpec) -> Fault:
    start, end = spec.window or (Fraction(0), None)
    return Fault(spec.kind, spec.value or 0.0, spec.samples or 0, start, end)


def _component(
    name: str, spec: ComponentSpec, found: Located, designed: Mapping[str, Value]
) -> Component:
    return Component(
        name=name,
        fmu=found.path,
        period=found.period,
        offset=spec.offset,
        latency=spec.latency,
        kind=spec.kind,
        parameters={**designed, **spec.parameters},
        start=dict(spec.start),
        map={k: Mapped(m.name, m.gain, m.offset, m.unit) for k, m in spec.map.items()},
        isolation=Isolation(
            None if spec.isolation is None else spec.isolation == "process",
            float(spec.answer_within),
            spec.memory_limit,
        ),
    )
