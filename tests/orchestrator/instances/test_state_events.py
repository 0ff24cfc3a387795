"""State events happen where FMI puts them: z > 0 and z <= 0 are the two domains."""

import re
from fractions import Fraction
from math import log
from pathlib import Path

import numpy as np
import pytest
from broken import SOURCES
from foreign import compile_source, packed
from systems import part, system

from orchestrator.master.simulate import Choice, simulate
from orchestrator.system import Component, Isolation

NAMES = ("x", "der_x", "u", "on", "changed", "changes")
PARAMETERS = {"rate": 1, "decay": 0, "by": 0, "sign": 1, "level": 0, "ends": 0}
STATE, TIME, INPUT = 0, 1, 2

# what is crossed how, with steps of 1 s; on at t = 0, 1, 2, 3 and when it changed
CROSSINGS: dict[str, tuple[dict[str, float], tuple[int, ...], float | None]] = {
    "rising inside a step": ({"level": 0.5}, (0, 1, 1, 1), 0.5),
    "falling inside a step": ({"level": 0.5, "sign": -1}, (1, 0, 0, 0), 0.5),
    "rising from the start": ({}, (0, 1, 1, 1), 0.0),
    "falling from the start": ({"sign": -1}, (0, 0, 0, 0), None),
    "rising through a start off zero": ({"x": -2.5}, (0, 0, 0, 1), 2.5),
    "rising at a communication point": ({"level": 2}, (0, 0, 0, 1), 2.0),
    "falling at a communication point": (
        {"level": 2, "sign": -1, "by": TIME},
        (1, 1, 0, 0),
        2.0,
    ),
    "rising by time": ({"level": 0.5, "by": TIME}, (0, 1, 1, 1), 0.5),
    "rising by time at a point": ({"level": 1, "by": TIME}, (0, 0, 1, 1), 1.0),
    "falling by time": ({"level": 1.25, "sign": -1, "by": TIME}, (1, 1, 0, 0), 1.25),
    "a curve falling": (
        {"x": 1, "rate": 0, "decay": -1, "level": 0.5},
        (1, 0, 0, 0),
        log(2),
    ),
    "a curve rising": (
        {"x": -1, "rate": 0, "decay": -1, "level": -0.25},
        (0, 0, 1, 1),
        log(4),
    ),
}


@pytest.fixture(scope="module")
def switches(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    return {fmi: _switch(fmi, tmp_path_factory.mktemp(f"fmi{fmi}")) for fmi in (2, 3)}


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("crossing", CROSSINGS)
def test_a_state_event_happens_when_its_domain_changes(
    tmp_path: Path, switches: dict[int, Path], fmi: int, crossing: str
) -> None:
    values, on, changed = CROSSINGS[crossing]
    start = {"x": values["x"]} if "x" in values else {}
    parameters = {k: v for k, v in values.items() if k != "x"}
    a = Component("a", switches[fmi], Fraction(1), parameters=parameters, start=start)
    rows = {f"a.{name}": "1" for name in ("on", "changed", "changes")}
    found = simulate(system("3", [a], {}, rows), tmp_path)
    assert tuple(np.array(found["a.on"])) == on
    assert found["a.changes"].values[-1] == (changed is not None)
    if changed is not None:
        assert found["a.changed"].values[-1] == pytest.approx(changed, abs=1e-8)


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_input_that_reaches_zero_exactly_changes_nothing_and_beyond_it_does(
    tmp_path: Path, switches: dict[int, Path], fmi: int
) -> None:
    values = {"by": INPUT, "level": 1}
    a = Component("a", switches[fmi], Fraction(1), parameters=values)
    source = part("source", "counter", "1")
    rows = {"a.on": "1", "a.u": "1"}
    found = simulate(system("4", [a, source], {"a.u": "source.k"}, rows), tmp_path)
    u, on = np.array(found["a.u"]), np.array(found["a.on"])
    assert list(u) == [0, 1, 2, 3, 4]
    # what was published at a point acts in the step that begins there
    assert list(on[1:]) == [float(value > 1) for value in u[:-1]]


@pytest.mark.parametrize(
    ("fmi", "executor", "apart"),
    [(2, "kernel", False), (3, "python", False), (3, "kernel", True)],
)
def test_an_event_may_end_the_run(
    tmp_path: Path, switches: dict[int, Path], fmi: int, executor: Choice, apart: bool
) -> None:
    a = Component(
        "a",
        switches[fmi],
        Fraction(1),
        parameters={"level": 1.5, "ends": 1},
        isolation=Isolation(process=apart),
    )
    given = system("3", [a], {}, {"a.x": "1"})
    found = simulate(given, tmp_path, executor=executor)
    assert found.ended is not None
    assert found.ended.by == "a"
    assert found.ended.at == pytest.approx(1.5)
    assert len(found["a.x"]) == 2


def _switch(fmi: int, folder: Path) -> Path:
    source = SOURCES / "events.c"
    named = re.findall(r"NAMED\((\w+)\)\(", source.read_text())
    present = [f"fmi{fmi}{name}" for name in named]
    library = compile_source(fmi, source, folder, present, {})
    return packed(fmi, folder, library, _description(fmi))


def _description(fmi: int) -> str:
    kinds = {
        "x": ('causality="output" initial="exact"', 'start="0"'),
        "der_x": ('causality="local"', ""),
        "u": ('causality="input"', 'start="0"'),
        "on": ('causality="output" variability="discrete"', ""),
        "changed": ('causality="output" variability="discrete"', ""),
        "changes": ('causality="output" variability="discrete"', ""),
    }
    fixed = 'causality="parameter" variability="fixed"'
    kinds |= {k: (fixed, f'start="{v}"') for k, v in PARAMETERS.items()}
    lines = []
    for i, (name, (head, start)) in enumerate(kinds.items()):
        head = f'name="{name}" valueReference="{i}" {head}'
        derivative = f'derivative="{3 - fmi}"' if name == "der_x" else ""
        if fmi == 2:
            real = f"<Real {start} {derivative}/>"
            lines.append(f"<ScalarVariable {head}>{real}</ScalarVariable>")
        else:
            lines.append(f"<Float64 {head} {start} {derivative}/>")
    outputs = [i for i, (head, _) in enumerate(kinds.values()) if "output" in head]
    if fmi == 2:
        head = 'fmiVersion="2.0" guid="x" numberOfEventIndicators="1"'
        found = "".join(f'<Unknown index="{i + 1}"/>' for i in outputs)
        structure = f"<Outputs>{found}</Outputs><Derivatives><Unknown index='2'/>"
        structure += "</Derivatives>"
    else:
        head = 'fmiVersion="3.0" instantiationToken="x"'
        structure = "".join(f'<Output valueReference="{i}"/>' for i in outputs)
        structure += '<ContinuousStateDerivative valueReference="1"/>'
        structure += '<EventIndicator valueReference="2"/>'
    return (
        f'<?xml version="1.0"?><fmiModelDescription {head} modelName="Events">'
        f'<ModelExchange modelIdentifier="events"/>'
        f"<ModelVariables>{''.join(lines)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )
