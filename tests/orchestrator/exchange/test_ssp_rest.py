"""What else packages hold: calculated parameters, texts, folders, and refusals."""

from pathlib import Path

import pytest
from packages import (
    VERSION,
    binding,
    component,
    connections,
    connectors,
    experiment,
    package,
    parameter_set,
    ssd,
    unit,
)
from small_packages import KINDS, STEP, elements, values
from stub import Stub, stub
from talking import talking
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.load import load_package, schema_faults
from orchestrator.session import run


def test_a_calculated_parameter_feeds_an_input(
    compiled: Path, plain: Path, tmp_path: Path
) -> None:
    """c = k, which the FMU works out of its parameter."""
    of = {"k": Stub("parameter"), "c": Stub("calculatedParameter")}
    fmu = stub(compiled, tmp_path / "c.fmu", of)
    set_k = binding(parameter_set('k Real value="3"'))
    first = component("a", "c.fmu", connectors(c="calculatedParameter") + set_k)
    parts = elements(first, component("b", "r.fmu", KINDS))
    text = ssd(parts + connections("a.c -> b.u"), experiment(annotations=STEP))
    members = {"SystemStructure.ssd": text, "c.fmu": fmu, "r.fmu": plain}
    file = package(tmp_path / "a.ssp", members)
    assert values(file, tmp_path / "run", "b.y") == [3.0]


def test_newton_metres_are_called_nm_by_others(compiled: Path, tmp_path: Path) -> None:
    of = {
        name: Stub(kind, unit="N.m")
        for name, kind in (("u", "input"), ("k", "parameter"), ("y", "output"))
    }
    fmu = stub(compiled, tmp_path / "m.fmu", of)
    given = parameter_set('k Real value="2" unit="Nm"')
    ends = connectors(u="input Nm", y="output Nm")
    parts = elements(
        component("a", "m.fmu", ends + binding(given)), component("b", "m.fmu", ends)
    )
    units = unit("Nm", 'kg="1" m="2" s="-2"')
    text = ssd(parts + connections("a.y -> b.u"), units + experiment(annotations=STEP))
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "m.fmu": fmu})
    assert values(file, tmp_path / "run", "b.y") == [2.0]


def test_texts_are_connected_as_they_are(tmp_path: Path) -> None:
    fmu = talking(2, tmp_path)
    said = '<ssd:Connector name="{0}" kind="{1}"><ssc:String/></ssd:Connector>'
    ends = said.format("heard", "input") + said.format("text", "output")
    kinds = f"<ssd:Connectors>{ends}</ssd:Connectors>"
    parts = elements(*(component(name, "t.fmu", kinds) for name in "ab"))
    text = ssd(parts + connections("a.text -> b.heard"), experiment(annotations=STEP))
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "t.fmu": fmu})
    scenario = load_package(file)
    assert scenario.spec.connections == {"b.heard": "a.text"}
    done = run(scenario, tmp_path / "run", report=False)
    assert float(done["b.k"].values[-1]) == 10
    assert done.timing.executor == "python"


def test_an_unpacked_folder_runs_as_the_archive_does(
    plain: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "unpacked"
    folder.mkdir()
    set_k = binding(parameter_set('k Real value="4"'))
    parts = elements(component("a", "r.fmu", KINDS + set_k))
    text = ssd(parts, experiment(annotations=STEP))
    (folder / "SystemStructure.ssd").write_text(text)
    (folder / "r.fmu").write_bytes(plain.read_bytes())
    assert values(folder, tmp_path / "run", "a.y") == [4.0]


def test_what_ssp_leaves_open_or_we_do_not_do_is_named(
    plain: Path, tmp_path: Path
) -> None:
    parts = elements(
        component("a", "r.fmu", KINDS),
        component("b", "r.fmu", KINDS, 'implementation="ScheduledExecution"'),
    )
    wires = connections('a.y -> b.u|startIndices="1"|')
    late = experiment(annotations=STEP).replace(" stopTime", ' startTime="1" stopTime')
    VERSION.append("2.0")
    try:
        text = ssd(parts + wires, late)
    finally:
        VERSION.pop()
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "r.fmu": plain})
    assert schema_faults(file) == []
    with pytest.raises(ScenarioError) as refused:
        load_package(file)
    for told in (
        "3 things cannot be run",
        "a.y -> b.u: connects elements of arrays, of which SSP does not say from which",
        "b: is to be run by ScheduledExecution, and r.fmu has CoSimulation",
        "DefaultExperiment: starts at 1 s; a run starts at 0: set startTime to 0",
    ):
        assert told in str(refused.value)


def test_check_names_what_does_not_follow_the_schema(
    plain: Path, tmp_path: Path
) -> None:
    parts = elements(component("a", "r.fmu", KINDS)).replace("kind=", "kin=", 1)
    text = ssd(parts, experiment(annotations=STEP))
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "r.fmu": plain})
    done = CliRunner().invoke(app, ["check", str(file)])
    assert done.exit_code != 0
    assert "SystemStructure.ssd: line " in " ".join(done.output.split())
    assert "kin" in done.output
