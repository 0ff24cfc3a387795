"""A scenario as a package: schema-valid, byte-stable, exact, and ours again."""

from pathlib import Path
from zipfile import ZipFile

import pytest
from lxml import etree
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.beside import write_beside
from orchestrator.exchange.ssp.load import load_package, schema_faults
from orchestrator.exchange.ssp.write import export_ssp, members
from orchestrator.exchange.ssp.xml import NAMESPACES
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.lock import locked
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run, run_earlier

SCENARIO = """
title = "a tone into a table"
stop = "1/30"
[rates]
fast = "3 kHz"
[components.tone]
fmu = "controllers.references.sine"
step = "fast"
offset = "1/6000"
latency = 2
parameters = { swing = 0.003, frequency_hz = 7 }
[components.tone.map]
swing = "amplitude"
slow_x = { name = "x_r", gain = -0.1, offset = 0.25, unit = "mm" }
[components.table]
fmu = "controllers.references.sine"
step = "1/1500"
parameters = { width = 4.0, frequency_hz = 1.0 }
map = { width = { name = "amplitude", gain = 0.1, offset = 0.05, unit = "mm" } }
[record]
"tone.x_r" = "fast"
"table.x_r" = [true, "1/300"]
[metrics]
peak = { kind = "peak", of = "tone.x_r", unit = "mm" }
[expect]
"peak.peak" = { below = 4, unit = "mm" }
"""


def composed(file: Path) -> Composition:
    return compose(load_scenario(file), run_earlier)


@pytest.fixture(scope="module")
def tone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("tone") / "tone.toml"
    file.write_text(SCENARIO)
    return file


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_a_package_is_valid_and_the_same_bytes_each_time(
    tone: Path, tmp_path: Path, version: str
) -> None:
    one = export_ssp(composed(tone), tmp_path / "one.ssp", version)
    two = export_ssp(composed(tone), tmp_path / "two.ssp", version)
    assert one.read_bytes() == two.read_bytes()
    assert schema_faults(one) == []
    with ZipFile(one) as archive:
        root = etree.fromstring(archive.read("SystemStructure.ssd"))
    assert root.get("version") == version


def test_a_scenario_comes_back_with_its_lock_and_its_bytes(
    tone: Path, tmp_path: Path
) -> None:
    before = composed(tone)
    package = export_ssp(before, tmp_path / "tone.ssp")
    after = compose(load_package(package), run_earlier)
    was, now = locked(before), locked(after)
    assert was.pop("lock")["digests"] == now.pop("lock")["digests"]
    assert was == now
    file = write_beside(package, tmp_path / "beside")
    assert members(composed(file)) == members(before)


def test_a_package_runs_to_the_same_rows(tone: Path, tmp_path: Path) -> None:
    package = export_ssp(composed(tone), tmp_path / "tone.ssp")
    first = run(tone, tmp_path / "one", report=False)
    second = run(load_package(package), tmp_path / "two", report=False)
    for name in ("tone.x_r", "table.x_r"):
        assert first[name].values.tolist() == second[name].values.tolist()


def test_what_a_map_scales_is_a_mapping_that_names_the_number(
    tone: Path, tmp_path: Path
) -> None:
    found = members(composed(tone))
    values = etree.fromstring(found["resources/table.ssv"])
    (width,) = values.iterfind("*/ssv:Parameter[@name='width']/ssv:Real", NAMESPACES)
    assert (width.get("value"), width.get("unit")) == ("4.0", "mm")
    mapping = etree.fromstring(found["resources/table.ssm"])
    (entry,) = mapping.iterfind("ssm:MappingEntry[@source='width']", NAMESPACES)
    assert (entry.get("target"), entry[0].tag.rpartition("}")[2]) == (
        "amplitude",
        "LinearTransformation",
    )
    assert entry.get("suppressUnitConversion") == "true"
    assert dict(entry[0].attrib) == {"factor": "0.1", "offset": "0.05"}
    assert "resources/tone.ssm" in found  # renamed only


def test_an_edited_package_is_not_overruled_by_our_annotation(
    tone: Path, tmp_path: Path
) -> None:
    found = members(composed(tone))
    for old, new in ((b'value="4.0"', b'value="8.0"'), (b'value="7.0"', b'value="9"')):
        for name in found:
            if name.endswith(".ssv"):
                found[name] = found[name].replace(old, new)
    for name, content in found.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    spec = load_package(tmp_path).spec
    assert spec.components["table"].parameters["width"] == 8
    assert spec.components["tone"].parameters["frequency_hz"] == 9


def test_fmi_3_is_refused_where_ssp_has_no_words_for_it(tone: Path) -> None:
    three = compose(load_scenario(tone, ["fmi=3"]), run_earlier)
    with pytest.raises(ScenarioError, match=r"SSP 1\.0 knows FMI 2 only"):
        members(three, "1.0")
    assert b"ssc:Float64" in members(three, "2.0")["SystemStructure.ssd"]
    with pytest.raises(ScenarioError, match=r"there are 1\.0 and 2\.0"):
        members(three, "1.1")


def test_the_command_line_writes_checks_and_imports(tone: Path, tmp_path: Path) -> None:
    package, runner = tmp_path / "tone.ssp", CliRunner()
    done = runner.invoke(app, ["export", str(tone), "-o", str(package)])
    assert done.exit_code == 0, done.output
    done = runner.invoke(app, ["check", str(package)])
    assert done.exit_code == 0, done.output
    assert "2 components" in done.output
    asked = ["import", str(package), "-o", str(tmp_path / "new")]
    assert runner.invoke(app, asked).exit_code == 0
    again = runner.invoke(app, asked)
    assert again.exit_code == 2
    assert "is there already" in again.output
    done = runner.invoke(app, ["export", str(tone), "-o", str(package), "--at", "1"])
    assert done.exit_code == 2
