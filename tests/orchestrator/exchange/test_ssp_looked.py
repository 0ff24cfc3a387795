"""Mappings of single values, on connections and in SSM, in packages of own making."""

from pathlib import Path

import pytest
from packages import (
    binding,
    component,
    connections,
    experiment,
    mapping,
    package,
    parameter_set,
    ssd,
)
from small_packages import STEP, elements, values
from stub import Stub, stub
from wholes import composed

from orchestrator.errors import FeedDriveError, ScenarioError, SimulationError
from orchestrator.exchange.ssp.beside import write_beside
from orchestrator.exchange.ssp.load import load_package, read_package, schema_faults
from orchestrator.exchange.ssp.write import export_ssp
from orchestrator.scenario.compose import compose
from orchestrator.session import run_earlier

KINDS = ("Boolean", "Integer", "Enumeration")
START = {"Boolean": "0", "Integer": "0", "Enumeration": "1"}
ENTRIES = {
    "Boolean": {"true": "false", "false": "true"},
    "Integer": {"-2": "7", "3": "-1", "0": "0"},
    "Enumeration": {"off": "on", "on": "off"},  # items 1 and 4
}


def looked(kind: str, entries: dict[str, str]) -> str:
    lines = (f'<ssc:MapEntry source="{a}" target="{b}"/>' for a, b in entries.items())
    name = f"ssc:{kind}MappingTransformation"
    return f"<{name}>{''.join(lines)}</{name}>"


def typed(**kinds: str) -> str:
    """Return connectors written ``name="input Integer"``."""
    lines = []
    for name, text in kinds.items():
        kind, type_ = text.split()
        about = ' name="Mode"' if type_ == "Enumeration" else ""
        lines.append(
            f'<ssd:Connector name="{name}" kind="{kind}"><ssc:{type_}{about}/>'
            f"</ssd:Connector>"
        )
    return f"<ssd:Connectors>{''.join(lines)}</ssd:Connectors>"


@pytest.fixture(scope="module")
def one(compiled: Path) -> dict[str, Path]:
    """FMUs of one input, parameter and output of a type: y = u + k (switches: or)."""
    made = {}
    for kind in KINDS:
        of = {
            name: Stub(cause, kind, start=START[kind])
            for name, cause in (("u", "input"), ("k", "parameter"), ("y", "output"))
        }
        if kind == "Enumeration":
            del of["k"]
        made[kind] = stub(compiled, compiled.parent / f"{kind}.fmu", of)
    return made


def of_signal(
    folder: Path, fmu: Path, kind: str, word: str, entries: dict[str, str]
) -> Path:
    """A component whose output is a word's value, looked up on the way to another."""
    name = "u" if kind == "Enumeration" else "k"
    given = binding(parameter_set(f'{name} {kind} value="{word}"'))
    of_name = {name: f"{'input' if name == 'u' else 'parameter'} {kind}"}
    first = component("a", "r.fmu", typed(**of_name, y=f"output {kind}") + given)
    ends = typed(u=f"input {kind}", y=f"output {kind}")
    second = component("b", "r.fmu", ends)
    wire = connections(f"a.y -> b.u||{looked(kind, entries)}")
    items = '<ssc:Item name="off" value="1"/><ssc:Item name="on" value="4"/>'
    modes = (
        f'<ssd:Enumerations><ssc:Enumeration name="Mode">{items}</ssc:Enumeration>'
        f"</ssd:Enumerations>"
    )
    text = ssd(elements(first, second) + wire, modes + experiment(annotations=STEP))
    return package(folder / "a.ssp", {"SystemStructure.ssd": text, "r.fmu": fmu})


EXPECTED = [
    ("Boolean", "true", 0.0),
    ("Boolean", "false", 1.0),
    ("Integer", "-2", 7.0),
    ("Integer", "3", -1.0),
    ("Enumeration", "off", 4.0),
    ("Enumeration", "on", 1.0),
]


@pytest.mark.parametrize(("kind", "word", "expected"), EXPECTED)
def test_a_signal_is_looked_up_on_its_connection(
    one: dict[str, Path], tmp_path: Path, kind: str, word: str, expected: float
) -> None:
    file = of_signal(tmp_path, one[kind], kind, word, ENTRIES[kind])
    assert schema_faults(file) == []
    assert values(file, tmp_path / "run", "b.y") == [expected]


