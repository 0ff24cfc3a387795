"""Each kind of fault is found by the item that looks for it."""

import re
import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import pytest
from lxml import etree
from outcomes import outcomes
from rewritten import Edit, rewritten

from fmus.build import build
from fmus.compile import host_platform
from orchestrator.checks import check_fmu
from orchestrator.checks.elf import needed_libraries


def edited(
    folder: Path, edit: Edit | None = None, *, fmi: Any = 2, **options: Any
) -> Path:
    """Write our linear motor again."""
    fmu = build("plants.gantry.x_axis", fmi=fmi)
    return rewritten(fmu, folder, edit, **options)


def found(fmu: Path, number: int, part: str = "static") -> str:
    """Return the texts of an item's findings."""
    report = check_fmu(fmu, only=[number], dynamic=part == "dynamic")
    (outcome,) = [o for o in report.outcomes if o.item.part == part]
    return "; ".join(f.text for f in outcome.findings)


def variable(root: Any, name: str) -> Any:
    return next(v for v in root.iter("ScalarVariable") if v.get("name") == name)


def set_real(name: str, **attributes: str) -> Edit:
    def edit(root: Any) -> None:
        for key, value in attributes.items():
            variable(root, name).find("Real").set(key, value)

    return edit


def rename(root: Any) -> None:
    variable(root, "d").set("name", "u")


def set_output_start(root: Any) -> None:
    variable(root, "x").find("Real").set("start", "0")


def constant_input(root: Any) -> None:
    variable(root, "u").set("variability", "constant")


def forget_output(root: Any) -> None:
    outputs = root.find("ModelStructure/Outputs")
    outputs.remove(outputs[0])


def wrong_order(root: Any) -> None:
    outputs = root.find("ModelStructure/Outputs")
    outputs.append(outputs[0])


def wrong_factor(root: Any) -> None:
    unit = next(u for u in root.iter("Unit") if u.get("name") == "m")
    unit.find("BaseUnit").set("factor", "0.001")


def hyphen(root: Any) -> None:
    for interface in ("ModelExchange", "CoSimulation"):
        root.find(interface).set("modelIdentifier", "linear-motor")


def swapped_elements(root: Any) -> None:
    root.append(root.find("UnitDefinitions"))


def no_dependencies(root: Any) -> None:
    for unknown in root.find("ModelStructure/Outputs"):
        unknown.attrib.pop("dependencies")
        unknown.attrib.pop("dependenciesKind", None)


def other_source(root: Any) -> None:
    for file in root.iter("File"):
        file.set("name", "nothing.c")


def in_unit(name: str, quantity: str = "", **exponents: str) -> Edit:
    """Give the input another unit, and a quantity."""

    def edit(root: Any) -> None:
        unit = etree.SubElement(root.find("UnitDefinitions"), "Unit", name=name)
        etree.SubElement(unit, "BaseUnit", exponents)
        real = variable(root, "u").find("Real")
        for told in ("quantity", "declaredType", "displayUnit"):
            real.attrib.pop(told, None)
        real.set("unit", name)
        if quantity:
            real.set("quantity", quantity)

    return edit


@pytest.mark.parametrize(
    "edit",
    [
        in_unit("N.m", "Torque", kg="1", m="2", s="-2"),
        in_unit("rad/s", s="-1", rad="1"),
        in_unit("Hz", s="-1"),
    ],
)
def test_units_that_leave_nothing_open_pass(tmp_path: Path, edit: Edit) -> None:
    assert found(edited(tmp_path, edit), 7) == ""


@pytest.mark.parametrize(
    ("number", "edit", "expected"),
    [
        (2, swapped_elements, "UnitDefinitions"),
        (2, lambda r: r.set("generationDateAndTime", "yesterday"), "no UTC time"),
        (3, rename, '"u" .* is not unique'),
        (2, constant_input, 'causality="input" and variability="constant"'),
        (4, set_output_start, 'has initial="calculated" but provides a start value'),
        (5, forget_output, "must have exactly one entry"),
        (5, wrong_order, "Outputs is not in ascending order"),
        (6, no_dependencies, "outputs without dependencies: x, v"),
        (7, set_real("u", unit="furlong"), "furlong"),
        (7, wrong_factor, "'m' is defined as 0.001 m1, but usually means 1 m1"),
        (7, in_unit("N.m", kg="1", m="2", s="-2"), r"an energy, .*: u \(N.m\)$"),
        (7, in_unit("rad/s", s="-1"), r"angular velocity, says no quantity: u"),
        (8, set_real("m_x", start="-1"), "start = -1 is not in its bounds"),
        (8, set_real("m_x", min="5", max="4"), "min = 5 is more than max = 4"),
        (8, set_real("u", nominal="0"), "nominal = 0"),
        (10, hyphen, "is no C identifier"),
        (30, lambda r: r[1].set("needsExecutionTool", "true"), "externalDependencies"),
        (31, lambda r: r.attrib.pop("author"), "has no author"),
        (34, other_source, "sources/nothing.c is listed, but is not there"),
    ],
)
def test_a_faulty_description_is_found(
    tmp_path: Path, number: int, edit: Edit, expected: str
) -> None:
    assert re.search(expected, found(edited(tmp_path, edit), number))


