"""Signal dictionaries, in packages of own making: one source, any number of readers."""

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

from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.load import load_package, read_package, schema_faults

SSB = "http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"


def signals(**units: str) -> str:
    """Return a dictionary of Real signals with their units."""
    lines = []
    for name, of in units.items():
        about = f' unit="{of}"' if of else ""
        lines.append(
            f'<ssb:DictionaryEntry name="{name}"><ssc:Real{about}/>'
            f"</ssb:DictionaryEntry>"
        )
    head = f'xmlns:ssb="{SSB}" xmlns:ssc="{SSC}" version="1.0"'
    return f"<ssb:SignalDictionary {head}>{''.join(lines)}</ssb:SignalDictionary>"


def dictionaries(inside: str = "", source: str = "") -> str:
    about = f' source="{source}"' if source else ""
    return (
        f'<ssd:SignalDictionaries><ssd:SignalDictionary name="bus"{about}>{inside}'
        f"</ssd:SignalDictionary></ssd:SignalDictionaries>"
    )


def reference(name: str, **kinds: str) -> str:
    return (
        f'<ssd:SignalDictionaryReference name="{name}" dictionary="bus">'
        f"{connectors(**kinds)}</ssd:SignalDictionaryReference>"
    )


def nested(plain: Path, folder: Path, of_bus: str, **members: str) -> Path:
    """A source in one system feeds a signal, which two readers take, one of them in a
    system inside, wired with and against the flow."""
    set_k = binding(parameter_set('k Real value="3"'))
    inner = elements(reference("here", x="inout"), component("c", "r.fmu", KINDS))
    inner += connections("c.u -> here.x")
    parts = elements(
        reference("there", x="inout"),
        component("a", "r.fmu", KINDS + set_k),
        component("b", "r.fmu", KINDS),
        f'<ssd:System name="inside">{inner}</ssd:System>',
    )
    wires = connections("a.y -> there.x", "there.x -> b.u")
    text = ssd(parts + wires + of_bus, experiment(annotations=STEP))
    files = {"SystemStructure.ssd": text, "r.fmu": plain, **members}
    return package(folder / "a.ssp", files)


@pytest.mark.parametrize("version", ["1.0", "2.0"])
@pytest.mark.parametrize("form", ["inside", "file"])
def test_what_feeds_a_signal_reaches_all_who_read_it(
    plain: Path, tmp_path: Path, form: str, version: str
) -> None:
    VERSION.append(version)
    try:
        if form == "inside":
            file = nested(plain, tmp_path, dictionaries(signals(x="")))
        else:
            of_bus = dictionaries(source="bus.ssb")
            file = nested(plain, tmp_path, of_bus, **{"bus.ssb": signals(x="")})
    finally:
        VERSION.pop()
    assert schema_faults(file) == []
    assert load_package(file).spec.connections == {"b.u": "a.y", "c.u": "a.y"}
    assert values(file, tmp_path / "run", "b.y", "c.y") == [3.0, 3.0]


def test_units_are_those_of_the_fmus_whatever_the_signal_has(
    compiled: Path, tmp_path: Path
) -> None:
    of = {"u": Stub("input", unit="mm"), "k": Stub("parameter", unit="m")}
    metres = stub(compiled, tmp_path / "m.fmu", {**of, "y": Stub("output", unit="m")})
    set_k = binding(parameter_set('k Real value="0.25"'))
    ends = connectors(u="input", k="parameter", y="output")
    parts = elements(
        reference("there", x="inout"),
        component("a", "m.fmu", ends + set_k),
        component("b", "m.fmu", ends),
    )
    wires = connections("a.y -> there.x", "there.x -> b.u")
    of_bus = dictionaries(signals(x="mm"))
    units = unit("mm", 'm="1" factor="0.001"')
    text = ssd(parts + wires + of_bus, units + experiment(annotations=STEP))
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "m.fmu": metres})
    assert values(file, tmp_path / "run", "b.y") == [250.0]


def test_signals_that_cannot_be_are_named(plain: Path, tmp_path: Path) -> None:
    parts = elements(
        reference("there", x="inout", gone="inout"),
        reference("again", x="inout", z="inout"),
        component("a", "r.fmu", KINDS),
        component("b", "r.fmu", KINDS),
        component("c", "r.fmu", connectors(u="inout")),
    )
    wires = connections(
        "a.y -> there.x", "b.y -> again.x", "there.x -> again.x", "c.u -> a.u"
    )
    text = ssd(
        parts + wires + dictionaries(signals(x="", z="")),
        experiment(annotations=STEP),
    )
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "r.fmu": plain})
    with pytest.raises(ScenarioError) as refused:
        load_package(file)
    for told in (
        "there: bus has no signal 'gone'; it has x, z",
        "b.y -> again.x: feeds what root: a.y -> there.x feeds already",
        "there.x -> again.x: both ends could feed or be fed",
        "connectors of kind inout are those of references to signal dictionaries",
    ):
        assert told in str(refused.value)
    missing = nested(plain, tmp_path / "missing", dictionaries(source="gone.ssb"))
    with pytest.raises(ScenarioError) as refused:
        load_package(missing)
    assert "root: signal dictionary bus: source 'gone.ssb': there is no" in str(
        refused.value
    )


def test_a_signal_that_nothing_feeds_is_noted(plain: Path, tmp_path: Path) -> None:
    parts = elements(reference("there", x="inout"), component("b", "r.fmu", KINDS))
    text = ssd(
        parts + connections("there.x -> b.u") + dictionaries(signals(x="")),
        experiment(annotations=STEP),
    )
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "r.fmu": plain})
    (note,) = read_package(file).notes
    assert "signal dictionary bus: nothing feeds its signal 'x'" in note
