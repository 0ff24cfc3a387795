"""What FMI 3.0 FMUs for model exchange say of themselves only when they run."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from broken import SOURCES
from foreign import compile_source, packed
from systems import part, system

from orchestrator.master.simulate import simulate
from orchestrator.system import Component

DESCRIPTION = """<?xml version="1.0"?>
<fmiModelDescription fmiVersion="3.0" instantiationToken="x" modelName="Sampling">
<ModelExchange modelIdentifier="sampling"/><ModelVariables>
<Float64 name="time" valueReference="0" causality="independent"/>
<UInt64 name="n" valueReference="1" causality="structuralParameter" start="2"/>
<Float64 name="x" valueReference="2" initial="exact" start="0">{n}</Float64>
<Float64 name="der_x" valueReference="3" derivative="2">{n}</Float64>
<Float64 name="tick" valueReference="4" causality="parameter" variability="fixed"
  start="1"/>
<Float64 name="u" valueReference="5" causality="input" start="0"/>
<Float64 name="count" valueReference="6" causality="output" variability="discrete"/>
<Float64 name="held" valueReference="7" causality="output" variability="discrete"/>
</ModelVariables><ModelStructure><Output valueReference="6" dependencies=""/>
<Output valueReference="7" dependencies=""/>
<ContinuousStateDerivative valueReference="3"/></ModelStructure></fmiModelDescription>
""".format(n='<Dimension valueReference="1"/>')


@pytest.fixture(scope="module")
def sampling(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sampling")
    library = compile_source(3, SOURCES / "sampling.c", folder, (), {})
    return packed(3, folder, library, DESCRIPTION)


@pytest.mark.parametrize("n", [1, 2, 4])
def test_as_many_states_are_integrated_as_a_structural_parameter_makes_them(
    tmp_path: Path, sampling: Path, n: int
) -> None:
    a = Component("a", sampling, Fraction(1, 2), parameters={"n": n})
    rows = {f"a.x[{i}]": "1/2" for i in range(1, n + 1)}
    found = simulate(system("1", [a], {}, rows), tmp_path)
    assert [found[name].values[-1] for name in rows] == pytest.approx(range(1, n + 1))


@pytest.mark.parametrize("step", ["1/10", "1/1000", "1/3000", "1/7"])
def test_a_time_event_at_a_row_is_in_it_however_both_are_rounded(
    tmp_path: Path, sampling: Path, step: str
) -> None:
    """The FMU multiplies, the run has t + h of t: both may miss k h by a rounding."""
    h = Fraction(step)
    a = Component("a", sampling, h, parameters={"tick": float(h)})
    source = part("source", "counter", step)
    rows = {"a.count": step, "a.held": step, "a.u": step}
    links = {"a.u": "source.k"}
    found = simulate(system(str(100 * h), [a, source], links, rows), tmp_path)
    k = np.arange(101)
    np.testing.assert_array_equal(found["a.count"].values, k)
    held = found["a.held"].values[1:]  # what u was while it went there
    np.testing.assert_array_equal(held, found["a.u"].values[:-1])
