"""The loop everybody writes by hand on fmpy: Jacobi at one step, FMI 2 and 3.

Initialisation passes values on as often as there are components; then, for each
step, all inputs are set, all components stepped, all outputs read.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fmpy import extract, read_model_description
from fmpy.simulation import instantiate_fmu

NAMES = {
    2: {"real": "Real", "integer": "Integer", "boolean": "Boolean"},
    3: {"real": "Float64", "integer": "Int32", "boolean": "Boolean"},
}


def rows(job: dict[str, Any]) -> Iterator[list[float]]:
    """Yield the time and the signals, first after initialisation."""
    num, den = job["period"]
    models = {n: _load(n, job, c["fmu"]) for n, c in job["components"].items()}
    for name, component in job["components"].items():
        fmu, major = models[name]
        if major == 2:  # before start values, which some FMUs overwrite here
            fmu.setupExperiment(startTime=0.0)
        for _, reference, sort, value in component["start"]:
            _set(models[name], reference, sort, value)
        if major == 2:
            fmu.enterInitializationMode()
        else:
            fmu.enterInitializationMode(startTime=0.0)
    for _ in models:
        _exchange(job, models)
    for fmu, _ in models.values():
        fmu.exitInitializationMode()
    values = _carry(job, models)
    yield [0.0, *_signals(job, models)]
    for k in range(job["count"]):
        for connection, value in zip(job["connections"], values, strict=True):
            component, _, reference, sort = connection["sink"]
            _set(models[component], reference, sort, value)
        for fmu, _ in models.values():
            fmu.doStep(k * num / den, job["step"])
        values = _carry(job, models)
        yield [(k + 1) * num / den, *_signals(job, models)]
    for fmu, _ in models.values():
        fmu.terminate()
        fmu.freeInstance()


def _load(name: str, job: dict[str, Any], path: str) -> tuple[Any, int]:
    description = read_model_description(path, validate=False)
    folder = extract(path, str(Path(job["folder"]) / name))
    fmu = instantiate_fmu(folder, description, "CoSimulation")
    return fmu, int(description.fmiVersion[0])


def _set(model: tuple[Any, int], reference: int, sort: str, value: float) -> None:
    fmu, major = model
    typed = (
        value if sort == "real" else bool(value) if sort == "boolean" else int(value)
    )
    getattr(fmu, f"set{NAMES[major][sort]}")([reference], [typed])


def _get(models: dict[str, Any], variable: list[Any]) -> float:
    component, _, reference, sort = variable
    fmu, major = models[component]
    return float(getattr(fmu, f"get{NAMES[major][sort]}")([reference])[0])


def _carry(job: dict[str, Any], models: dict[str, Any]) -> list[float]:
    return [
        c["gain"] * _get(models, c["source"]) + c["offset"] for c in job["connections"]
    ]


def _exchange(job: dict[str, Any], models: dict[str, Any]) -> None:
    values = _carry(job, models)
    for connection, value in zip(job["connections"], values, strict=True):
        component, _, reference, sort = connection["sink"]
        _set(models[component], reference, sort, value)


def _signals(job: dict[str, Any], models: dict[str, Any]) -> list[float]:
    return [_get(models, variable) for variable in job["signals"]]
