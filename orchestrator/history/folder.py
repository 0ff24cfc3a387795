"""The folder of a run, its own from the first moment to the last.

``runs/<study>/<scenario>/<n>/`` with n = 1, 2, ... taken by making it, or a folder
the user names::

    format                    a number: how the rest is laid out
    begun.json                what runs, since when, what was changed
    scenario.lock.toml fmus/  the run written down
    result/                   rows, readable throughout
    report.html
    ended.json                why a run failed or who interrupted it
    checkpoint                from where it can be gone on with, until it has its tables
    checkpoints/              those that are kept, for runs that begin there
    origin                    the checkpoint of another run at which it began
    metrics.json              written last, by rename: the run is complete

It is held (``orchestrator.folders.held``) while the run is under way.  A run that was
refused before anything was recorded leaves no folder.
"""

import json
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal, TypeAlias

from fmus.cache import on_disk
from orchestrator.errors import FeedDriveError, Interrupted, ScenarioError
from orchestrator.folders.held import LOCK as HELD
from orchestrator.folders.held import FolderHeld, held
from orchestrator.result import reached

RUNS = Path("runs")
FORMAT = 1
FORMAT_FILE = "format"
BEGUN = "begun.json"
ENDED = "ended.json"
METRICS = "metrics.json"
ORIGIN = "origin"
TRIES = 1000
Kind: TypeAlias = Literal["run", "demo", "reproduce", "sweep", "response", "tune"]
_FILES = (
    *(FORMAT_FILE, BEGUN, ENDED, METRICS),
    *("report.html", "scenario.lock.toml", "checkpoint", ORIGIN),
)
_FOLDERS = ("result", "fmus", "original", "checkpoints")


@dataclass(frozen=True)
class Begun:
    """What is run: ``name`` as ``run`` takes it, ``stop`` (s) if it has one.

    ``checkpoint`` is how much simulated time (s) lies between two of them, exactly,
    ``kept`` whether all stay; ``origin`` names the run at whose checkpoint it began.
    """

    kind: Kind
    name: str
    changed: tuple[str, ...] = ()
    stop: float | None = None
    checkpoint: str | None = None
    kept: bool = False
    origin: str | None = None


@dataclass(frozen=True)
class RunFolder:
    """A folder that is held; ``number`` is n where it was numbered."""

    path: Path
    number: int | None = None

    def complete(self, summary: Mapping[str, Any]) -> None:
        """Write the figures, when its rows are on the disk: now the run is complete."""
        for file in (self.path / "result").glob("*"):
            on_disk(file)
        _write(self.path / METRICS, summary, on_disk)


@contextmanager
def taken(
    folder: Path | None, begun: Begun, *, overwrite: bool = False
) -> Iterator[RunFolder]:
    """Take a folder for a run, the next numbered one if ``folder`` is None.

    What ends the run is noted, and a ``FeedDriveError`` told where rows are.

    Raises:
        ScenarioError: the folder holds a run, or other things; see ``overwrite``.
        Interrupted: Ctrl-C, when there are rows already.
    """
    with ExitStack() as stack:
        if folder is None:
            place = _next_number(RUNS / begun.name, stack)
        else:
            place = RunFolder(_named(folder, overwrite, stack))
        (place.path / FORMAT_FILE).write_text(f"{FORMAT}\n", encoding="utf-8")
        now = datetime.now(UTC).isoformat(timespec="microseconds")
        _write(place.path / BEGUN, {**asdict(begun), "begun": now})
        with _noted(place):
            yield place


@contextmanager
def taken_again(folder: Path) -> Iterator[tuple[RunFolder, Begun]]:
    """Take the folder of a run that has checkpoints and did not get to its end.

    Raises:
        ScenarioError: it is under way, is complete, or has no checkpoints.
    """
    if not (folder / BEGUN).is_file():
        raise ScenarioError(f"{folder}: holds no run; `feeddrive runs` lists them")
    with ExitStack() as stack:
        try:
            stack.enter_context(held(folder))
        except FolderHeld:
            raise ScenarioError(f"{folder}: is under way") from None
        if (folder / METRICS).is_file() and (folder / METRICS).read_bytes():
            raise ScenarioError(f"{folder}: is complete; there is nothing to resume")
        try:
            content = json.loads((folder / BEGUN).read_text(encoding="utf-8"))
            del content["begun"]
            begun = Begun(**{**content, "changed": tuple(content["changed"])})
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ScenarioError(f"{folder / BEGUN}: is damaged ({error})") from None
        if begun.checkpoint is None:
            raise ScenarioError(
                f"{folder}: has no checkpoints to go on from; run it anew, with "
                f"--checkpoint"
            )
        number = int(folder.name) if folder.name.isdecimal() else None
        place = RunFolder(folder, number)
        with _noted(place):
            (folder / ENDED).unlink(missing_ok=True)
            yield place, begun


