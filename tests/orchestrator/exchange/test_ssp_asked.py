"""What may be asked for: parameter sets, sources outside, platforms; other tools."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from packages import component, experiment, package, parameter_set, ssd
from small_packages import KINDS, STEP, elements, values
from third_party import installed
from typer.testing import CliRunner
from wholes import SMALL, composed

from fmus.build import build
from fmus.compile import PLATFORMS
from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.load import load_package, read_package, schema_faults
from orchestrator.exchange.ssp.write import export_ssp
from orchestrator.fmu.description import read_fmu
from orchestrator.session import run

# written with pyssp-standard: a component each, parameters of both in a file
WRITER = """
import sys
from pathlib import Path
from pyssp_standard.common_content_ssc import TypeReal
from pyssp_standard.ssd import (
    Component, Connection, Connector, DefaultExperiment, ParameterBinding, System
)
from pyssp_standard.ssp import SSP
from pyssp_standard.ssv import SSV

target, fmu = map(Path, sys.argv[1:])
ssv = target.with_suffix(".ssv")
with SSV(ssv, "w") as parameters:
    parameters.add_parameter("a.k", "Real", value=3.0, unit="1")
    parameters.add_parameter("b.k", "Real", value=0.5, unit="1")
with SSP(target, mode="w") as archive:
    archive.add_resource(fmu)
    archive.add_resource(ssv)
    with archive.system_structure as ssd:
        ssd.name, ssd.version = "theirs", "1.0"
        ssd.system = System(None, "root")
        for name in ("a", "b"):
            part = Component()
            part.name, part.source = name, f"resources/{fmu.name}"
            part.component_type = "application/x-fmu-sharedlibrary"
            part.connectors = [
                Connector(None, n, kind, TypeReal(None))
                for n, kind in (("u", "input"), ("k", "parameter"), ("y", "output"))
            ]
            ssd.system.elements.append(part)
        ssd.add_connection(Connection(
            start_element="a", start_connector="y", end_element="b", end_connector="u"
        ))
        bound = ParameterBinding(source=f"resources/{ssv.name}")
        ssd.system.parameter_bindings = [bound]
        ssd.default_experiment = DefaultExperiment()
        ssd.default_experiment.start_time = 0.0
        ssd.default_experiment.stop_time = 0.01
