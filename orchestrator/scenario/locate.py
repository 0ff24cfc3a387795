"""A component's FMU: found, or built where it is a model of ours; and the component."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from fmus.build import BuildError, build, load_model
from fmus.model import Sampled
from orchestrator.errors import ScenarioError
from orchestrator.fmu.description import read_fmu
from orchestrator.scenario.moved import refusal
from orchestrator.scenario.quantities import in_own_units
from orchestrator.scenario.reading import Scenario
from orchestrator.scenario.schema import ComponentSpec, Specification
from orchestrator.system import Component, Experiment, Isolation, Mapped, Value


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


def component_of(
    name: str, spec: ComponentSpec, found: Located, designed: Mapping[str, Value]
) -> Component:
    """Return a component as its specification and design say.

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
        map={k: Mapped(m.name, m.gain, m.offset, m.unit) for k, m in spec.map.items()},
        isolation=Isolation(
            None if spec.isolation is None else spec.isolation == "process",
            float(spec.answer_within),
            spec.memory_limit,
        ),
        experiment=Experiment(spec.experiment.stop, spec.experiment.tolerance),
        split=spec.split,
    )
    fmu = read_fmu(found.path)
    parameters = in_own_units(component, fmu, "parameters", spec.parameters)
    start = in_own_units(component, fmu, "start", spec.start)
    given = {**designed, **parameters}  # one table with start, which comes last
    parameters = {key: v for key, v in given.items() if key not in start}
    return replace(component, parameters=parameters, start=start)
