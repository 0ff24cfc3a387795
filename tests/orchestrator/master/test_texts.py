"""Texts and bytes between FMUs, against what was said when."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TypeAlias

import pytest
from systems import system
from talking import talking

from fmus.trust import trust
from orchestrator.errors import FeedDriveError, WiringError
from orchestrator.instances.protocol import Instance
from orchestrator.master import simulate as master
from orchestrator.master.simulate import simulate
from orchestrator.system import Component, Fault, Isolation, Kind, System

STEP = Fraction(1, 1000)
Files: TypeAlias = dict[int, Path]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    """The FMUs, by the version of FMI."""
    folder = tmp_path_factory.mktemp("talking")
    found = {fmi: talking(fmi, folder / str(fmi)) for fmi in (2, 3)}
    for fmu in found.values():
        trust(fmu)
    return found


def chain(
    first: Path, second: Path, kind: Kind = "continuous", every: int = 1
) -> System:
    """``b`` hears what ``a`` says; it steps ``every`` so many steps of it."""
    here = Isolation(process=False)
    parts = [
        Component("a", first, STEP, kind=kind, start={"heard": "hé"}, isolation=here),
        Component("b", second, every * STEP, kind=kind, isolation=here),
    ]
    rows = {"b.k": str(every * STEP)}
    return system(str(4 * STEP), parts, {"b.heard": "a.text"}, rows)


def last(
    given: System, folder: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> object:
    """Return what a variable of ``b`` was at the end of a run."""
    opened: dict[str, Instance] = {}
    open_instance = master.open_instance

    def watched(component: str, *arguments: object) -> Instance:
        opened[component] = open_instance(component, *arguments)  # type: ignore[arg-type]
        return opened[component]

    found: list[object] = []

    def look(_result: object) -> None:
        b = opened["b"]
        found.extend(b.read([b.description[name]]))

    monkeypatch.setattr(master, "open_instance", watched)
    done = simulate(given, folder, recorded=look)
    assert done.timing.executor == "python"
    return found[0]


@pytest.mark.parametrize(("first", "second"), [(2, 2), (3, 3), (2, 3), (3, 2)])
def test_a_text_is_heard_as_a_number_would_be(
    first: int,
    second: int,
    files: Files,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Continuous: over its 4th step b hears what a said behind its 3rd."""
    given = chain(files[first], files[second])
    assert last(given, tmp_path, "text", monkeypatch) == "4:3:hé"


def test_a_sampled_reader_hears_what_is_said_at_the_same_instant(
    files: Files, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = chain(files[3], files[3], "sampled")
    assert last(given, tmp_path, "text", monkeypatch) == "5:5:hé"  # ticks at 0 to 4


def test_what_is_said_inside_a_step_waits_or_splits_it(
    files: Files, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = chain(files[3], files[3], every=2)
    assert last(given, tmp_path / "split", "text", monkeypatch) == "4:3:hé"
    held = replace(given.components["b"], split=False)
    whole = replace(given, components={**given.components, "b": held})
    assert last(whole, tmp_path / "whole", "text", monkeypatch) == "2:2:hé"


@pytest.mark.parametrize("process", [False, True])
def test_bytes_pass_as_they_are(
    process: bool, files: Files, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = chain(files[3], files[3])
    parts = {
        name: replace(
            component,
            start={"data": "00 ff 00"} if name == "a" else {},
            isolation=Isolation(process=process),
        )
        for name, component in given.components.items()
    }
    wires = {"b.data": "a.bytes"}
    given = replace(given, components=parts, connections=wires)
    found = last(given, tmp_path, "bytes", monkeypatch)
    assert found == b"\x00\xff\x00\x03\x04"


def test_texts_are_refused_where_they_cannot_be(files: Files, tmp_path: Path) -> None:
    given = chain(files[3], files[3])
    late = {
        **chain(files[3], files[3], "sampled").components,
    }
    late["a"] = replace(late["a"], latency=1)
    for changed, told in (
        (replace(given, connections={"b.heard": "a.k"}), "cannot drive a String"),
        (replace(given, connections={"b.heard": "a.bytes"}), "texts pass to texts"),
        (replace(given, record={"b.text": (STEP,)}), "texts are not recorded"),
        (
            replace(given, faults={"b.heard": (Fault("stuck"),)}),
            "no fault acts on texts",
        ),
        (replace(given, components=late), "which holds no texts back"),
    ):
        with pytest.raises(WiringError, match=told):
            simulate(changed, tmp_path / "run")
    for executor in ("kernel", "fused"):
        with pytest.raises(FeedDriveError, match=r"a.text -> b.heard carries a text"):
            simulate(given, tmp_path / executor, executor=executor)  # type: ignore[arg-type]