@contextmanager
def _noted(place: RunFolder) -> Iterator[None]:
    """Note what ends a run, and tell a ``FeedDriveError`` where rows are."""
    try:
        yield
    except BaseException as error:
        rows = _reached(place.path)
        if isinstance(error, FeedDriveError):
            if error.exit_code == 2 and not any(place.path.rglob("result")):
                _forget(place)
                raise
            error.folder = None if rows is None else place.path
        interrupted = isinstance(error, KeyboardInterrupt | Interrupted)
        how = "interrupted" if interrupted else "failed"
        with suppress(OSError):  # the disk may be full: the first error counts
            _write(place.path / ENDED, {"how": how, "why": str(error)})
        if not isinstance(error, KeyboardInterrupt) or rows is None:
            raise
        told = Interrupted(
            f"interrupted at t = {rows:g} s; the rows until then are in "
            f"{place.path}/result"
        )
        told.folder = place.path
        raise told from None


def _forget(place: RunFolder) -> None:
    shutil.rmtree(place.path, ignore_errors=True)
    if place.number is not None:
        with suppress(OSError):  # others ran there
            for parent in place.path.parents[:-1]:
                parent.rmdir()


def _next_number(parent: Path, stack: ExitStack) -> RunFolder:
    number = 0
    for _ in range(TRIES):
        parent.mkdir(parents=True, exist_ok=True)
        with suppress(FileNotFoundError):  # a run that was refused deleted the parent
            there = (int(p.name) for p in parent.iterdir() if p.name.isdecimal())
            number = max(number, 0, *there) + 1
            folder = parent / str(number)
            with suppress(FileExistsError):  # another run was quicker
                folder.mkdir()
                stack.enter_context(held(folder))
                return RunFolder(folder, number)
    raise ScenarioError(f"{parent}: other runs begin and end there; give a folder, -o")


def _named(folder: Path, overwrite: bool, stack: ExitStack) -> Path:
    """Take the folder of that name; lose what an earlier run left in it if asked."""
    if folder.is_file():
        raise ScenarioError(f"{folder}: is a file; give a folder with -o")
    folder.mkdir(parents=True, exist_ok=True)
    there = {path.name for path in folder.iterdir()} - {HELD}
    if there and not holds_run(folder):
        raise ScenarioError(
            f"{folder}: holds files that are no run; give another folder with -o"
        )
    try:
        stack.enter_context(held(folder))
    except FolderHeld:
        raise ScenarioError(
            f"{folder}: another run is writing there; give another folder with -o"
        ) from None
    if holds_run(folder):
        if not overwrite:
            raise ScenarioError(
                f"{folder}: holds a run already; give another folder with -o, or "
                f"--overwrite to lose that run"
            )
        for name in _FOLDERS:
            shutil.rmtree(folder / name, ignore_errors=True)
        for name in _FILES:
            (folder / name).unlink(missing_ok=True)
    return folder


def holds_run(folder: Path) -> bool:
    """Tell whether a folder is that of a run, also of before folders had a format."""
    marks = (FORMAT_FILE, BEGUN, "scenario.lock.toml")
    return any((folder / name).is_file() for name in marks)


def _reached(folder: Path) -> float | None:
    try:
        return reached(folder)
    except Exception:  # whatever is wrong with the rows, the run's own error counts
        return None


def _write(
    file: Path,
    content: Mapping[str, Any],
    synced: Callable[[Path], None] = lambda _: None,
) -> None:
    """Write JSON so that a reader sees all of it or the file that was there."""
    partial = file.with_suffix(".partial")
    partial.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    synced(partial)
    partial.replace(file)
