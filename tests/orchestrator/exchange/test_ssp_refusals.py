"""What of a package cannot run is named, all at once."""

from pathlib import Path

import pytest
from packages import (
    component,
    connections,
    connectors,
    experiment,
    linear,
    package,
    ssd,
)
from small_packages import KINDS, PLAIN, STEP, elements
from stub import Stub, stub
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.load import load_package


def refused(file: Path) -> str:
    with pytest.raises(ScenarioError) as error:
        load_package(file)
    return str(error.value)


def test_all_that_cannot_be_run_is_named_at_once(
    plain: Path, compiled: Path, tmp_path: Path
) -> None:
    exchange = stub(compiled, tmp_path / "me.fmu", PLAIN, interface="ModelExchange")
    parts = elements(
        component("a", "r.fmu", KINDS),
        component("b", "../r.fmu", KINDS),
        component("c", "https://example.org/r.fmu", KINDS),
        component("d", "gone.fmu", KINDS),
        component("e", "r.fmu", KINDS, 'implementation="ModelExchange"'),
        component("f", "me.fmu", KINDS, 'implementation="CoSimulation"'),
        component("g", "r.m", KINDS, 'type="text/x-matlab"'),
        component("h", "r.fmu", connectors(u="input", y="output", gone="input")),
        '<ssd:SignalDictionaryReference name="bus" dictionary="d"/>',
    )
    wires = connections(
        f"h.u -> a.y||{linear(2)}",
        "a.y -> h.gone",
        "a.y -> e.u",
        "h.y -> e.u",
        "a.y -> h.y",
        "a.y -> nobody.u",
        "a.y -> h.u||<ssc:BooleanMappingTransformation>"
        '<ssc:MapEntry source="true" target="false"/>'
        "</ssc:BooleanMappingTransformation>",
    )
    text = ssd(parts + wires, experiment("-1", STEP))
    file = package(
        tmp_path / "a.ssp",
        {"SystemStructure.ssd": text, "r.fmu": plain, "me.fmu": exchange},
    )
    told = refused(file)
    for expected in (
        "b: source '../r.fmu' lies outside the package",
        "c: source 'https://example.org/r.fmu' lies outside the package",
        "d: source 'gone.fmu': there is no such file",
        "e: is to be run by ModelExchange, and r.fmu has CoSimulation",
        "f: is to be run by CoSimulation, and me.fmu has ModelExchange",
        "g: is of type text/x-matlab",
        "h: connector 'gone' is no variable of r.fmu",
        "bus: there is no signal dictionary 'd' in its system or around it",
        "written against its signal and has a transformation",
        "feeds what root: a.y -> e.u feeds already",
        "root: a.y -> h.y: both ends feed",
        "there is no element 'nobody'",
        "root: a.y -> h.u: maps Boolean values, and y is a Real",
        "stops at -1 s",
    ):
        assert expected in told
    assert told.startswith(f"{file}: 14 things cannot be run:")
    done = CliRunner().invoke(app, ["run", str(file)])
    assert done.exit_code == 2


def test_where_ssp_leaves_a_number_open_it_is_refused(
    compiled: Path, tmp_path: Path
) -> None:
    variables = {
        "u": Stub("input", unit="mm"),
        "y": Stub("output", unit="m"),
        "z": Stub("output", unit="rad"),
    }
    fmu = stub(compiled, tmp_path / "u.fmu", variables)
    kinds = connectors(u="input", y="output", z="output")
    parts = elements(*(component(n, "u.fmu", kinds) for n in "abc"))
    wires = connections(f"a.y -> b.u||{linear(2, 1)}", "a.z -> c.u")
    text = ssd(parts + wires, experiment(annotations=STEP))
    told = refused(
        package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "u.fmu": fmu})
    )
    assert "SSP leaves open which comes first" in told
    assert "a.z -> c.u: rad cannot become mm" in told


def test_what_is_no_package_is_said(tmp_path: Path) -> None:
    (tmp_path / "a.ssp").write_text("no archive")
    assert "not a readable zip archive" in refused(tmp_path / "a.ssp")
    assert "no such file" in refused(tmp_path / "gone.ssp")
    (tmp_path / "b.ssd").write_text("<a>")
    assert "b.ssd: is no XML" in refused(tmp_path / "b.ssd")
    (tmp_path / "c.ssd").write_text("<a/>")
    assert "is no system structure description but 'a'" in refused(tmp_path / "c.ssd")
    empty = package(tmp_path / "d.ssp", {"x.txt": ""})
    assert "holds no SystemStructure.ssd" in refused(empty)
