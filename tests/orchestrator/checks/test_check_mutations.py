"""Damaged archives, descriptions and scenarios end in a sentence, nothing else.

Five hundred mutants with --every-form, a third of them (each kind several times)
without: none may leave a traceback, a hang, or a file anywhere but
in its own folder, which is gone afterwards.
"""

import io
import signal
import tempfile
import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from effort import EFFORT
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from lxml import etree
from typer.testing import CliRunner

from fmus.build import build
from orchestrator.checks import check_fmu
from orchestrator.cli import app
from orchestrator.errors import FmuError
from orchestrator.fmu.archive import unpacked

LONGEST = 20  # s of computing; what takes longer hangs


def mutants(count: int) -> settings:
    """Return the settings of a test with so many examples, always the same."""
    return settings(
        max_examples=EFFORT.sample(count, count // 3),
        deadline=None,
        database=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )


JUNK = st.sampled_from(
    ["", "x", "1", "0", "-1", "1e999", "NaN", "99999999999999", "../../x"]
)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder for everything; temporary files go into its ``tmp``."""
    folder = tmp_path_factory.mktemp("mutants")
    (folder / "tmp").mkdir()
    usual, tempfile.tempdir = tempfile.tempdir, str(folder / "tmp")
    yield folder
    tempfile.tempdir = usual


@contextmanager
def no_hang_and_nothing_left(place: Path, *known: str) -> Iterator[None]:
    def late(_signal: int, _frame: Any) -> None:
        raise AssertionError(f"no end within {LONGEST} s")

    watched = hasattr(signal, "SIGPROF")
    if watched:
        signal.signal(signal.SIGPROF, late)
        signal.setitimer(signal.ITIMER_PROF, LONGEST)
    try:
        yield
    finally:
        if watched:
            signal.setitimer(signal.ITIMER_PROF, 0)
    assert {f.name for f in place.iterdir()} <= {"tmp", *known}
    assert not list((place / "tmp").iterdir())


def survives(fmu: Path) -> None:
    """Read, unpack and check an FMU; refusals are ours, or there is a report."""
    with suppress(FmuError), unpacked(fmu) as folder:
        inside = folder.resolve()
        assert all(f.resolve().is_relative_to(inside) for f in folder.rglob("*"))
    assert check_fmu(fmu, dynamic=False).to_junit()
    ends_in_a_sentence("info", str(fmu), "--json")


@mutants(100)
@given(data=st.data(), fmi=st.sampled_from([2, 3]))
def test_damaged_archives(place: Path, data: st.DataObject, fmi: Any) -> None:
    whole = bytearray(build("plants.gantry.x_axis", fmi=fmi).read_bytes())
    kind = data.draw(st.sampled_from(["cut", "overwrite", "remove", "double"]))
    # the directory at the end decides most, so aim there as often as elsewhere
    end = data.draw(st.booleans())
    first = len(whole) - 3000 if end else 0
    at = data.draw(st.integers(first, len(whole) - 1))
    length = data.draw(st.integers(1, 200))
    match kind:
        case "cut":
            del whole[at:]
        case "overwrite":
            noise = data.draw(st.binary(min_size=length, max_size=length))
            whole[at : at + length] = noise
        case "remove":
            del whole[at : at + length]
        case "double":
            whole[at:at] = whole[at : at + length]
    fmu = place / "mutant.fmu"
    fmu.write_bytes(whole)
    with no_hang_and_nothing_left(place, "mutant.fmu"):
        survives(fmu)


NAMES = st.sampled_from(
    [
        "../x",
        "/tmp/feeddrive-escaped",
        "C:\\x",
        "a/../../x",
        "resources/" + "n" * 300,
        "modelDescription.xml",
        "modelDescription.xml/x",
        "binaries",
        "con",
        "é",
        ".",
        "",
    ]
)


@mutants(50)
@given(names=st.lists(NAMES, min_size=1, max_size=4), link=st.booleans())
def test_hostile_members(place: Path, names: list[str], link: bool) -> None:
    content = build("plants.gantry.x_axis").read_bytes()
    memory = io.BytesIO(content)
    with (
        zipfile.ZipFile(memory, "a") as archive,
        warnings.catch_warnings(action="ignore"),  # of names that are there twice
    ):
        for name in names:
            info = zipfile.ZipInfo("placeholder")
            info.filename = name
            info.external_attr = (0o120777 if link else 0o644) << 16
            archive.writestr(info, "/etc/passwd")
    fmu = place / "mutant.fmu"
    fmu.write_bytes(memory.getvalue())
    with no_hang_and_nothing_left(place, "mutant.fmu"):
        survives(fmu)
    assert not Path("/tmp/feeddrive-escaped").exists()


def described(fmu: Path, text: bytes, target: Path) -> Path:
    """Write an FMU again with another model description."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w") as new:
        for member in old.infolist():
            other = member.filename == "modelDescription.xml"
            new.writestr(member.filename, text if other else old.read(member))
    return target


ALONE = """
stop = "1/200"
[components.it]
fmu = "mutant.fmu"
step = "1/2000"
[record]
"it.*" = true
"""


