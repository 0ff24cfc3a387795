"""The lock file: a run written down so that it can be run again.

``scenario.lock.toml`` is itself a scenario: FMUs copied beside it, designs
replaced by what they found, stars opened, times exact.  Its ``[lock]`` table
says where it came from: overrides, digests, versions, design arguments.
"""

import platform
import shutil
from collections.abc import Mapping
from fractions import Fraction
from importlib.metadata import version
from pathlib import Path
from typing import Any

from orchestrator.evaluation.metrics import factor
from orchestrator.evaluation.schema import Factor, MetricSpec
from orchestrator.quantities.quantity import time_text
from orchestrator.scenario.compose import Composition
from orchestrator.system import Component, Isolation

LOCK = "scenario.lock.toml"
_VERSIONS = ("feeddrive-cosim", "numpy", "scipy", "casadi", "ziglang", "fmpy")


def write_lock(
    composition: Composition, folder: Path, origin: str | None = None
) -> Path:
    """Write the lock file and the FMUs it names into ``folder``; return its path.

    ``origin`` is where the run begins, if not at 0.
    """
    import tomli_w

    fmus = folder / "fmus"
    fmus.mkdir(parents=True, exist_ok=True)
    for component in composition.system.components.values():
        shutil.copyfile(component.fmu, fmus / f"{component.name}.fmu")
    file = folder / LOCK
    tables = locked(composition)
    if origin is not None:
        tables["lock"]["origin"] = origin
    file.write_bytes(tomli_w.dumps(tables).encode())
    return file


def locked(composition: Composition) -> dict[str, Any]:
    """Return the tables of the lock file."""
    spec, system = composition.scenario.spec, composition.system
    expect = {k: e.model_dump(exclude_none=True) for k, e in spec.expect.items()}
    metrics = {k: _metric(m, composition) for k, m in spec.metrics.items()}
    return {
        "title": spec.title,
        "description": spec.description,
        "stop": time_text(system.stop),
        "components": {n: _component(c) for n, c in system.components.items()},
        "connections": dict(system.connections),
        "faults": {
            name: [_plain(fault.model_dump(exclude_none=True)) for fault in faults]
            for name, faults in spec.faults.items()
        },
        **_groups(composition),
        "record": {name: _plain(rows) for name, rows in system.record.items()},
        "metrics": _plain(metrics),
        "responses": {
            name: _plain(one.model_dump(by_alias=True))
            for name, one in spec.responses.items()
        },
        "expect": expect,
        "lock": {
            "scenario": system.name,
            "overrides": list(composition.scenario.overrides),
            "sources": dict(composition.sources),
            "digests": dict(composition.digests),
            "contents": dict(composition.contents),
            "versions": versions(),
            "design": {
                name: {
                    "call": result.call,
                    "arguments": _plain(result.arguments),
                    "values": _plain(result.values),
                }
                for name, result in composition.designs.items()
            },
        },
    }


def _groups(composition: Composition) -> dict[str, Any]:
    """Return the table of groups, nothing where there are none."""
    groups = composition.scenario.spec.groups
    said = {k: _plain(group.model_dump()) for k, group in groups.items()}
    return {"groups": said} if said else {}


def versions() -> dict[str, str]:
    """Return the versions of what computes: Python, platform and packages."""
    import importlib.util

    found = {"python": platform.python_version(), "platform": platform.platform()}
    for package in _VERSIONS:
        module = package.partition("-")[0]
        if module == "feeddrive" or importlib.util.find_spec(module):
            found[package] = version(package)
    return found


def _component(component: Component) -> dict[str, Any]:
    written: dict[str, Any] = {
        "fmu": f"fmus/{component.name}.fmu",
        "step": time_text(component.period),
        "offset": time_text(component.offset),
        "latency": component.latency,
        "parameters": _plain(component.parameters),
        "start": _plain(component.start),
        "map": {
            name: {
                key: _of_map(key, value)
                for key, value in vars(mapped).items()
                if value is not None
            }
            for name, mapped in component.map.items()
        },
    }
    if component.kind is not None:
        written["kind"] = component.kind
    written |= _isolation(component.isolation)
    experiment = component.experiment
    if experiment.stop:
        written["experiment"] = {"stop": True}
    if experiment.tolerance is not None:
        written.setdefault("experiment", {})["tolerance"] = experiment.tolerance
    if component.split is not None:
        written["split"] = component.split
    if component.interface == "model_exchange":
        written["interface"] = component.interface
    return {key: value for key, value in written.items() if value != {}}


def _of_map(key: str, value: Any) -> Any:
    if key == "table":
        return {str(given): becomes for given, becomes in value}
    return str(value) if key == "unit" else value


def _isolation(isolation: Isolation) -> dict[str, Any]:
    written: dict[str, Any] = {}
    if isolation.process is not None:
        written["isolation"] = "process" if isolation.process else "none"
    if isolation.sandbox:
        written["isolation"] = "sandbox"
    if isolation.answer_within != Isolation().answer_within:
        written["answer_within"] = isolation.answer_within
    if isolation.memory_limit is not None:
        written["memory_limit"] = isolation.memory_limit
    return written


def _metric(spec: MetricSpec, composition: Composition) -> dict[str, Any]:
    """Return a metric's table, its factors as numbers with their units."""
    fields = type(spec).model_fields.items()
    factors = {
        key: written
        for key, field in fields
        if field.annotation == Factor
        and not isinstance(written := getattr(spec, key), float)
    }
    table = spec.model_dump(exclude_none=True, exclude=set(factors))
    for key, written in factors.items():
        found = factor(written, composition.parameter)
        table[key] = f"{found.value!r} {found.unit}"
    return table


def _plain(value: Any) -> Any:
    """Return a value as TOML can hold it: fractions as exact text."""
    if isinstance(value, Fraction):
        return time_text(value)
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(v) for v in value]
    return value.tolist() if hasattr(value, "tolist") else value
