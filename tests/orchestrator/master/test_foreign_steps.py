"""What a foreign FMU says of its steps and start values is respected."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from broken import MISBEHAVES, MODES, pack
from foreign import foreign
from systems import part, system

from orchestrator.errors import ScheduleError, SimulationError
from orchestrator.master.simulate import plan, simulate
from orchestrator.system import Component, System

FIXED = MISBEHAVES.replace('StepSize="true"', 'StepSize="false"')


def mixed(fmu: Path, **options: Fraction) -> System:
    """Return an FMU that refuses unequal steps, behind a source between them."""
    theirs = Component(
        "theirs",
        fmu,
        Fraction("1/1000"),
        parameters={"mode": MODES.index("equal_steps"), "at": 0.0},
        **options,  # type: ignore[arg-type]
    )
    source = part("source", "counter", "1/1500")
    wires = {"theirs.u": "source.k"}
    return system("1/100", [theirs, source], wires, {"theirs.y": "1/1000"})


def test_an_fmu_of_fixed_steps_gets_equal_steps_and_inputs_wait(tmp_path: Path) -> None:
    result = simulate(mixed(pack("misbehaves", FIXED, tmp_path)), tmp_path)
    y, t = result["theirs.y"].values, result["theirs.y"].time
    waited = [0, *(k * 3 // 2 for k in range(10))]  # the source's tick at the start
    np.testing.assert_allclose(y, waited + t, atol=1e-12)


def test_an_fmu_of_variable_steps_has_them_split_where_its_source_publishes(
    tmp_path: Path,
) -> None:
    fmu = pack("misbehaves", MISBEHAVES, tmp_path)
    with pytest.raises(SimulationError, match=r"doStep of 0.000333.* returned Discard"):
        simulate(mixed(fmu), tmp_path)


def test_a_stop_or_offset_that_fixed_steps_cannot_meet_is_refused(
    tmp_path: Path,
) -> None:
    fmu = pack("misbehaves", FIXED, tmp_path)
    with pytest.raises(ScheduleError, match=r"nearest stops are 1/100 and 11/1000 s"):
        simulate(replace(mixed(fmu), stop=Fraction("21/2000")), tmp_path)
    with pytest.raises(ScheduleError, match=r"has a fixed step and cannot start with"):
        simulate(mixed(fmu, offset=Fraction("1/2000")), tmp_path)


@pytest.mark.parametrize("inside", ["5e-5", "0.001", "3.33333333e-4"])
def test_steps_are_whole_multiples_of_the_step_inside(
    tmp_path: Path, inside: str
) -> None:
    assert plan(stepping_by(inside, tmp_path))


@pytest.mark.parametrize("inside", ["3e-5", "0.002", "0.0007"])
def test_no_multiple_of_the_step_inside_is_refused(tmp_path: Path, inside: str) -> None:
    with pytest.raises(ScheduleError, match=r"fixedInternalStepSize.* set step"):
        plan(stepping_by(inside, tmp_path))


def stepping_by(inside: str, folder: Path) -> System:
    """Return a foreign FMU at 1 ms that steps by ``inside`` s."""
    whole, changed = foreign(3, folder), folder / "changed.fmu"
    with ZipFile(whole) as old, ZipFile(changed, "w") as new:
        for name in old.namelist():
            text = old.read(name)
            if name == "modelDescription.xml":
                fixed = f'StepSize="false" fixedInternalStepSize="{inside}"'
                text = text.replace(b'StepSize="true"', fixed.encode())
            new.writestr(name, text)
    return system("1/100", [Component("theirs", changed, Fraction("1/1000"))])


def test_start_values_of_an_fmu_hold_unless_the_scenario_gives_others(
    tmp_path: Path,
) -> None:
    fmu = pack("misbehaves", MISBEHAVES, tmp_path)
    T = Fraction("1/1000")
    parts = [
        Component("a", fmu, T),
        Component("b", fmu, T, start={"u": 4.0}),
    ]
    rows = {f"{n}.{x}": "1/1000" for n in "ab" for x in "uy"}
    result = simulate(system("1/1000", parts, {}, rows), tmp_path)
    assert result["a.u"].values.tolist() == [0.0, 0.0]
    assert result["b.u"].values.tolist() == [4.0, 4.0]
    assert result["b.y"].values[-1] == 4.001
    assert result["a.y"].values[-1] == 0.001
