"""Native FMUs of small models, and one way to drive both FMI versions."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import fmpy
import numpy as np
import pytest
from fmpy import fmi2, fmi3
from small import MODELS

from fmus.compile import PLATFORMS, compile_library, host_platform
from fmus.layout import Layout, layout
from fmus.native_source import native_sources
from fmus.trace import trace

TOKEN = "token-100%"
NATIVE = Path(__file__).parents[2] / "fmus" / "native"


class Instance:
    """A co-simulation instance in fmpy, the same calls for FMI 2 and 3."""

    def __init__(self, built: "Built", version: int, name: str, **changes: Any) -> None:
        self.version, self.layout, self.log = version, built.layout, []
        arguments = {
            "guid": TOKEN,
            "modelIdentifier": built.model.name,
            "unzipDirectory": str(built.folder),
            "instanceName": name,
        } | changes.pop("fmu", {})
        if version == 2:
            self.fmu = fmi2.FMU2Slave(**arguments)
            callbacks = fmi2.fmi2CallbackFunctions()
            callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._log2)
            self._kept = callbacks
            options = {"callbacks": callbacks, "loggingOn": True} | changes
        else:
            self.fmu = fmi3.FMU3Slave(**arguments)
            options = {"logMessage": self._log3, "loggingOn": True} | changes
        try:
            self.fmu.instantiate(**options)
        except Exception as error:
            raise RuntimeError(*self.log) from error

    def _log2(self, environment: Any, name: Any, status: Any, *texts: bytes) -> None:
        self.log.append(texts[1].decode())

    def _log3(self, environment: Any, status: Any, *texts: bytes) -> None:
        self.log.append(texts[1].decode())

    def begin(self, start: float = 0.0, stop: float | None = None) -> "Instance":
        self.enter(start, stop)
        self.fmu.exitInitializationMode()
        return self

    def enter(self, start: float = 0.0, stop: float | None = None) -> None:
        if self.version == 2:
            self.fmu.setupExperiment(startTime=start, stopTime=stop)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start, stopTime=stop)

    def set(self, name: str, value: Any) -> None:
        variable = self.layout[name]
        values = [float(v) for v in np.ravel(value)]
        if self.version == 2:
            references = range(variable.reference, variable.reference + len(values))
            write = self.fmu.setBoolean if variable.boolean else self.fmu.setReal
            write(
                list(references),
                [int(v) for v in values] if variable.boolean else values,
            )
        else:
            write = self.fmu.setBoolean if variable.boolean else self.fmu.setFloat64
            write([variable.reference], values)

    def get(self, name: str) -> Any:
        variable = self.layout[name]
        if self.version == 2:
            last = variable.reference + variable.size
            references = list(range(variable.reference, last))
            read = self.fmu.getBoolean if variable.boolean else self.fmu.getReal
            values = read(references)
        else:
            read = self.fmu.getBoolean if variable.boolean else self.fmu.getFloat64
            values = read([variable.reference], variable.size)
        return np.reshape(values, variable.shape)[()]

    def all(self) -> dict[str, Any]:
        return {v.name: self.get(v.name) for v in self.layout.variables}

    def step(self, t: float, h: float) -> None:
        self.fmu.doStep(t, h)

    def refused(self, call: Callable[[], Any]) -> str:
        """Return the message with which a call is refused."""
        before = len(self.log)
        with pytest.raises(Exception, match="status 3"):
            call()
        (message,) = self.log[before:]
        return str(message)

    def saved(self) -> bytes:
        state = self.fmu.getFMUState()
        data: bytes = self.fmu.serializeFMUState(state)
        self.fmu.freeFMUState(state)
        return data

    def restore(self, data: bytes) -> None:
        state = self.fmu.deserializeFMUState(data)
        self.fmu.setFMUState(state)
        self.fmu.freeFMUState(state)


class Built(NamedTuple):
    """A compiled model, laid out so that fmpy finds the library."""

    model: Any
    layout: Layout
    generated: dict[str, str]
    library: Path
    folder: Path

    def new(self, version: int = 2, name: str = "it", **changes: Any) -> Instance:
        return Instance(self, version, name, **changes)


@pytest.fixture(scope="session")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Built]:
    """Build one of the small models, once per test run."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    made: dict[str, Built] = {}

    def build(name: str) -> Built:
        if name in made:
            return made[name]
        model = MODELS[name]
        traced = trace(model)
        places = layout(model, traced.output_like)
        generated = native_sources(model, traced, places, model.name, TOKEN)
        library = compile_library(
            model.name, generated, host_platform(), shared / "native-cache"
        )
        folder = tmp_path_factory.mktemp(model.name)
        for part in (fmpy.platform, fmpy.platform_tuple):
            (folder / "binaries" / part).mkdir(parents=True)
            (folder / "binaries" / part / library.name).symlink_to(library)
        made[name] = Built(model, places, generated, library, folder)
        return made[name]

    return build


@pytest.fixture(params=[2, 3], ids=["FMI 2", "FMI 3"])
def version(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture(scope="session")
def host_program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A C program that loads FMUs and knows nothing of Python."""
    program = tmp_path_factory.mktemp("host") / "native_host"
    source = Path(__file__).with_name("native_host.c")
    command = [sys.executable, "-m", "ziglang", "cc", "-O2", "-std=c99", "-Wall"]
    command += ["-target", PLATFORMS[host_platform()].triple, "-I", str(NATIVE)]
    subprocess.run([*command, str(source), "-o", str(program), "-ldl"], check=True)
    return program