@pytest.mark.parametrize("kind", KINDS)
def test_a_mapping_comes_back_as_it_was(
    one: dict[str, Path], tmp_path: Path, kind: str
) -> None:
    word = next(iter(ENTRIES[kind]))
    file = of_signal(tmp_path, one[kind], kind, word, ENTRIES[kind])
    scenario = write_beside(file, tmp_path / "new")
    assert "[components.b.map.u.table]" in scenario.read_text()
    first = export_ssp(composed(scenario), tmp_path / "1" / "plant.ssp", "2.0")
    assert schema_faults(first) == []
    back = compose(load_package(first), run_earlier)
    again = export_ssp(back, tmp_path / "2" / "plant.ssp", "2.0")
    assert again.read_bytes() == first.read_bytes()
    assert read_package(first).components["b"]["map"]["u"]["table"]


def test_what_a_mapping_does_not_list_ends_the_run(
    one: dict[str, Path], tmp_path: Path
) -> None:
    file = of_signal(tmp_path, one["Integer"], "Integer", "5", ENTRIES["Integer"])
    with pytest.raises(SimulationError) as refused:
        values(file, tmp_path / "run", "b.y")
    told = str(refused.value)
    assert "a.y -> b.u at t = 0 s: 5 is none of -2, 3, 0, which its table" in told


def test_parameters_are_looked_up_when_they_are_read(
    one: dict[str, Path], tmp_path: Path
) -> None:
    """In SSM: switches, integers, and items into the names of an input's start."""
    parts, members = [], {}
    for kind in KINDS:
        name = "u" if kind == "Enumeration" else "k"
        word = next(iter(ENTRIES[kind]))
        maps = mapping(f"theirs {name}|{looked(kind, ENTRIES[kind])}")
        given = binding(parameter_set(f'theirs {kind} value="{word}"'), maps=maps)
        ends = typed(y=f"output {kind}")
        parts.append(component(kind.lower(), f"{kind}.fmu", ends + given))
        members[f"{kind}.fmu"] = one[kind]
    items = '<ssc:Item name="off" value="1"/><ssc:Item name="on" value="4"/>'
    modes = (
        f'<ssd:Enumerations><ssc:Enumeration name="Mode">{items}</ssc:Enumeration>'
        f"</ssd:Enumerations>"
    )
    text = ssd(elements(*parts), modes + experiment(annotations=STEP))
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, **members})
    assert schema_faults(file) == []
    names = ("boolean.y", "integer.y", "enumeration.y")
    assert values(file, tmp_path / "run", *names) == [0.0, 7.0, 4.0]


@pytest.mark.parametrize(
    ("kind", "of", "entries", "told"),
    [
        ("Integer", "Boolean", {"1": "2"}, "maps Integer values, and y is a Boolean"),
        ("Enumeration", "Enumeration", {"of": "on"}, "'of' is no item of y; it has"),
        ("Boolean", "Boolean", {"true": "no"}, "'no' is no Boolean"),
        ("Integer", "Integer", {"1": "9999999999"}, "and takes -2147483648 to"),
    ],
)
def test_a_mapping_that_fits_no_variable_is_refused(
    one: dict[str, Path],
    tmp_path: Path,
    kind: str,
    of: str,
    entries: dict[str, str],
    told: str,
) -> None:
    word = next(iter(ENTRIES[of]))
    file = of_signal(tmp_path, one[of], of, word, {})
    empty, full = looked(of, {}), looked(kind, entries)
    file = rewritten(file, empty, full)
    with pytest.raises(ScenarioError) as refused:
        load_package(file)
    assert told in str(refused.value)


def rewritten(file: Path, old: str, new: str) -> Path:
    import zipfile

    with zipfile.ZipFile(file) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    text = members["SystemStructure.ssd"].decode().replace(old, new)
    return package(file, {**members, "SystemStructure.ssd": text})


def test_values_that_an_ssm_does_not_list_are_refused(
    one: dict[str, Path], tmp_path: Path
) -> None:
    parts = []
    for name, kind, word in (("a", "Integer", "5"), ("b", "Boolean", "true")):
        maps = mapping(f"theirs k|{looked('Integer', ENTRIES['Integer'])}")
        given = binding(parameter_set(f'theirs {kind} value="{word}"'), maps=maps)
        parts.append(component(name, f"{kind}.fmu", given))
    text = ssd(elements(*parts), experiment(annotations=STEP))
    members = {f"{kind}.fmu": one[kind] for kind in ("Integer", "Boolean")}
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, **members})
    with pytest.raises(FeedDriveError) as refused:
        load_package(file)
    assert "theirs is 5, and its mapping lists -2, 3, 0 only" in str(refused.value)
    assert "theirs is Boolean, and its mapping is of Integer" in str(refused.value)
