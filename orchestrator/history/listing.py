"""Which runs there are below a folder: what, when, changed, how far, what came out.

A folder that says its ``format`` is one entry, whatever lies in it: the members of
a reproduction or of a comparison are none.
"""

import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Literal, TypeAlias

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.folders.held import is_held
from orchestrator.history.folder import BEGUN, ENDED, FORMAT_FILE, METRICS
from orchestrator.result import reached

State: TypeAlias = Literal["complete", "under way", "failed", "interrupted", "killed"]


@dataclass(frozen=True)
class Entry:
    """One run: ``name`` is its folder below the one that was listed.

    ``stop`` and ``reached`` in s, ``summary`` what its verb prints with --json, ``why``
    what ended it early.
    """

    folder: Path
    name: str
    kind: str
    state: State
    begun: datetime
    changed: tuple[str, ...]
    stop: float | None
    reached: float | None
    summary: Mapping[str, Any]
    why: str

    def as_json(self) -> dict[str, Any]:
        """Return the object that ``runs --json`` prints for this entry."""
        return {
            **vars(self),
            "folder": str(self.folder),
            "begun": self.begun.isoformat(),
        }


def entries(root: Path) -> list[Entry]:
    """Return the runs below a folder, the newest last."""
    found = (_entry(folder, root) for folder in _folders(root))
    return sorted(
        (e for e in found if e is not None), key=lambda e: (e.begun, e.folder)
    )


def remove(chosen: Sequence[Entry]) -> None:
    """Delete runs.

    Raises:
        ScenarioError: one of them is under way; then none is deleted.
    """
    for entry in chosen:
        if entry.state == "under way":
            raise ScenarioError(f"{entry.name} is under way; stop it first")
    for entry in chosen:
        shutil.rmtree(entry.folder)


def find(name: str, known: Sequence[Entry]) -> Entry:
    """Return the run of a name, of the end of one, or of a number alone.

    Raises:
        ScenarioError: there is none, or several.
    """
    fit = [e for e in known if f"/{e.name}".endswith(f"/{name.strip('/')}")]
    if len(fit) == 1:
        return fit[0]
    if fit:
        names = ", ".join(e.name for e in fit)
        raise ScenarioError(f"{name} may be {names}; write more of its name")
    remedy = did_you_mean(name, (e.name for e in known))
    raise ScenarioError(f"there is no run {name!r}; {remedy}")


def _folders(root: Path) -> Iterator[Path]:
    for folder in sorted(root.iterdir()) if root.is_dir() else ():
        if folder.is_symlink() or not folder.is_dir():
            continue
        if (folder / FORMAT_FILE).is_file():
            yield folder
        else:
            yield from _folders(folder)


def _entry(folder: Path, root: Path) -> Entry | None:
    begun = _read(folder / BEGUN)
    if not begun:  # it is just being made
        return None
    held = False
    with suppress(OSError):  # of another user: it is not ours to say more
        held = is_held(folder)
    summary, ended = _read(folder / METRICS), _read(folder / ENDED)
    state: State = "killed"
    if summary:
        state = "complete"
    elif held:
        state = "under way"
    elif ended:
        state = ended["how"]
    last = None
    with suppress(Exception):  # rows that cannot be read are no reason to list nothing
        last = reached(folder)
    return Entry(
        folder,
        folder.relative_to(root).as_posix(),
        begun["kind"],
        state,
        datetime.fromisoformat(begun["begun"]),
        tuple(begun["changed"]),
        begun["stop"],
        last,
        summary,
        ended.get("why", ""),
    )


def _read(file: Path) -> dict[str, Any]:
    try:
        content: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content
