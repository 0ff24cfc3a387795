"""What docs/your-tool.md says of loops closed in plain FMPy is so."""

from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave

from fmus.build import build
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

T = 1 / 2000
N = 1000
REFERENCE, CONTROLLER, PLANT = (
    "controllers.references.sine",
    "controllers.xy_table.np_pi",
    "plants.xy_table.axis",
)


class Fmu:
    """One FMU in plain FMPy, variables by name."""

    def __init__(self, module: str, folder: Path, **start: float) -> None:
        period = None if module == PLANT else Fraction(1, 2000)
        self.file = str(build(module, fmi=2, period=period))
        description = fmpy.read_model_description(self.file)
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(self.file, folder / module),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=module,
        )
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0)
        self.set(**start)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def set(self, **values: float) -> None:
        references = [self.references[name] for name in values]
        self.slave.setReal(references, list(values.values()))

    def get(self, name: str) -> float:
        return float(self.slave.getReal([self.references[name]])[0])

    def step(self, t: float, h: float) -> None:
        self.slave.doStep(t, h)


@pytest.fixture
def fmus(tmp_path: Path) -> Iterator[list[Fmu]]:
    """Source, controller, plant; FMPy converts no units, so the sine is in mm."""
    parts = [
        Fmu(REFERENCE, tmp_path, amplitude=10.0, frequency_hz=0.7),
        Fmu(CONTROLLER, tmp_path),
        Fmu(PLANT, tmp_path),
    ]
    yield parts
    for part in parts:
        part.slave.terminate()
        part.slave.freeInstance()


def read(source: Fmu, controller: Fmu, plant: Fmu) -> None:
    controller.set(z_ref=source.get("x_r"), y=plant.get("y"), v=plant.get("v"))


def all_then_exchange(parts: list[Fmu], steps: int = 1) -> list[float]:
    """Return positions of a loop that exchanges after all have stepped (Jacobi)."""
    _, controller, plant = parts
    y, h = [plant.get("y")], T / steps
    for k in range(N * steps):
        read(*parts)
        plant.set(u=controller.get("u"))
        for part in parts:
            part.step(k * h, h)
        if (k + 1) % steps == 0:
            y.append(plant.get("y"))
    return y


def one_after_the_other(parts: list[Fmu]) -> list[float]:
    """Return positions of a loop in the order of the signal (Gauss-Seidel)."""
    source, controller, plant = parts
    y = [plant.get("y")]
    for k in range(N):
        source.step(k * T, T)
        read(*parts)
        controller.step(k * T, T)
        plant.set(u=controller.get("u"))
        plant.step(k * T, T)
        y.append(plant.get("y"))
    return y


LATE = ("reference.latency=1", "controller.latency=1")
FINE = ("reference.latency=1", "plant.tau=1.25e-3")


@pytest.mark.parametrize(
    ("loop", "overrides", "at_100_ms"),
    [
        (one_after_the_other, (), 4.0966),
        (all_then_exchange, LATE, 3.9912),
        (lambda parts: all_then_exchange(parts, 10), FINE, 4.0765),
    ],
    ids=["one after the other", "exchange after all", "exchange ten times a sample"],
)
def test_a_loop_in_plain_fmpy_is_ours_with_the_latency_it_adds(
    fmus: list[Fmu],
    tmp_path: Path,
    loop: Callable[[list[Fmu]], list[float]],
    overrides: tuple[str, ...],
    at_100_ms: float,
) -> None:
    name = "cascade_nppi/np_pi_0_7hz"
    ours = run(load_scenario(name, overrides), tmp_path / "run", report=False)
    y = ours["plant.y"].values[: N + 1]
    np.testing.assert_allclose(loop(fmus), y, rtol=0, atol=1e-11)
    assert y[200] == pytest.approx(at_100_ms, abs=5e-5)


def rows_of(module: str, names: dict[str, np.ndarray], output: str) -> np.ndarray:
    """Return the output that FMPy's simulate_fmu shows for recorded inputs."""
    time = np.arange(N + 1) * T
    signals = np.zeros(N + 1, dtype=[("time", float), *((n, float) for n in names)])
    signals["time"] = time
    for name, values in names.items():
        signals[name] = values[: N + 1]
    period = None if module == PLANT else Fraction(1, 2000)
    rows = fmpy.simulate_fmu(
        str(build(module, fmi=2, period=period)),
        stop_time=time[-1],
        step_size=T,
        output_interval=T,
        input=signals,
        output=[output],
    )
    return np.asarray(rows[output])


def test_simulate_fmu_moves_a_plant_in_time_and_shows_a_controller_one_row_late(
    tmp_path: Path,
) -> None:
    found = run("cascade_nppi/np_pi_0_7hz", tmp_path / "run", report=False)
    y, u = found["plant.y"].values, found["controller.u"].values
    z_ref = 1e3 * found["reference.x_r"].values
    shown = rows_of(CONTROLLER, {"z_ref": z_ref, "y": y}, "u")
    np.testing.assert_array_equal(shown[1:], u[:N])
    moved = rows_of(PLANT, {"u": u}, "y")
    np.testing.assert_allclose(moved, y[: N + 1], rtol=0, atol=1e-11)
