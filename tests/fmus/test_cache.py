"""What is in the cache is used as it was written, or made anew."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from fmus.cache import BUILDING, LEFT, building, cache_folder, entry, publish

NOTE = "is damaged in the cache, so it is made anew"
KERNEL = "from orchestrator.native.library import library; library()"
DESIGN = "controllers.synthesis.ball_screw.pole_placement:design"


def cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def empty(file: Path) -> None:
    file.write_bytes(b"")


def altered(file: Path) -> None:
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)


def gone(file: Path) -> None:
    file.unlink()


def unnoted(file: Path) -> None:
    (file.parent / "sha256").unlink()


DAMAGES: list[Callable[[Path], None]] = [cut, empty, altered, gone, unnoted]


def made(place: Path) -> Path:
    with building(place.parent) as folder:
        (folder / "values").write_bytes(b"0.25, 0.5")
        publish([folder / "values"], place)
    return place / "values"


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_entry_is_none_and_may_be_made_anew(
    damage: Callable[[Path], None], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    place = tmp_path / "cache" / "one"
    assert entry(place) == {}
    file = made(place)
    assert entry(place) == {"values": file}
    assert caplog.text == ""
    damage(file)
    assert entry(place) == {}
    assert f"{place}: {NOTE}" in caplog.text
    assert entry(place) == {}
    assert made(place).read_bytes() == b"0.25, 0.5"
    assert entry(place)
    assert [f.name for f in place.parent.iterdir()] == ["one"]


def test_the_first_of_two_writers_wins(tmp_path: Path) -> None:
    place = tmp_path / "one"
    with building(tmp_path) as slow:
        (slow / "values").write_bytes(b"0")
        first = made(place)
        publish([slow / "values"], place)
    assert first.read_bytes() == b"0.25, 0.5"
    assert entry(place)


def test_what_a_killed_build_left_goes_with_the_next(tmp_path: Path) -> None:
    old, young = (tmp_path / f"{BUILDING}{name}" for name in ("old", "young"))
    for folder in (old, young):
        folder.mkdir()
        (folder / "half.o").touch()
    os.utime(old, (0, old.stat().st_mtime - LEFT))
    made(tmp_path / "one")
    assert not old.exists()
    assert young.exists()


def test_an_entry_is_on_the_disk_before_it_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    rename, sync = Path.rename, os.fsync

    def renamed(self: Path, target: Path) -> Path:
        told.append(f"rename to {target.name}")
        return rename(self, target)

    def synced(descriptor: int) -> None:
        told.append(f"sync {Path(f'/proc/self/fd/{descriptor}').readlink().name}")
        sync(descriptor)

    monkeypatch.setattr(Path, "rename", renamed)
    monkeypatch.setattr(os, "fsync", synced)
    made(tmp_path / "one")
    before = told[: told.index("rename to one")]
    assert {"sync values", "sync sha256", "sync .ready"} <= {*before}
    assert told[-1] == f"sync {tmp_path.name}"


def test_a_damaged_kernel_is_compiled_anew_and_kills_no_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from orchestrator.native.library import library

    whole = Path(library()._name)
    place = tmp_path / "libraries" / whole.parent.name
    place.mkdir(parents=True)
    for file in whole.parent.iterdir():
        (place / file.name).write_bytes(file.read_bytes())
    cut(place / whole.name)
    monkeypatch.setenv("FEEDDRIVE_CACHE", str(tmp_path))
    done = subprocess.run(
        [sys.executable, "-c", KERNEL], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert NOTE in done.stderr
    assert (place / whole.name).read_bytes() == whole.read_bytes()


@pytest.mark.parametrize("damage", [cut, altered])
def test_damaged_design_values_are_computed_anew(
    damage: Callable[[Path], None],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    from orchestrator.scenario.design_cache import remembered

    monkeypatch.setenv("FEEDDRIVE_CACHE", str(tmp_path))
    values = {"K": 0.1 + 0.2}
    assert remembered(DESIGN, {}, lambda: values) == values
    (file,) = (cache_folder() / "designs").glob("*/values.json")
    damage(file)
    assert remembered(DESIGN, {}, lambda: values) == values
    assert NOTE in caplog.text
    assert remembered(DESIGN, {}, dict) == values
