"""Python FMUs run in processes of their own, with the numbers of the native ones."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from systems import MODELS, part, system

from fmus.build import build
from orchestrator.errors import SimulationError
from orchestrator.result import Result
from orchestrator.system import Component, System

Run = Callable[[System], Result]


def as_python(component: Component, model: str) -> Component:
    return replace(component, fmu=build(str(MODELS / f"{model}.py"), kind="python"))


def test_python_and_native_components_work_together(run: Run) -> None:
    native = [part("a", "counter", "1/1000"), part("b", "integrator", "1/500")]
    python = [as_python(native[0], "counter"), as_python(native[1], "integrator")]
    wires = {"b.u": "a.rate", "a.u": "b.y"}
    rows = {"a.seen": "1/1000", "b.y": "1/1000"}
    results = []
    for first in (native[0], python[0]):
        for second in (native[1], python[1]):
            result = run(system("1/50", [first, second], wires, rows))
            results.append({name: np.array(result[name]) for name in rows})
    for other in results[1:]:
        for name in rows:
            np.testing.assert_allclose(other[name], results[0][name], rtol=1e-13)


def test_two_python_fmus_of_one_module_name_run_their_own_code(
    run: Run, tmp_path: Path
) -> None:
    source = (MODELS / "counter.py").read_text()
    twin = tmp_path / "twin" / "counter.py"
    twin.parent.mkdir()
    twin.write_text(source.replace("Output(x.k, x.k,", "Output(-x.k, x.k,"))
    plain = part("a", "counter", "1/1000")
    parts = [
        as_python(plain, "counter"),
        replace(plain, name="b", fmu=build(str(twin), kind="python")),
    ]
    result = run(system("1/100", parts, record={"a.k": "1/100", "b.k": "1/100"}))
    assert result["a.k"].values.tolist() == [0, 10]
    assert result["b.k"].values.tolist() == [0, -10]


def test_a_python_fmu_that_kills_its_process_ends_the_run_by_name(
    run: Run, tmp_path: Path
) -> None:
    source = (MODELS / "counter.py").read_text()
    fatal = tmp_path / "fatal.py"
    fatal.write_text(
        source.replace(
            "    return State(x.k + 1)",
            # not where it is built, which runs it too
            "    import multiprocessing, os\n"
            "    apart = multiprocessing.parent_process() is not None\n"
            "    if apart and isinstance(x.k, float) and x.k == 5:\n"
            "        os._exit(3)\n    return State(x.k + 1)",
        )
    )
    component = replace(
        part("a", "counter", "1/1000"), fmu=build(str(fatal), kind="python")
    )
    with pytest.raises(SimulationError, match=r"a \(Counter\.fmu\).*exit code 3"):
        run(system("1/100", [component], record={"a.k": "1/1000"}))
    kept = Result(tmp_path)["a.k"]
    assert kept.values.tolist() == [0, 1, 2, 3, 4]
