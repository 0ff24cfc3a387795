"""A composition as the page shows it: components, connections, parameters."""

import re
from contextlib import suppress
from dataclasses import asdict
from fractions import Fraction
from math import isfinite
from typing import Any

from orchestrator.errors import FeedDriveError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.ports import Port, ports
from orchestrator.master.ages import describe_schedule
from orchestrator.page.edits import found_parts, refuse_apart
from orchestrator.quantities.quantity import rate
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.reading import Scenario
from orchestrator.system import Component

_ELEMENT = re.compile(r"\[[\d,]+\]$")
NO_PORTS: dict[str, Any] = {"inputs": [], "outputs": []}
MOST = 400  # parameters of a component that are listed


def shown(composition: Composition) -> dict[str, Any]:
    """Return what the page shows of a composition before it has run.

    Raises:
        FeedDriveError: the system does not fit together.
    """
    system, spec = composition.system, composition.scenario.spec
    plan = describe_schedule(system)
    turns = {turn.component: turn for turn in plan.turns}
    free = {one.input for one in plan.undriven}
    return {
        "title": spec.title,
        "description": spec.description,
        "stop": float(system.stop),
        "order": plan.order,
        "tick": _us(plan.tick),
        "hyperperiod": _us(plan.hyperperiod),
        "components": [
            {
                "name": name,
                "fmu": composition.sources[name],
                "about": composition.fmus[name].description,
                "kind": turns[name].kind,
                "rate": rate(turns[name].period),
                "step": _written(spec.components[name].step),
                "latency": turns[name].latency,
                "steps": turns[name].steps,
                "parameters": _parameters(part, composition, free),
                "error": "",
                **_ports(part, composition.fmus[name]),
            }
            for name, part in system.components.items()
        ],
        "connections": [
            {
                "source": age.source,
                "sink": age.sink,
                "unit": _unit(composition, age.sink),
                "from_unit": _unit(composition, age.source),
                "youngest": _us(age.youngest),
                "oldest": _us(age.oldest),
                "remark": age.remark,
                "error": "",
            }
            for age in plan.ages
        ],
        "undriven": [asdict(one) for one in plan.undriven],
        "record": list(system.record),
        "warnings": [*composition.warnings, *plan.warnings],
    }


def halfway(scenario: Scenario) -> dict[str, Any]:
    """Return what the page shows of a scenario that does not fit together: what of it
    can be read, and at each connection and component what is wrong there."""
    found, whys = found_parts(scenario)
    spec = scenario.spec
    lines = {k: v for k, v in spec.connections.items() if isinstance(v, str)}
    return {
        "title": spec.title,
        "description": spec.description,
        "stop": float(spec.stop),
        "components": [
            {
                "name": name,
                "fmu": part.fmu or str(part.data),
                "about": found[name][1].description if name in found else "",
                "kind": "",
                "rate": rate(found[name][0].period) if name in found else "",
                "step": _written(part.step),
                "latency": part.latency,
                "steps": "",
                "parameters": [],
                "error": whys.get(name, ""),
                **(_ports(*found[name]) if name in found else NO_PORTS),
            }
            for name, part in spec.components.items()
        ],
        "connections": [
            {
                "source": source,
                "sink": sink,
                "error": "" if "*" in sink else _wrong(scenario, source, sink),
            }
            for sink, source in lines.items()
        ],
        "undriven": [],
        "record": list(spec.record),
        "warnings": [],
    }


def _wrong(scenario: Scenario, source: str, sink: str) -> str:
    try:
        refuse_apart(scenario, source, sink)
    except FeedDriveError as error:
        return str(error)
    return ""


def _written(step: Fraction | None) -> str:
    return "" if step is None else str(step)


def _ports(part: Component, fmu: FmuDescription) -> dict[str, Any]:
    """Return the inputs and outputs of a component by our names, with units."""
    ours = {mapped.name: name for name, mapped in part.map.items()}

    def told(name: str) -> dict[str, str]:
        own = ours.get(name, name)
        unit = ports(part, fmu, own)[0].unit
        about = fmu.variables[name].description
        return {"name": own, "unit": str(unit or ""), "about": about}

    return {
        "inputs": [told(name) for name in fmu.inputs],
        "outputs": [told(name) for name in fmu.outputs],
    }


def _parameters(
    part: Component, composition: Composition, free: set[str]
) -> list[dict[str, Any]]:
    """Return the numbers that can be set, those that the scenario sets first.

    Inputs that nothing drives, ``free``, are among them.
    """
    fmu = composition.fmus[part.name]
    ours = {mapped.name: name for name, mapped in part.map.items()}
    found = []
    for name, variable in fmu.variables.items():
        own = ours.get(name, name)
        if not _settable(variable, free=f"{part.name}.{own}" in free):
            continue
        with suppress(FeedDriveError, ValueError):
            found.append(_parameter(part, fmu, own, composition))
        if len(found) == MOST:
            break
    return sorted(found, key=lambda one: not one["given"])


def _settable(variable: FmuVariable, *, free: bool) -> bool:
    """Tell whether it is one number that a user sets before the run."""
    set_before = variable.causality == "parameter" and variable.variability in (
        "fixed",
        "tunable",
    )
    one = variable.sort == "real" and variable.size == 1
    return one and (set_before or free) and not _ELEMENT.search(variable.name)


def _parameter(
    part: Component, fmu: FmuDescription, name: str, composition: Composition
) -> dict[str, Any]:
    port = ports(part, fmu, name)[0]
    value = composition.parameter(f"{part.name}.{name}")
    least, most = _bounds(port)
    return {
        "name": f"{part.name}.{name}",
        "about": port.variable.description,
        "value": float(value.value),
        "unit": "" if str(value.unit) == "1" else str(value.unit),
        "min": least,
        "max": most,
        "slider": _range(float(value.value), least, most),
        "given": name in part.values,
    }


def _bounds(port: Port) -> tuple[float | None, float | None]:
    """Return the least and the largest value on our side, None without a bound."""
    ours = port.to_ours
    said = (port.variable.min, port.variable.max)
    ends = [None if s is None else ours.gain * float(s) + ours.offset for s in said]
    if ours.gain < 0:
        ends.reverse()
    least, most = (e if e is not None and isfinite(e) else None for e in ends)
    return least, most


def _range(
    value: float, least: float | None, most: float | None
) -> tuple[float, float]:
    """Return the ends of a slider: twice the value about it, within the bounds."""
    reach = abs(value) or 1.0
    low, high = value - reach, value + reach
    if least is not None:
        low = max(low, least)
    if most is not None:
        high = min(high, most)
    return min(low, value), max(high, value)


def _unit(composition: Composition, name: str) -> str:
    with suppress(FeedDriveError):
        return str(composition.unit(name))
    return ""


def _us(seconds: Fraction) -> str:
    return f"{float(seconds * 10**6):g} us"
