"""A component as its scenario runs it: designed gains, period, parameters."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.system import Value


@dataclass(frozen=True)
class Designed:
    """A model module, and what replaces its own period (s) and start values."""

    module: str
    period: Fraction | None = None
    values: Mapping[str, Value] = field(default_factory=dict)
    origin: str = ""


def designed(name: str) -> Designed:
    """Return what ``SCENARIO:component`` names, or a module as it is.

    ``SCENARIO`` is what ``run`` takes, or the path of a lock file.

    Raises:
        ScenarioError: there is no such scenario or component, or the component is
            a foreign FMU.
        DesignError, FmuError, fmus.build.BuildError: the scenario does not compose.
    """
    file, colon, component = name.rpartition(":")
    if not colon or "/" in component or "\\" in component:
        return Designed(name)
    from fmus.build import load_model
    from fmus.model import Sampled
    from orchestrator.fmu.start_values import start_values
    from orchestrator.scenario.compose import compose
    from orchestrator.scenario.reading import load_scenario
    from orchestrator.session import run_earlier

    scenario = load_scenario(file)
    composition = compose(scenario, run_earlier)
    parts = composition.system.components
    if component not in parts:
        raise ScenarioError(
            f"{file} has no component {component!r}; {did_you_mean(component, parts)}"
        )
    part = parts[component]
    locked = scenario.spec.lock.get("sources", composition.sources)
    module = str(locked[component])
    if module.endswith(".fmu"):
        raise ScenarioError(
            f"{name} is a foreign FMU ({module}), which cannot be built with other "
            f"values: set them where it is imported"
        )
    if module.endswith(".py"):
        module = str(scenario.file.parent / module)
    sampled = isinstance(load_model(module), Sampled)
    values: dict[str, Value] = {}  # by the names, and in the units, of the model
    for variable, held in start_values(part, composition.fmus[component]):
        numbers = tuple(map(float, held))
        values[variable.name] = numbers if variable.shape else numbers[0]
    return Designed(
        module,
        part.period if sampled else None,
        values,
        f"\n\nStart values: those of {component} in {file}.\n",
    )
