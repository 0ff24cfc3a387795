"""A clocked FMI 3.0 controller adds no sample; without its clock it adds one.

The driver is a Jacobi loop by hand over fmpy, independent of our master.
"""

import ctypes
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi3 import FMU3Slave
from lxml import etree
from systems import part, system

from fmus.build import build
from orchestrator.fmu.archive import read_member
from orchestrator.fmu.description import FmuDescription, read_fmu
from orchestrator.master.simulate import Choice, simulate
from orchestrator.system import Component, Mapped, System

T = Fraction(1, 2000)
STEPS = 200
PI = Path(__file__).parents[2] / "fmus" / "small_models" / "pi.py"


def loop(latency: int) -> System:
    """Return the PI controller around an integrator, reference 0, from x = 1."""
    pi = Component("pi", build(str(PI), fmi=3, period=T), T, latency=latency)
    pi = replace(
        pi, map={"y": Mapped("y", 1.0, unit="1"), "u": Mapped("u", 1.0, unit="1/s")}
    )
    plant = part("plant", "integrator", str(T), fmi=3, start={"state.x": 1.0})
    wires = {"pi.y": "plant.y", "plant.u": "pi.u"}
    return system(
        str(STEPS * T), [pi, plant], wires, {"pi.u": str(T), "plant.y": str(T)}
    )


class Driven:
    """One FMU under the driver."""

    def __init__(self, path: Path, folder: Path, *, clocked: bool) -> None:
        self.description: FmuDescription = read_fmu(path)
        self.clocked = clocked
        self.fmu = FMU3Slave(
            guid=self.description.token,
            modelIdentifier=self.description.model_identifier,
            unzipDirectory=fmpy.extract(str(path), str(folder)),
            instanceName="driven",
        )
        self.fmu.instantiate(eventModeUsed=clocked)

    def start(self, **values: float) -> None:
        for name, value in values.items():
            self.set(name.replace("__", "."), value)
        self.fmu.enterInitializationMode(startTime=0.0)

    def set(self, name: str, value: float) -> None:
        self.fmu.setFloat64([self.description[name].reference], [value])

    def get(self, name: str) -> float:
        return float(self.fmu.getFloat64([self.description[name].reference])[0])

    def tick(self) -> None:
        active = (ctypes.c_bool * 1)(True)
        clock = (ctypes.c_uint * 1)(self.description.clock)
        self.fmu.fmi3SetClock(self.fmu.component, clock, 1, active)
        assert not self.fmu.updateDiscreteStates()[0]

    def step(self, k: int) -> None:
        if self.clocked:
            self.fmu.enterStepMode()
        self.fmu.doStep(float(k * T), float(T))
        if self.clocked:
            self.fmu.enterEventMode()

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()


def driven(folder: Path, *, clocked: bool) -> tuple[list[float], list[float]]:
    """Return u and y at every exchange of the driver."""
    parts = loop(0).components
    pi = Driven(parts["pi"].fmu, folder / "pi", clocked=clocked)
    plant = Driven(parts["plant"].fmu, folder / "plant", clocked=False)
    pi.start()
    plant.start(state__x=1.0)
    pi.set("y", plant.get("y"))
    plant.set("u", pi.get("u"))
    for each in (pi, plant):
        each.fmu.exitInitializationMode()
    u, y = [], []
    for k in range(STEPS + 1):
        y.append(plant.get("y"))
        if clocked:
            pi.set("y", y[-1])
            pi.tick()
        u.append(pi.get("u"))
        if not clocked:
            pi.set("y", y[-1])
        plant.set("u", u[-1])
        pi.step(k)
        plant.step(k)
    pi.close()
    plant.close()
    return u, y


@pytest.mark.parametrize(("clocked", "latency"), [(True, 0), (False, 1)])
@pytest.mark.parametrize("executor", ["kernel", "python"])
def test_event_mode_is_latency_0_and_step_mode_latency_1(
    clocked: bool, latency: int, executor: Choice, tmp_path: Path
) -> None:
    u, y = driven(tmp_path, clocked=clocked)
    ours = simulate(loop(latency), tmp_path / "ours", executor=executor)
    np.testing.assert_array_equal(ours["plant.y"].values, y)
    np.testing.assert_array_equal(ours["pi.u"].values, u)


def test_the_two_ways_differ(tmp_path: Path) -> None:
    clocked, stepped = (driven(tmp_path / str(c), clocked=c)[1] for c in (True, False))
    assert np.max(np.abs(np.subtract(clocked, stepped))) > 1e-6


def test_steps_never_tick_a_clocked_fmu_and_outputs_hold(tmp_path: Path) -> None:
    counter = part("c", "counter", "1/2000", fmi=3)
    it = Driven(counter.fmu, tmp_path, clocked=True)
    it.start()
    it.fmu.exitInitializationMode()
    for k in range(3):
        it.step(k)
    assert it.get("k") == 0
    it.set("u", 7.0)
    assert it.get("seen") == 0
    it.tick()
    assert (it.get("k"), it.get("seen")) == (0, 7)
    it.tick()
    it.step(3)
    assert it.get("k") == 1
    it.close()


def test_the_clock_is_the_exact_period() -> None:
    fmu = part("c", "counter", "1/2000", fmi=3).fmu
    description = fmpy.read_model_description(str(fmu))
    (clock,) = (v for v in description.modelVariables if v.type == "Clock")
    root = etree.fromstring(read_member(fmu, "modelDescription.xml"))
    (element,) = root.iter("Clock")
    names = ("intervalCounter", "resolution")
    assert Fraction(*(int(element.get(name)) for name in names)) == T
    assert element.get("intervalVariability") == "constant"
    assert description.coSimulation.hasEventMode
    assert read_fmu(fmu).clock == clock.valueReference
    assert "clock" not in read_fmu(fmu).inputs
