"""The responses of a scenario, carried out: figures, and what is expected of them."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from orchestrator.errors import ResponseError, ScenarioError
from orchestrator.evaluation.expectation import Check, check
from orchestrator.quantities.quantity import Quantity, parse_quantity
from orchestrator.response.figures import figures
from orchestrator.response.measure import measure, measure_transfer
from orchestrator.response.measured import Response, Transfer
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.reading import Scenario
from orchestrator.scenario.responses import ResponseSpec


@dataclass(frozen=True)
class Responded:
    """Responses by name, their figures and checks."""

    responses: dict[str, Response | Transfer]
    figures: dict[str, Quantity]
    checks: list[Check]


def asking(scenario: Scenario, response: ResponseSpec) -> Scenario:
    """Return the scenario with this response, ``loop``, and no other."""
    spec = scenario.spec
    kept = {"expect": spec.expected_of_run, "responses": {"loop": response}}
    return replace(scenario, spec=spec.model_copy(update=kept))


def respond(
    composition: Composition, telling: Callable[[str], None] = lambda name: None
) -> Responded:
    """Carry out all ``[responses]`` of a scenario and check what is expected.

    Raises:
        ResponseError: there are none, or one cannot be measured; it names it.
    """
    spec = composition.scenario.spec
    if not spec.responses:
        raise ResponseError(
            f"{composition.scenario.file}: has no [responses]; name an output with "
            f"--break component.output, or signals with --excite and --observe"
        )
    found: dict[str, Response | Transfer] = {}
    for name, one in spec.responses.items():
        telling(name)
        try:
            found[name] = specified(composition, one)
        except ResponseError as error:
            raise ResponseError(f"responses.{name}: {error}") from None
    told = {
        key: value
        for name, one in found.items()
        for key, value in figures(name, one).items()
    }
    return Responded(found, told, check(spec.expected_of_responses, told))


def specified(composition: Composition, spec: ResponseSpec) -> Response | Transfer:
    """Measure what an entry of ``[responses]`` says."""
    if spec.breaks:
        return loop(composition, spec)
    return measure_transfer(
        composition,
        spec.excite,
        spec.observe,
        amplitude=_amplitude(composition, spec),
        lowest=1 / spec.lowest,
        form=spec.excitation,
    )


def loop(composition: Composition, spec: ResponseSpec) -> Response:
    """Measure an entry of ``[responses]`` that breaks a loop."""
    return measure(
        composition,
        spec.breaks,
        amplitude=_amplitude(composition, spec),
        lowest=1 / spec.lowest,
        form=spec.excitation,
    )


def _amplitude(composition: Composition, spec: ResponseSpec) -> float | None:
    if spec.amplitude == "auto":
        return None
    written = str(spec.amplitude)
    found = {amplitude_of(composition, name, written) for name in spec.injected}
    if len(found) > 1:
        raise ScenarioError(
            f"amplitude {written}: is not the same number for all of "
            f"{', '.join(spec.injected)}; measure them one by one"
        )
    return found.pop()


def amplitude_of(composition: Composition, name: str, written: str) -> float:
    """Return an amplitude, ``0.1`` or ``"100 mV"``, in the unit of what is broken.

    Raises:
        ScenarioError: it is none, or of another quantity.
    """
    try:
        quantity = parse_quantity(written)
        if quantity.unit != "1":
            quantity = quantity.to(composition.unit(name))
    except ValueError as error:
        raise ScenarioError(f"amplitude {written} of {name}: {error}") from None
    if not quantity.value > 0:
        raise ScenarioError(f"amplitude {written} of {name}: is not greater than 0")
    return quantity.value
