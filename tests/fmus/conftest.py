"""Small models for the native FMUs, and one way to drive both FMI versions."""

import os
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import fmpy
import numpy as np
import pytest
from fmpy import fmi2, fmi3

from fmus.compile import PLATFORMS, compile_library, host_platform
from fmus.layout import Layout, layout
from fmus.model import Continuous, Model, Sampled, Var
from fmus.native_source import native_sources
from fmus.trace import trace

TOKEN = "token-100%"
NATIVE = Path(__file__).parents[2] / "fmus" / "native"


class ShaftState(NamedTuple):
    theta_m: Annotated[float, Var("rad", "motor angle")] = 0.1
    omega_m: Annotated[float, Var("rad/s", "motor speed")] = 0.0
    theta_l: Annotated[float, Var("rad", "load angle")] = 0.0
    omega_l: Annotated[float, Var("rad/s", "load speed", nominal=10.0)] = 0.0


class ShaftInput(NamedTuple):
    tau: Annotated[float, Var("N.m", "motor torque")] = 0.5
    d: Annotated[float, Var("N.m", "disturbance")] = 0.0


class ShaftOutput(NamedTuple):
    omega: Annotated[float, Var("rad/s", "speeds")]
    felt: Annotated[float, Var("N.m", "torque in shaft and motor")]


class ShaftParameters(NamedTuple):
    J_m: Annotated[float, Var("kg.m2", "motor inertia")] = 2e-3
    J_l: Annotated[float, Var("kg.m2", "load inertia", fixed=True)] = 1.5e-3
    K: Annotated[float, Var("N.m/rad", "stiffness")] = 700.0
    C: Annotated[float, Var("N.m.s/rad", "damping", constant=True)] = 0.05
    T_c: Annotated[float, Var("N.m", "Coulomb friction")] = 0.3
    friction: Annotated[bool, Var("1", "friction acts")] = True


def shaft_derivative(x: ShaftState, u: ShaftInput, p: ShaftParameters) -> ShaftState:
    tau_s = p.K * (x.theta_m - x.theta_l) + p.C * (x.omega_m - x.omega_l)
    friction = p.friction * p.T_c * np.tanh(x.omega_l / 0.5)
    return ShaftState(
        x.omega_m, (u.tau - tau_s) / p.J_m, x.omega_l, (tau_s - friction - u.d) / p.J_l
    )


def shaft_output(x: ShaftState, u: ShaftInput, p: ShaftParameters) -> ShaftOutput:
    return ShaftOutput(x.omega_m - x.omega_l, p.K * (x.theta_m - x.theta_l) + u.tau)


class PiState(NamedTuple):
    q: Annotated[float, Var("N.m", "integral")] = 0.25
    k: Annotated[float, Var("1", "tick")] = 0.0


class PiInput(NamedTuple):
    r: Annotated[float, Var("rad/s", "reference")] = 0.0
    y: Annotated[float, Var("rad/s", "measured")] = 0.0


class PiOutput(NamedTuple):
    u: Annotated[float, Var("N.m", "torque")]
    ticks: Annotated[float, Var("1", "ticks run, this one included")]


class PiParameters(NamedTuple):
    K_p: Annotated[float, Var("N.m.s/rad", "gain")] = 0.5
    T_i: Annotated[float, Var("s", "reset time")] = 0.025


class PiDerived(NamedTuple):
    K_i: float


def pi_prepare(p: PiParameters, T_s: float) -> PiDerived:
    return PiDerived(p.K_p * T_s / p.T_i)


def pi_step(
    x: PiState, u: PiInput, p: PiParameters, T_s: float, d: PiDerived
) -> tuple[PiState, PiOutput]:
    e = u.r - u.y
    return PiState(x.q + d.K_i * e, x.k + 1), PiOutput(p.K_p * e + x.q, x.k + 1)


class MixState(NamedTuple):
    s: Annotated[Any, Var("1", "sums")] = np.array([1.0, -1.0])


