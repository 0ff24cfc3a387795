"""The wiring picture says every connection, once, and what is not connected."""

import re
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from xml.etree import ElementTree

import pytest
from systems import part, system

from orchestrator.master.simulate import plan
from orchestrator.pictures import layered
from orchestrator.pictures.bundles import bundles, wires
from orchestrator.pictures.wiring import wiring_picture
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.system import Mapped

ELKJS_0_12_1 = "b1032b7cfd2a57c54c6f0e8369d7665e19a579954f7cd20a6dae28f1912ea0d7"


def texts(picture: str) -> list[str]:
    """Return what is written in a picture, without what is told of it."""
    root = ElementTree.fromstring(picture)
    found = root.iter("{http://www.w3.org/2000/svg}text")
    return ["".join(t.itertext()) for t in found]


def test_the_library_is_the_file_that_was_published() -> None:
    assert sha256(layered.LIBRARY.read_bytes()).hexdigest() == ELKJS_0_12_1


def test_gain_unit_age_and_a_free_input_are_written() -> None:
    slow = replace(part("slow", "counter", "1/1000"), map={"u": Mapped("u", -2.0)})
    parts = [part("fast", "counter", "1/4000", latency=1), slow]
    timetable = plan(system("1/10", parts, {"slow.u": "fast.k"}))
    (wire,) = wires(timetable)
    assert (wire.gain, wire.conversion) == (-2.0, "× -2")
    told = " | ".join(texts(wiring_picture(timetable)))
    assert "k → u in × -2" not in told
    assert "k → u × -2" in told
    assert "age 250 us" in told
    assert "latency 1 sample" in told
    assert re.search(r"○ u = 0", told)


def test_boxes_do_not_overlap_and_every_bundle_has_an_arrow() -> None:
    scenario = load_scenario("gantry/circle_200")
    timetable = plan(compose(scenario, None).system)
    picture = wiring_picture(timetable)
    assert picture.count("<polyline") == len(bundles(timetable)) == 9
    frames = [
        tuple(map(float, found))
        for found in re.findall(
            r'<rect x="(\S+)" y="(\S+)" width="(\S+)" height="(\S+)" '
            r'fill="var\(--box\)"',
            picture,
        )
    ]
    assert len(frames) == 6
    for i, (x, y, w, h) in enumerate(frames):
        for X, Y, W, H in frames[:i]:
            assert x + w <= X or x >= X + W or y + h <= Y or y >= Y + H


def test_a_name_is_shown_as_text(tmp_path: Path) -> None:
    parts = [part("<script>alert(1)</script>", "counter", "1/1000")]
    picture = wiring_picture(plan(system("1/10", parts)))
    assert "<script" not in picture
    ElementTree.fromstring(picture)


def test_what_cannot_be_laid_out_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FEEDDRIVE_CACHE", str(tmp_path))
    edge = {"id": "e", "sources": ["nowhere"], "targets": ["nowhere"]}
    with pytest.raises(RuntimeError, match="nowhere"):
        layered.laid_out({"id": "root", "children": [], "edges": [edge]})
    assert list(tmp_path.rglob("*.json")) == []


def test_a_layout_comes_from_the_cache_the_second_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FEEDDRIVE_CACHE", str(tmp_path))
    graph = {"id": "root", "children": [{"id": "a", "width": 10, "height": 10}]}
    first = layered.laid_out(graph)
    monkeypatch.setattr(layered, "_asked", lambda text: pytest.fail("laid out again"))
    assert layered.laid_out(graph) == first