"""


@pytest.fixture
def one(plain: Path, tmp_path: Path) -> Path:
    """A package of one component, y = u + k, with two sets to choose from."""
    text = ssd(elements(component("a", "r.fmu", KINDS)), experiment(annotations=STEP))
    sets = {
        f"resources/{name}.ssv": parameter_set(f"a.k Real value='{k}'")
        for name, k in (("cold", 2), ("warm", 7))
    }
    members = {"SystemStructure.ssd": text, "r.fmu": plain, **sets}
    return package(tmp_path / "one.ssp", members)


def test_a_parameter_set_is_chosen_by_name_or_file(one: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.ssv"
    own.write_text(parameter_set("a.k Real value='11'"))
    for ssv, k in (([], 0.0), (["cold"], 2.0), (["warm.ssv"], 7.0), ([str(own)], 11.0)):
        done = run(load_package(one, ssv=ssv), tmp_path / f"run{k}", report=False)
        assert float(done["a.y"].values[-1]) == k
    with pytest.raises(ScenarioError, match=r"--ssv wrm: .* did you mean .*warm"):
        load_package(one, ssv=["wrm"])
    target = tmp_path / "new"
    asked = ["import", str(one), "-o", str(target), "--ssv", "warm"]
    assert CliRunner().invoke(app, asked).exit_code == 0
    assert "k = 7" in (target / "plant.toml").read_text()
    refused = CliRunner().invoke(app, ["run", str(target / "plant.toml"), "--ssv", "x"])
    assert refused.exit_code == 2
    assert "is no package of SSP" in refused.output


def test_sources_outside_are_opened_with_trust_and_none_is_fetched(
    plain: Path, tmp_path: Path
) -> None:
    parts = [component("a", "../outside.fmu", KINDS)]
    parts.append(component("b", (tmp_path / "outside.fmu").as_uri(), KINDS))
    (tmp_path / "outside.fmu").write_bytes(plain.read_bytes())
    place = tmp_path / "unpacked"
    place.mkdir()
    file = place / "SystemStructure.ssd"
    file.write_text(ssd(elements(*parts), experiment(annotations=STEP)))
    asked = ["run", str(file), "-o", str(tmp_path / "run")]
    refused = CliRunner().invoke(app, asked)
    assert refused.exit_code == 2
    assert refused.output.count("look at it and give --trust") == 2
    assert CliRunner().invoke(app, [*asked, "--trust"]).exit_code == 0
    parts.append(component("c", "https://example.org/r.fmu", KINDS))
    file.write_text(ssd(elements(*parts), experiment(annotations=STEP)))
    refused = CliRunner().invoke(app, [*asked, "--trust", "--overwrite"])
    assert "c: source 'https://example.org/r.fmu'" in refused.output
    assert "nothing is fetched" in refused.output


def test_fmus_of_a_package_are_for_the_platforms_asked_for(
    plain: Path, tmp_path: Path
) -> None:
    scenario = tmp_path / "tone.toml"
    scenario.write_text(
        'stop = "0.01"\n[components.tone]\nfmu = "controllers.references.sine"\n'
        'step = "1 kHz"\n[record]\n"tone.x_r" = true\n'
    )
    target = tmp_path / "tone.ssp"
    asked = ["export", str(scenario), "-o", str(target)]
    for name in ("linux-x86_64", "linux-aarch64"):
        asked += ["--platform", name]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0, done.output
    with zipfile.ZipFile(target) as archive:
        (tmp_path / "tone.fmu").write_bytes(archive.read("resources/tone.fmu"))
    assert set(read_fmu(tmp_path / "tone.fmu").platforms) == {
        PLATFORMS[name].fmi2_folder for name in ("linux-x86_64", "linux-aarch64")
    }
    theirs = scenario.read_text().replace("controllers.references.sine", str(plain))
    scenario.write_text(theirs.replace("tone.x_r", "tone.y"))
    refused = CliRunner().invoke(app, [*asked, "--platform", "macos-arm64"])
    assert refused.exit_code == 2
    assert "has no binary for it; it has linux64" in refused.output


def test_an_fmu_with_both_interfaces_is_integrated_where_it_says_so(
    tmp_path: Path,
) -> None:
    fmu = build(str(SMALL / "spring_mass.py"))
    name = next(iter(read_fmu(fmu).outputs))
    found = {}
    for how in ("CoSimulation", "ModelExchange"):
        part = component("a", "r.fmu", "", f'implementation="{how}"')
        text = ssd(elements(part), experiment(annotations=STEP))
        members = {"SystemStructure.ssd": text, "r.fmu": fmu}
        scenario = load_package(package(tmp_path / f"{how}.ssp", members))
        by = scenario.spec.components["a"].interface
        assert by == ("model_exchange" if how == "ModelExchange" else None)
        done = run(scenario, tmp_path / how, report=False)
        found[how] = [float(v) for v in done[f"a.{name}"].values]
        lock = (tmp_path / how / "scenario.lock.toml").read_text()
        assert ("interface" in lock) == (how == "ModelExchange")
        again = export_ssp(
            composed(tmp_path / how / "scenario.lock.toml"), tmp_path / "x.ssp"
        )
        assert read_package(again).components["a"].get("interface") == by
    assert found["ModelExchange"] == pytest.approx(found["CoSimulation"], rel=1e-4)
    assert found["ModelExchange"] != found["CoSimulation"]


def test_a_package_that_another_tool_wrote_runs(plain: Path, tmp_path: Path) -> None:
    tool = installed("pyssp-standard==0.9.1", sys.executable)
    target = tmp_path / "theirs.ssp"
    subprocess.run(
        [sys.executable, "-c", WRITER, str(target), str(plain)],
        env={"PYTHONPATH": str(tool)},
        check=True,
    )
    assert schema_faults(target) == []
    with pytest.raises(ScenarioError, match=r"nobody says a step; add --set"):
        load_package(target)
    sets = ("rates.step=1/1000",)
    assert values(target, tmp_path / "run", "a.y", "b.y", sets=sets) == [3.0, 3.5]