class MixInput(NamedTuple):
    u: Annotated[Any, Var("1", "inputs")] = np.array([0.0, 0.0, 0.0])
    v: Annotated[float, Var("1", "another")] = 2.0


class MixOutput(NamedTuple):
    y: Annotated[Any, Var("1", "outputs")]
    z: Annotated[float, Var("1", "another")]


class MixParameters(NamedTuple):
    K: Annotated[Any, Var("1", "gains")] = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])


def mix_step(
    x: MixState, u: MixInput, p: MixParameters, T_s: float
) -> tuple[MixState, MixOutput]:
    y = p.K @ u.u + x.s
    return MixState(x.s + u.v * T_s), MixOutput(y, u.v + p.K[1, 0])


class OneState(NamedTuple):
    x: Annotated[float, Var("1", "state")] = 1.0


class OneInput(NamedTuple):
    u: Annotated[float, Var("1", "input")] = 0.0


class OneOutput(NamedTuple):
    y: Annotated[float, Var("1", "output")]


class OneParameters(NamedTuple):
    a: Annotated[float, Var("1/s", "rate")] = 300.0


def one_derivative(x: OneState, u: OneInput, p: OneParameters) -> OneState:
    return OneState(p.a * (u.u - x.x))


def one_advance(x: OneState, u: OneInput, p: OneParameters, h: float) -> OneState:
    return OneState(u.u + (x.x - u.u) * np.exp(-p.a * h))


def one_output(x: OneState, u: OneInput, p: OneParameters) -> OneOutput:
    return OneOutput(x.x + u.u)


def explode(x: OneState, u: OneInput, p: OneParameters) -> OneState:
    return OneState(p.a * x.x**2 + u.u)


def count(x: OneState, u: OneInput, p: OneParameters, h: float) -> OneState:
    return OneState(x.x + 1)


class LateState(NamedTuple):
    x: Annotated[Any, Var("1", "integrals")] = np.array([0.0, 0.0])
    w: Annotated[float, Var("1", "double integral")] = 0.0


class LateInput(NamedTuple):
    u: Annotated[Any, Var("1", "delayed")] = np.array([0.0, 0.0])
    v: Annotated[float, Var("1", "not delayed")] = 0.0


class LateOutput(NamedTuple):
    y: Annotated[Any, Var("1", "delayed inputs")]


class LateParameters(NamedTuple):
    tau: Annotated[float, Var("s", "dead time")] = 3.3e-4


def late_derivative(x: LateState, u: LateInput, p: LateParameters) -> LateState:
    return LateState(u.u + u.v, x.x[0])


def late_output(x: LateState, u: LateInput, p: LateParameters) -> LateOutput:
    return LateOutput(u.u)


SHAFT = Continuous(
    "Shaft",
    shaft_derivative,
    shaft_output,
    ShaftState(),
    ShaftInput(),
    ShaftParameters(),
)
PI = Sampled(
    "Pi", pi_step, PiState(), PiInput(), PiParameters(), Fraction(1, 20_000), pi_prepare
)
ONE = (OneState(), OneInput(), OneParameters())
MODELS: dict[str, Model] = {
    "shaft": SHAFT,
    "pi": PI,
    "third": Sampled(
        "Third",
        pi_step,
        *(PI.state, PI.input, PI.parameters),
        Fraction(1, 3000),
        pi_prepare,
    ),
    "mix": Sampled("Mix", mix_step, MixState(), MixInput(), MixParameters()),
    "exact": Continuous(
        "Exact", one_derivative, one_output, *ONE, advance=one_advance, h_max=1e-3
    ),
    "explosive": Continuous("Explosive", explode, one_output, *ONE, h_max=1e-3),
    "counter": Continuous("Counter", one_derivative, one_output, *ONE, advance=count),
    "late": Continuous(
        "Late",
        late_derivative,
        late_output,
        LateState(),
        LateInput(),
        LateParameters(),
        delay={"u": "tau"},
    ),
}


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
