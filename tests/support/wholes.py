"""Compositions as one FMU, in FMPy."""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from fmus.subject import Fmi
from orchestrator.exchange.whole.export import export_whole
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

SMALL = Path(__file__).parents[1] / "fmus" / "small_models"
INTEGRATOR = SMALL.parents[1] / "orchestrator" / "models" / "integrator.py"
THREE_RATES = f"""
stop = "1/10"
[components.tone]
fmu = "controllers.references.sine"
step = "1 kHz"
offset = "1/3000"
latency = 2
parameters = {{ frequency_hz = 20 }}
map = {{ x_r = {{ name = "x_r", gain = 300, offset = 0.1, unit = "V" }} }}
[components.late]
fmu = "{SMALL / "late.py"}"
step = "1/4000"
[components.pi]
fmu = "{SMALL / "pi.py"}"
step = "1/1500"
map = {{ y = {{ name = "y", gain = 2, unit = "V" }} }}
[connections]
"late.u" = "tone.x_r"
"pi.y" = "late.y"
[record]
"late.y" = "1/12000"
"pi.u" = "1/12000"
"tone.x_r" = "1/12000"
"""
CIRCLE = f"""
stop = "1"
[components.a]
fmu = "{INTEGRATOR}"
step = "1/10"
parameters = {{ g = 0.5 }}
start = {{ "state.x" = 1.0 }}
[components.b]
fmu = "{INTEGRATOR}"
step = "1/10"
parameters = {{ g = 0.5 }}
start = {{ "state.x" = 2.0 }}
[connections]
"a.u" = "b.z"
"b.u" = "a.z"
[record]
"a.z" = true
"b.z" = true
"""


class Slave:
    """An FMU in FMPy, its numbers by name; ``step`` as any master steps it."""

    def __init__(self, file: Path, folder: Path) -> None:
        self.description = fmpy.read_model_description(str(file))
        self.three = self.description.fmiVersion.startswith("3")
        self.fmu = (FMU3Slave if self.three else FMU2Slave)(
            guid=self.description.guid,
            unzipDirectory=fmpy.extract(str(file), str(folder)),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="whole",
        )
        self.fmu.instantiate()
        variables = self.description.modelVariables
        self.references = {v.name: v.valueReference for v in variables}
        self.outputs = [v.name for v in variables if v.causality == "output"]

    def set(self, name: str, value: float) -> None:
        write = self.fmu.setFloat64 if self.three else self.fmu.setReal
        write([self.references[name]], [value])

    def get(self, *names: str) -> list[float]:
        read = self.fmu.getFloat64 if self.three else self.fmu.getReal
        return [float(value) for value in read([self.references[n] for n in names])]

    def begin(self, **values: float) -> None:
        if not self.three:
            self.fmu.setupExperiment()
        for name, value in values.items():
            self.set(name, value)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def row(self) -> list[float]:
        return self.get(*self.outputs)

    def step(self, k: int, step: Fraction) -> None:
        self.fmu.doStep(float(k * step), float(step))

    def rows(self, step: Fraction, count: int, first: int = 0) -> list[list[float]]:
        found = [] if first else [self.row()]
        for k in range(first, count):
            self.step(k, step)
            found.append(self.row())
        return found


def composed(file: Path, *sets: str) -> Composition:
    return compose(load_scenario(file, sets), run_earlier)


def exported(
    text: str,
    folder: Path,
    *sets: str,
    fmi: Fmi = 2,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
) -> Slave:
    """Return the FMU ``whole.fmu`` of ``scenario.toml``, both written to a folder."""
    file = folder / "scenario.toml"
    file.write_text(text)
    target = folder / "whole.fmu"
    made = export_whole(composed(file, *sets), target, inputs, outputs, fmi=fmi)
    return Slave(made, folder / f"unpacked{fmi}")
