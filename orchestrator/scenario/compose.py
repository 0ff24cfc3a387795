"""From a scenario to a system: FMUs found or built, designs carried out,
stars opened.  What fits together is checked when the system is wired.

Values of a variable take precedence in the order FMU < design < scenario <
``--set`` (``layers.py``).  Our own models are built (or taken from the cache) in the
form the scenario asks for; a sampled one with the component's ``step`` as sample time.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache
from typing import TypeAlias

from fmus.cache import digest
from orchestrator.errors import (
    DesignError,
    ScenarioError,
    did_you_mean,
)
from orchestrator.fmu.description import FmuDescription, read_fmu
from orchestrator.fmu.laid import laid, same_numbers
from orchestrator.fmu.structure import sized
from orchestrator.master.undriven import Undriven, undriven
from orchestrator.quantities.quantity import Quantity
from orchestrator.quantities.unit import Unit
from orchestrator.result import Result
from orchestrator.scenario.design import DesignResult, run_step
from orchestrator.scenario.layers import layered
from orchestrator.scenario.locate import component_of, locate
from orchestrator.scenario.maps import MapSpec, with_gains
from orchestrator.scenario.override import lines_of, settings_of
from orchestrator.scenario.reading import Scenario
from orchestrator.scenario.schema import DesignSpec, FaultSpec
from orchestrator.scenario.stars import constants_of, open_connections, open_record
from orchestrator.scenario.swapped import (
    refuse_lost_inputs,
    refuse_unknown_names,
    swaps,
)
from orchestrator.scenario.takeover import NotTakenOver
from orchestrator.scenario.unit_names import read_units
from orchestrator.scenario.values import Part, Values
from orchestrator.scenario.without_effect import without_effect
from orchestrator.system import (
    Fault,
    Iterated,
    System,
    Value,
    split_name,
)
from orchestrator.warned import collecting, warn

RunEarlier: TypeAlias = Callable[[str], Result]


@dataclass(frozen=True)
class Composition:
    """A system ready to be simulated, and where its parts and values come from.

    ``sources`` says what each FMU was made of: a module, a model file or an
    ``.fmu``; ``digests`` are SHA-256 of the FMU files,
    ``contents`` those of files of signals; ``warnings`` are what its
    user has to know of it, ``not_taken_over`` the scenario's values that a swapped
    component left, ``undriven`` the inputs that no connection drives,
    ``in_gains`` the parameters of which gains are made.
    """

    scenario: Scenario
    system: System
    fmus: Mapping[str, FmuDescription]
    sources: Mapping[str, str]
    digests: Mapping[str, str]
    designs: Mapping[str, DesignResult]
    _values: tuple[Values, Values]
    not_taken_over: tuple[NotTakenOver, ...] = ()
    undriven: tuple[Undriven, ...] = ()
    warnings: tuple[str, ...] = ()
    contents: Mapping[str, str] = field(default_factory=dict)
    in_gains: frozenset[str] = frozenset()

    def parameter(self, name: str) -> Quantity:
        """Return the value and unit of a scalar ``component.parameter``.

        A component that was swapped answers for its predecessor what it lacks.

        Raises:
            ScenarioError: there is none, or it is an array.
        """
        actual, nominal = self._values
        return (actual if actual.has(name) else nominal).quantity(name)

    def unit(self, name: str) -> Unit:
        """Return the unit in which ``component.variable`` is recorded.

        Raises:
            ScenarioError: there is no such variable.
        """
        return self._values[0].unit(name)

    def module(self, name: str) -> str:
        """Return the module, or model file by its path, of a component of ours."""
        source = self.sources[name]
        beside = self.scenario.file.parent / source
        return str(beside) if source.endswith(".py") else source

    def refuse_text(self, name: str) -> None:
        """Raise ``ScenarioError`` if a variable holds texts, which have no figure."""
        self._values[0].refuse_text(name)

    def in_gain(self, component: str, name: str) -> bool:
        """Tell whether a gain is made of a parameter, by whatever name of it."""
        part, fmu = self.system.components[component], self.fmus[component]
        own = [n for c, n in map(split_name, self.in_gains) if c == component]
        return bool(same_numbers(part, fmu, name, own))

    def with_values(self, given: Mapping[str, Mapping[str, Value]]) -> "Composition":
        """Return it with other parameters and start values, by component and name;
        designs and gains stay as they are.  What does not fit is found as they are
        written."""
        components = dict(self.system.components)
        for name, values in given.items():
            components[name] = laid(components[name], self.fmus[name], values)
        actual = Values(list(components), lambda n: (components[n], self.fmus[n]))
        system = replace(self.system, components=components)
        return replace(self, system=system, _values=(actual, self._values[1]))


def compose(
    scenario: Scenario, earlier: RunEarlier | None, *, warm: bool = False
) -> Composition:
    """Return the system a scenario describes.

    ``earlier`` runs the scenario a design step takes its signals from; without it no
    design step is carried out.  ``warm``: it is known where a run begins whose lock
    this is, if that was not at 0.

    Raises:
        ScenarioError, DesignError, FmuError, WiringError, fmus.build.BuildError.
    """
    origin = scenario.spec.lock.get("origin")
    if origin and not warm:
        raise ScenarioError(
            f"{scenario.file}: is of a run that began with the state of {origin}; give "
            f"--from RUN@S to begin there again, or run {scenario.name} itself"
        )
    with collecting() as warnings:
        found = _compose(scenario, earlier)
        spec = read_units(scenario.spec, found.fmus, found.unit, found.parameter)
    read = replace(scenario, spec=spec)
    return replace(found, scenario=read, warnings=tuple(warnings))


def _compose(scenario: Scenario, earlier: RunEarlier | None) -> Composition:
    spec = scenario.spec
    located = {n: locate(scenario, spec, n, c) for n, c in spec.components.items()}
    fmus = {
        name: sized(
            read_fmu(found.path), component_of(name, spec.components[name], found)
        )
        for name, found in located.items()
    }
    digests = {name: digest(found.path) for name, found in located.items()}
    _refuse_other_content(scenario, digests)
    nominal = _nominal(scenario)
    designs = {} if earlier is None else _design(scenario, nominal, fmus, earlier)
    specs, left = dict(spec.components), []
    replaced = swaps(scenario, fmus)
    designed = {name: nominal.designed.get(name, {}) for name in specs}
    for name, swap in replaced.items():
        specs[name], not_taken_over = swap.take_over(specs[name])
        where = f"design: {name}."
        designed[name] = swap.rewritten(specs[name], where, designed[name])
        left.extend(not_taken_over)
        numbers = (k for k, v in spec.faults.items() if any(f.in_unit for f in v))
        swap.refuse_faults(specs[name], list(numbers))
    for one in left:
        warn(str(one))
    components = {
        name: component_of(name, specs[name], located[name]) for name in specs
    }
    for name, component in components.items():
        refuse_unknown_names(component, fmus[name])
        constants = constants_of(spec.connections, component, fmus[name])
        if name in replaced:
            where = f"connections.{name}."
            constants = {
                line: replaced[name].rewritten(specs[name], where, values)
                for line, values in constants.items()
            }
        settings = settings_of(scenario.overrides, name)
        layers = designed[name], constants, settings
        components[name] = layered(component, fmus[name], *layers)
    actual = Values(list(components), lambda name: (components[name], fmus[name]))
    in_gains: set[str] = set()
    for name, spec_of_part in specs.items():
        component = components[name]
        components[name], taken = with_gains(
            component, spec_of_part.map, fmus[name], actual.quantity
        )
        in_gains |= taken
    connections, given = open_connections(spec, components, fmus)
    refuse_lost_inputs(scenario, connections, given)
    system = System(
        name=scenario.name,
        stop=min([spec.stop, *(f.end for f in located.values() if f.end is not None)]),
        components=components,
        connections=connections,
        record=open_record(
            spec, components, fmus, lines_of(scenario.overrides, "record")
        ),
        faults={k: tuple(map(_fault, v)) for k, v in spec.faults.items()},
        groups={
            name: Iterated(group.components, group.tolerance)
            for name, group in spec.groups.items()
            if group.iterate
        },
    )
    for note in without_effect(system, fmus):
        warn(note)
    sources = {name: found.source for name, found in located.items()}
    both = actual, nominal
    contents = {name: f.content for name, f in located.items() if f.content}
    return Composition(
        scenario,
        system,
        fmus,
        sources,
        digests,
        designs,
        both,
        tuple(left),
        undriven(system, fmus),
        contents=contents,
        in_gains=frozenset(in_gains),
    )


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


def _nominal(scenario: Scenario) -> Values:
    """Return the values of the scenario as its file stands, without ``--set``."""
    spec = scenario.nominal

    @cache
    def part(name: str) -> Part:
        found = locate(scenario, spec, name, spec.components[name])
        component = component_of(name, spec.components[name], found)
        fmu = read_fmu(found.path)
        constants = constants_of(spec.connections, component, fmu)
        last = [one for one in settings_of(scenario.overrides, name) if one[0]]
        return layered(component, fmu, {}, constants, last), fmu

    return Values(list(spec.components), part)


def _design(
    scenario: Scenario,
    nominal: Values,
    fmus: Mapping[str, FmuDescription],
    earlier: RunEarlier,
) -> dict[str, DesignResult]:
    """Carry out all design steps, noting in ``nominal`` what they found."""
    maps = {name: c.map for name, c in scenario.spec.components.items()}

    def earlier_beside(name: str) -> Result:
        return earlier(scenario.beside(name))

    results: dict[str, DesignResult] = {}
    for name, step in scenario.spec.design.items():
        try:
            results[name] = run_step(
                f"design.{name}", step, nominal.value, earlier_beside
            )
            _hand_over(f"design.{name}", step, results[name], nominal, fmus, maps)
        except (DesignError, ScenarioError) as error:
            raise type(error)(f"{scenario.file}: {error}") from None
    return results


def _hand_over(
    where: str,
    step: DesignSpec,
    found: DesignResult,
    nominal: Values,
    fmus: Mapping[str, FmuDescription],
    maps: Mapping[str, Mapping[str, MapSpec]],
) -> None:
    for key, value in found.values.items():
        takers = [c for c in step.sets if _has(fmus[c], key) or key in maps[c]]
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
