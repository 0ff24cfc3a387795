"""Nobody deletes a folder that somebody uses, however the two are interleaved."""

import os
import shutil
import tempfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from time import time

import pytest

from orchestrator.folders import held as holding
from orchestrator.folders import temporary
from orchestrator.folders.held import LOCK, FolderHeld, held, is_held
from orchestrator.folders.temporary import sweep, temporary_folder
from orchestrator.history import folder as numbered


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_a_folder_that_was_left_goes_and_one_in_use_stays(place: Path) -> None:
    left, made, old = (place / f"{temporary.PREFIX}{n}" for n in ("a", "b", "c"))
    for folder in (left, made, old):
        folder.mkdir()
    (left / LOCK).touch()
    (left / "binaries").mkdir()
    os.utime(old, (time(), time() - 2 * temporary.YOUNG))
    with temporary_folder() as used:
        sweep()
        assert sorted(place.iterdir()) == sorted([made, used])
    assert sorted(place.iterdir()) == [made]


def test_a_folder_deleted_before_it_was_taken_is_made_again(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    swept, take = [], holding._take_soon

    def late(lock: int, patience: float) -> None:
        if not swept:  # its file is there, its lock not yet
            swept.extend(place.iterdir())
            sweep()
        take(lock, patience)

    monkeypatch.setattr(holding, "_take_soon", late)
    with temporary_folder() as folder:
        assert [folder] == list(place.iterdir()) != swept
        assert is_held(folder)


def test_nobody_takes_a_folder_while_it_is_deleted(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left, delete = place / f"{temporary.PREFIX}left", shutil.rmtree
    left.mkdir()
    (left / LOCK).touch()
    refused = []

    def slow(folder: Path, **given: bool) -> None:
        with pytest.raises(FolderHeld), held(folder, patience=0):
            pass
        refused.append(folder)
        delete(folder, **given)

    monkeypatch.setattr(shutil, "rmtree", slow)
    sweep()
    assert refused == [left]
    assert not left.exists()


def test_a_number_is_taken_though_the_parent_goes_meanwhile(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parent, make = place / "runs" / "study", Path.mkdir

    def make_late(folder: Path, *given: object, **named: bool) -> None:
        if folder == parent / "1" and (place / "other").is_dir():
            (place / "other").rmdir()
            parent.rmdir()  # the other run was refused
        make(folder, *given, **named)

    (place / "other").mkdir()
    monkeypatch.setattr(Path, "mkdir", make_late)
    with ExitStack() as stack:
        taken = numbered._next_number(parent, stack)
        assert taken.path.is_dir()
        assert is_held(taken.path)


def test_many_take_different_numbers_while_others_are_refused(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(place)
    parent = Path("runs/study")

    def take(n: int) -> int | None:
        with ExitStack() as stack:
            one = numbered._next_number(parent, stack)
            if n % 2:
                return one.number
            numbered._forget(one)
            return None

    with ThreadPoolExecutor(8) as pool:
        numbers = [n for n in pool.map(take, range(200)) if n is not None]
    there = [int(p.name) for p in parent.iterdir()]
    assert sorted(numbers) == sorted(there)
