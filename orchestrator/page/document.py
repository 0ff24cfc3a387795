"""A scenario's file as it is written, changed in place: comments and order stay.

Every change is made to what the file says at that moment, so that one made elsewhere is
never lost, and written by rename.  What the file would no longer be read with is
refused; the text before the last changes can be had back.
"""

from collections.abc import Iterator, Mapping, MutableMapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import Comment, Table, Whitespace

from orchestrator.errors import FeedDriveError, ScenarioError
from orchestrator.scenario.inherit import REMOVABLE
from orchestrator.scenario.reading import load_scenario, read_scenario
from orchestrator.scenario.toml import read_toml_text, toml

KEPT = 50  # texts that can be had back


class Document:
    """The tables of a file under change; ``merged`` are those with its bases'."""

    def __init__(self, file: Path, text: str) -> None:
        self.file = file
        self.tables: MutableMapping[str, Any] = tomlkit.parse(text)
        self.merged: Mapping[str, Any] = read_scenario(file)

    def put(self, path: tuple[str, ...], value: Any) -> None:
        """Write an entry, its tables made where there are none."""
        table = self.tables
        for depth, key in enumerate(path[:-1]):
            if key not in table:
                # [components.plant] needs no [components] before it
                table[key] = tomlkit.table(is_super_table=depth < len(path) - 2)
            table = table[key]
            if not isinstance(table, MutableMapping):
                raise ScenarioError(f"{'.'.join(path[: depth + 1])} is no table")
        table[path[-1]] = value

    def drop(self, path: tuple[str, ...]) -> None:
        """Remove an entry; one that is inherited is written as removed.

        Raises:
            ScenarioError: there is none, or it is inherited and cannot be removed.
        """
        table: Any = self.tables
        for key in path[:-1]:
            table = table.get(key, {})
        if path[-1] in table:
            del table[path[-1]]
            return
        if not _has(self.merged, path):
            raise ScenarioError(f"there is no {'.'.join(path)}")
        if len(path) != 2 or path[0] not in REMOVABLE:
            raise ScenarioError(
                f"{'.'.join(path)} is inherited from a base; change it there"
            )
        self.put(path, False)

    def component(self, name: str) -> Mapping[str, Any]:
        """Return a component's table as it holds.

        Raises:
            ScenarioError: there is none.
        """
        found = self.merged.get("components", {}).get(name)
        if not isinstance(found, Mapping):
            raise ScenarioError(f"there is no component {name!r}")
        return found


def _has(tables: Mapping[str, Any], path: tuple[str, ...]) -> bool:
    found: Any = tables
    for key in path:
        if not isinstance(found, Mapping) or key not in found:
            return False
        found = found[key]
    return True


def lines(text: str) -> Table:
    """Return the lines of a map, comments kept, as a table.

    Raises:
        ScenarioError: they are no TOML.
    """
    try:
        toml(text)
        document = tomlkit.parse(text)
    except (ValueError, TOMLKitError) as error:
        raise ScenarioError(f"map: not valid TOML: {error}") from None
    found = tomlkit.table()
    for key, item in document.body:
        if key is not None:
            found.add(key, item)
        elif isinstance(item, Comment | Whitespace):
            found.add(item)
    return found


class Editor:
    """Changes files, and has their texts of before."""

    def __init__(self) -> None:
        self._before: list[tuple[Path, str | None]] = []

    def files(self) -> list[Path]:
        """Return the files whose last change can be undone, the newest last."""
        return [file for file, _ in self._before]

    @contextmanager
    def changing(self, file: Path) -> Iterator[Document]:
        """Give the file's tables to be changed; write them if it can still be read.

        Raises:
            ScenarioError: it is no TOML, or would be no scenario any more.
        """
        before = _text(file)
        try:
            document = Document(file, before)
        except TOMLKitError as error:
            raise ScenarioError(f"{file}: not valid TOML: {error}") from None
        yield document
        self.write(file, tomlkit.dumps(document.tables))

    def write(self, file: Path, text: str) -> None:
        """Write a file that is a scenario, or was none before either.

        Raises:
            ScenarioError: the text is no scenario that can be read.
        """
        before = _text(file) if file.is_file() else None
        trial = file.with_name(f".{file.name}.partial.toml")
        trial.write_text(text, encoding="utf-8")
        try:
            load_scenario(trial)
        except FeedDriveError as error:
            trial.unlink()
            told = str(error).replace(str(trial), str(file))
            told = told.removeprefix(f"{file}: ")
            raise ScenarioError(f"not written: {told}") from None
        trial.replace(file)
        if before != text:
            self._before = [*self._before[-KEPT:], (file, before)]

    def undo(self, file: Path) -> None:
        """Write what a file said before its last change.

        Raises:
            ScenarioError: nothing of it was changed.
        """
        for i in reversed(range(len(self._before))):
            if self._before[i][0] == file:
                _, text = self._before.pop(i)
                break
        else:
            raise ScenarioError(f"{file.name}: nothing was changed here")
        if text is None:
            with suppress(FileNotFoundError):
                file.unlink()
            return
        trial = file.with_name(f".{file.name}.partial.toml")
        trial.write_text(text, encoding="utf-8")
        trial.replace(file)


def _text(file: Path) -> str:
    try:
        return read_toml_text(file)
    except OSError as error:
        raise ScenarioError(f"{file}: cannot be read ({error.strerror})") from None
    except ValueError as error:
        raise ScenarioError(f"{file}: {error}") from None