@mutants(110)
@given(data=st.data(), fmi=st.sampled_from([2, 3]), module=st.sampled_from([0, 1]))
def test_mutated_descriptions(
    place: Path, data: st.DataObject, fmi: Any, module: int
) -> None:
    model = ("plants.gantry.x_axis", "controllers.xy_table.speed_pi")[module]
    original = build(model, fmi=fmi)
    with zipfile.ZipFile(original) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
    for _ in range(data.draw(st.integers(1, 3))):
        elements = [e for e in root.iter() if isinstance(e.tag, str)]
        element = elements[data.draw(st.integers(0, len(elements) - 1))]
        kind = data.draw(st.sampled_from(["value", "drop", "remove", "double", "tag"]))
        names = sorted(element.attrib)
        parent = element.getparent()
        if kind in ("value", "drop") and names:
            name = data.draw(st.sampled_from(names))
            if kind == "value":
                element.set(name, data.draw(JUNK))
            else:
                del element.attrib[name]
        elif kind == "remove" and parent is not None:
            parent.remove(element)
        elif kind == "double" and parent is not None:
            parent.append(deepcopy(element))
        elif kind == "tag" and parent is not None:
            element.tag = data.draw(st.sampled_from(["Real", "Clock", "String", "x"]))
    text = etree.tostring(root, encoding="UTF-8", xml_declaration=True)
    fmu = described(original, text, place / "mutant.fmu")
    scenario = place / "mutant.toml"
    scenario.write_text(ALONE)
    with no_hang_and_nothing_left(place, "mutant.fmu", "mutant.toml", "run"):
        assert check_fmu(fmu, dynamic=False).to_junit()
        ends_in_a_sentence(
            "run", str(scenario), "-o", str(place / "run"), "--json", "--overwrite"
        )


def ends_in_a_sentence(*arguments: str) -> None:
    """Run the command; a traceback or a fault of our own would be no end."""
    result = CliRunner().invoke(app, list(arguments))
    assert result.exit_code in (0, 1, 2), result.output
    assert isinstance(result.exception, SystemExit | None), result.exception
    assert "a fault in feeddrive" not in result.output, result.output
    told = any(word in result.output for word in ("error:", "expectation not met:"))
    assert result.exit_code == 0 or told


SCENARIO: dict[str, Any] = {
    "title": "a mutant",
    "stop": "1/100",
    "rates": {"control": "2 kHz"},
    "components": {
        "reference": {"fmu": "controllers.references.sine", "step": "control"},
        "controller": {
            "fmu": "controllers.xy_table.speed_pi",
            "step": "control",
            "latency": 1,
            "parameters": {"k_p": 0.005},
        },
        "plant": {
            "fmu": "plants.gantry.x_axis",
            "step": "1/2000",
            "start": {"state.x": 0.0},
        },
    },
    "connections": {
        "controller.v_ref": "reference.v_r",
        "controller.v_est": "plant.v",
        "plant.u": "controller.u",
    },
    "record": {"plant.v": "control", "reference.v_r": "control"},
    "metrics": {
        "tracking": {"kind": "error", "of": "plant.v", "against": "reference.v_r"}
    },
    "expect": {"tracking.peak": {"below": 1.0, "unit": "m/s"}},
}
VALUES = st.sampled_from(
    [
        *("", "x", "control", "plant", "plant.v", "plant.*", "*", "../x.fmu", "0 kHz"),
        *("1/3", "-1/2", "1/0", "rms", "sampled", "plants._modes", "os", "é\t"),
        *(0, 1, -1, 2**70, 0.0, -0.5, float("nan"), float("inf"), True, False),
        *([], [1.0], ["plant.v"], {}, {"kind": "peak", "of": "plant.v"}, [[], {}]),
    ]
)


def tables(node: dict[str, Any]) -> list[dict[str, Any]]:
    """Return a table and all tables in it."""
    inner = [t for v in node.values() if isinstance(v, dict) for t in tables(v)]
    return [node, *inner]


@mutants(180)
@given(data=st.data())
def test_mutated_scenarios(place: Path, data: st.DataObject) -> None:
    raw = deepcopy(SCENARIO)
    for _ in range(data.draw(st.integers(1, 3))):
        found = tables(raw)
        table = found[data.draw(st.integers(0, len(found) - 1))]
        kind = data.draw(st.sampled_from(["value", "value", "remove", "add", "rename"]))
        if kind == "add" or not table:
            table[
                data.draw(st.sampled_from(["x", "plant.u", "fmu", "base", "a b"]))
            ] = data.draw(VALUES)
            continue
        key = data.draw(st.sampled_from(sorted(table)))
        if kind == "value":
            table[key] = data.draw(VALUES)
        elif kind == "remove":
            del table[key]
        else:
            table[data.draw(st.sampled_from(["x", "plant.d", "step"]))] = table.pop(key)
    scenario = place / "mutant.toml"
    scenario.write_text(tomli_w.dumps(raw), encoding="utf-8")
    with no_hang_and_nothing_left(place, "mutant.fmu", "mutant.toml", "run"):
        ends_in_a_sentence(
            "run", str(scenario), "-o", str(place / "run"), "--json", "--overwrite"
        )


@mutants(60)
@given(data=st.data())
def test_garbled_scenarios(place: Path, data: st.DataObject) -> None:
    text = bytearray(tomli_w.dumps(SCENARIO).encode())
    at = data.draw(st.integers(0, len(text) - 1))
    text[at : at + data.draw(st.integers(0, 9))] = data.draw(st.binary(max_size=9))
    scenario = place / "mutant.toml"
    scenario.write_bytes(text)
    with no_hang_and_nothing_left(place, "mutant.fmu", "mutant.toml", "run"):
        ends_in_a_sentence(
            "run", str(scenario), "-o", str(place / "run"), "--json", "--overwrite"
        )
