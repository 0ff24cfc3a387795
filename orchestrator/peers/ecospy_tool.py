"""Ecos, through ecospy: fixed step, C++ importer of its own."""

import ctypes
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any


def rows(job: dict[str, Any]) -> Iterator[list[float]]:
    """Yield Ecos' own time and the signals, first after initialisation."""
    _load_tbb()
    from ecospy import EcosSimulation, EcosSimulationStructure

    with EcosSimulationStructure() as structure:
        for name, component in job["components"].items():
            structure.add_model(name, component["fmu"])
        for connection in job["connections"]:
            _connect(structure, connection)
        structure.add_parameter_set("given", _parameters(job))
        with EcosSimulation(step_size=job["step"], structure=structure) as simulation:
            if not simulation.init(0.0, "given"):
                raise RuntimeError("Ecos did not initialise")
            yield _row(simulation, job)
            for _ in range(job["count"]):
                simulation.step(1)
                yield _row(simulation, job)
            simulation.terminate()


def _load_tbb() -> None:
    """Load the libtbb of the pip package, which Ecos' own library looks for."""
    for found in sorted(Path(sys.prefix, "lib").glob("libtbb.so.12*"))[:1]:
        ctypes.CDLL(str(found), mode=ctypes.RTLD_GLOBAL)


def _connect(structure: Any, connection: dict[str, Any]) -> None:
    gain, offset = connection["gain"], connection["offset"]
    source, sink = ("::".join(connection[end][:2]) for end in ("source", "sink"))
    sort = connection["source"][3]
    if (gain, offset) != (1.0, 0.0):
        structure.make_real_connection(source, sink, lambda v: gain * v + offset)
    elif sort == "real":
        structure.make_real_connection(source, sink)
    elif sort == "boolean":
        structure.make_bool_connection(source, sink)
    else:
        structure.make_int_connection(source, sink)


def _parameters(job: dict[str, Any]) -> dict[str, Any]:
    kinds = {"real": float, "boolean": bool, "integer": int}
    return {
        f"{name}::{variable}": kinds[sort](value)
        for name, component in job["components"].items()
        for variable, _, sort, value in component["start"]
    }


def _row(simulation: Any, job: dict[str, Any]) -> list[float]:
    getters = {
        "real": simulation.get_real,
        "boolean": simulation.get_bool,
        "integer": simulation.get_integer,
    }
    signals = (getters[sort](f"{c}::{name}") for c, name, _, sort in job["signals"])
    return [simulation.get_time(), *map(float, signals)]
