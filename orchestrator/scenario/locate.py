"""A component's FMU: found, or built where it is a model of ours; and the component."""

from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from fmus.build import BuildError, build, load_model
from fmus.model import Sampled
from orchestrator.errors import ScenarioError
from orchestrator.fmu.description import read_fmu
from orchestrator.scenario.component import ComponentSpec
from orchestrator.scenario.moved import refusal
from orchestrator.scenario.quantities import in_own_units
from orchestrator.scenario.reading import Scenario
from orchestrator.scenario.schema import Specification
from orchestrator.signals.recording import Recording, play
from orchestrator.system import Component, Experiment, Isolation
from orchestrator.warned import warn


@dataclass(frozen=True)
class Located:
    """The FMU file of a component, what it was made of, and how often it steps.

    Signals of a file have the digest of that file, ``content``, and the run's time (s)
    at which they ``end`` it, if they do.
    """

    path: Path
    source: str
    period: Fraction
    content: str = ""
    end: Fraction | None = None


def locate(
    scenario: Scenario, spec: Specification, name: str, component: ComponentSpec
) -> Located:
    """Return a component's FMU file, built where it is a model of ours.

    Raises:
        ScenarioError: a step is needed and missing, or a file is not there.
        fmus.build.BuildError: the model cannot be built.
    """
    where = f"{scenario.file}: components.{name}"
    if component.data is not None:
        return _recorded(scenario, spec, name, component, component.data)
    written = component.fmu
    if written.endswith(".fmu"):
        path = scenario.file.parent / written
        period = component.step or read_fmu(path).period
        if period is None:
            raise ScenarioError(f'{where}: step is missing, e.g. step = "1/20000"')
        return Located(path, written, period)
    if why := refusal(written):
        raise ScenarioError(f"{where}.fmu: {why}")
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


def _recorded(
    scenario: Scenario, spec: Specification, name: str, own: ComponentSpec, data: str
) -> Located:
    where = f"{scenario.file}: components.{name}"
    recording = Recording(
        scenario.file.parent / data,
        own.step,
        own.interpolation,
        own.begin,
        own.rate,
        own.offset,
    )
    try:
        found = play(recording, fmi=spec.fmi)
    except (ScenarioError, BuildError) as error:
        raise ScenarioError(f"{where}: {error}") from None
    end = None
    if found.last < spec.stop:
        ends = f"{data} ends at t = {float(found.last):g} s"
        stop = f"the stop at {float(spec.stop):g} s"
        if own.at_end is None:
            raise ScenarioError(
                f'{where}: {ends}, before {stop}; say at_end = "hold" (its last values '
                f'hold) or at_end = "end" (the run ends there)'
            )
        ends_run = own.at_end == "end"
        end = found.last if ends_run else None
        then = "the run ends there, not at" if ends_run else "its last values hold to"
        warn(f"components.{name}: {ends}; {then} {stop}")
    return Located(found.fmu, data, found.period, found.content, end)


def component_of(name: str, spec: ComponentSpec, found: Located) -> Component:
    """Return a component as its specification says.

    Raises:
        ScenarioError: a value with a unit does not fit its variable.
    """
    component = Component(
        name=name,
        fmu=found.path,
        period=found.period,
        offset=spec.offset,
        latency=spec.latency,
        kind=spec.kind,
        map={name: spec.mapped() for name, spec in spec.map.items()},
        isolation=Isolation(
            None if spec.isolation is None else spec.isolation != "none",
            float(spec.answer_within),
            spec.memory_limit,
            spec.isolation == "sandbox",
        ),
        experiment=Experiment(spec.experiment.stop, spec.experiment.tolerance),
        split=spec.split,
        interface=spec.interface,
    )
    fmu = read_fmu(found.path)
    parameters = in_own_units(component, fmu, "parameters", spec.parameters)
    start = in_own_units(component, fmu, "start", spec.start)
    return replace(component, parameters=parameters, start=start)
