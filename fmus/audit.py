"""Files that a model reads while it is imported or traced, seen as Python opens them.

What is read by ``fmus.data.read_data`` belongs to the model.  Anything else would be
missing from its digest and from its FMU, which would stay as they are when the file
changes: it is refused.  What third parties read to import themselves is theirs.
"""

import os
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from importlib.util import source_from_cache
from pathlib import Path
from types import FrameType
from typing import Any

from fmus.closure import data_files, is_file, module_name
from fmus.load import BuildError, importable, own_files

INSTALLED = {"site-packages", "dist-packages"}


def refuse_hidden_files(module: str, files: Mapping[str, Path]) -> None:
    """Import a model apart from the modules in memory and watch what it reads.

    Raises:
        BuildError: it reads a file that does not belong to it.
    """
    own = own_files(files)
    kept = {name: sys.modules.pop(name) for name in own if name in sys.modules}
    folder = Path(module).resolve().parent if is_file(module) else None
    try:
        with watched(files, "imported"), importable(folder):
            import_module(module_name(module))
    except BuildError:
        raise
    except Exception:  # told by whoever imports it in earnest
        pass
    finally:
        for name in own:
            sys.modules.pop(name, None)
        sys.modules.update(kept)


@contextmanager
def watched(files: Mapping[str, Path], doing: str) -> Iterator[None]:
    """Watch what the code of these files reads in this thread.

    Raises:
        BuildError: a file that does not belong to them, at the end.
    """
    watch = _Watch(files)
    _hook()
    _watches[threading.get_ident()] = watch
    try:
        yield
    finally:
        del _watches[threading.get_ident()]
    for file, line, opened in watch.hidden:
        raise BuildError(
            f"{file}:{line}: reads {opened} while it is {doing}: the FMU would not "
            f"change with that file.  {_remedy(opened)}"
        )


class _Watch:
    """Which files are a model's own, and what else its code opened at which line."""

    def __init__(self, files: Mapping[str, Path]) -> None:
        known = [*files.values(), *data_files(files).values()]
        self.own = {file.resolve() for file in own_files(files).values()}
        self.known = {file.resolve() for file in known}
        self.folders = {file.parent for file in self.own}
        self.hidden: list[tuple[str, int, Path]] = []

    def see(self, path: str, frame: FrameType | None) -> None:
        """Note a file if the model's code opened it, or had it imported."""
        imported = False
        while frame is not None and _real(frame.f_code.co_filename) not in self.own:
            imported |= frame.f_code.co_filename.startswith("<frozen importlib")
            frame = frame.f_back
        if frame is None:
            return
        opened = _source(path).resolve()
        near = not self.folders.isdisjoint(opened.parents)
        theirs = not near or not INSTALLED.isdisjoint(opened.parts)
        if opened not in self.known and not (imported and theirs):
            self.hidden.append((frame.f_code.co_filename, frame.f_lineno, opened))


_watches: dict[int, _Watch] = {}


@cache
def _hook() -> None:
    """Have Python tell of every file it opens; this cannot be undone."""

    def tell(event: str, arguments: tuple[Any, ...]) -> None:
        if event != "open" or not _watches:
            return
        watch = _watches.get(threading.get_ident())
        path, mode = arguments[:2]
        written = isinstance(mode, str) and mode[:1] in ("w", "a", "x")
        if watch is not None and isinstance(path, str | bytes) and not written:
            watch.see(os.fsdecode(path), sys._getframe(1))

    sys.addaudithook(tell)


@cache
def _real(file: str) -> Path:
    return Path(file).resolve()


def _source(path: str) -> Path:
    """Return the source of a file of bytecode, else the file itself."""
    try:
        return Path(source_from_cache(path) if path.endswith(".pyc") else path)
    except ValueError:
        return Path(path)


def _remedy(opened: Path) -> str:
    if opened.suffix == ".py":
        return "Import it by an import statement."
    return (
        f"Read it by fmus.data.read_data(__file__, {opened.name!r}), "
        f"with the file beside the module."
    )