def test_a_description_that_lies_below_the_root_is_found(tmp_path: Path) -> None:
    fmu = edited(tmp_path, inside="LinearMotor/")
    assert "it lies at LinearMotor/modelDescription.xml" in found(fmu, 1)


def test_a_folder_in_extra_wants_a_domain(tmp_path: Path) -> None:
    fmu = edited(tmp_path, more={"extra/mine/x.txt": "x"})
    assert "extra/mine is no reverse domain name" in found(fmu, 33)


def test_a_layered_standard_wants_name_and_version(tmp_path: Path) -> None:
    manifest = {
        "extra/org.example/fmi-ls-manifest.xml": "<fmiLayeredStandardManifest/>"
    }
    assert "has no fmi-ls-version" in found(edited(tmp_path, more=manifest), 33)


def test_a_terminal_of_nothing_is_found(tmp_path: Path) -> None:
    member = '<TerminalMemberVariable variableName="nothing" variableKind="signal"/>'
    text = (
        '<fmiTerminalsAndIcons fmiVersion="3.0"><Terminals><Terminal name="t" '
        f'matchingRule="plug">{member}</Terminal></Terminals></fmiTerminalsAndIcons>'
    )
    more = {"terminalsAndIcons/terminalsAndIcons.xml": text}
    fmu = edited(tmp_path, fmi=3, more=more)
    assert "'nothing' is no variable" in found(fmu, 32)


def test_a_dimension_of_no_parameter_is_found(tmp_path: Path) -> None:
    def edit(root: Any) -> None:
        output = next(v for v in root.iter("Float64") if v.get("name") == "x")
        etree.SubElement(output, "Dimension", valueReference="0")

    assert "no structural parameter" in found(edited(tmp_path, edit, fmi=3), 36)


def test_a_clock_of_two_intervals_is_found(tmp_path: Path) -> None:
    def edit(root: Any) -> None:
        clock = root.find("ModelVariables/Clock")
        clock.set("intervalCounter", str(2 * int(clock.get("intervalCounter"))))

    fmu = build("controllers.xy_table.speed_pi", fmi=3)
    assert found(fmu, 36) == ""
    assert "but intervalDecimal =" in found(rewritten(fmu, tmp_path, edit), 36)


def test_start_values_that_the_binary_does_not_have_are_found(tmp_path: Path) -> None:
    fmu = edited(tmp_path, set_real("m_x", start="0.7"))
    assert "m_x: start = 0.7, the binary has 0.69" in found(fmu, 9, "dynamic")


def test_a_wrong_token_stops_every_trial(tmp_path: Path) -> None:
    fmu = edited(tmp_path, lambda r: r.set("guid", "{other}"))
    texts = found(fmu, 12, "dynamic")
    assert "no instance is made with the token of the description" in texts
    report = check_fmu(fmu, only=[16])
    (outcome,) = report.outcomes
    assert "the token (guid) is not that of this binary" in outcome.reason


def test_foreign_platforms_cannot_be_run_and_are_named(tmp_path: Path) -> None:
    target = tmp_path / "foreign.fmu"
    with (
        zipfile.ZipFile(build("plants.gantry.x_axis")) as old,
        zipfile.ZipFile(target, "w") as new,
    ):
        for name in old.namelist():
            if not name.startswith("binaries/"):
                new.writestr(name, old.read(name))
        new.writestr("binaries/amiga/LinearMotor.lib", b"x")
    report = check_fmu(target, only=[8, 11])
    tried = [o for o in report.outcomes if o.item.part == "dynamic"]
    assert {o.verdict for o in tried} == {"could not be run"}
    assert all("only: amiga" in o.reason for o in tried)
    assert not report.clean


@pytest.mark.skipif(
    shutil.which("readelf") is None or not host_platform().startswith("linux"),
    reason="compares with readelf",
)
def test_libraries_are_those_that_readelf_reads(tmp_path: Path) -> None:
    with zipfile.ZipFile(build("plants.gantry.x_axis")) as archive:
        name = next(n for n in archive.namelist() if n.startswith("binaries/"))
        data = archive.read(name)
    file = tmp_path / "library.so"
    file.write_bytes(data)
    text = subprocess.run(
        ["readelf", "-d", str(file)], capture_output=True, check=True, text=True
    ).stdout
    assert needed_libraries(data) == re.findall(r"\(NEEDED\).*\[(.*)\]", text)
    assert needed_libraries(data[:2000]) == []
    assert needed_libraries(b"MZ") == []


@pytest.mark.parametrize(("fmi", "loses"), [(2, 1), (3, 3)])
def test_values_that_do_not_survive_their_initialisation_are_found(
    fmi: int, loses: int, tmp_path: Path
) -> None:
    assert found(outcomes(fmi, tmp_path), 37, "dynamic") == ""
    said = found(outcomes(fmi, tmp_path, loses=loses), 37, "dynamic")
    assert "these are not what was set: k" in said
