"""Model modules as Python sees them: import, freshness, and whose line is wrong.

A dotted name is imported as usual; a model file under its stem, with its folder
on the path while it loads.  Sources that changed since they were loaded by
``load_model`` are loaded again, so that a notebook builds what its editor shows.
"""

import importlib
import sys
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from fmus.allowed import refusal
from fmus.closure import (
    DataUnclear,
    NoSuchModule,
    closure,
    data_files,
    files_digest,
    is_file,
    module_name,
)
from fmus.model import Continuous, Model, Sampled
from fmus.own import HOME, OWN_PACKAGES, at_home

PACKAGE = Path(__file__).parent
# what CasADi says of a signal that Python takes for a number, and what we say
MEANT = {
    "truth value": "a signal is neither true nor false while it is traced: write "
    "np.where(condition, a, b) for if, np.minimum and np.maximum for min and max, "
    "np.logical_and and np.logical_or for and and or",
    "iterate over m.nz": "an array of signals cannot be unpacked or looped over: "
    "index it, as in x[0], or use NumPy on the whole",
    "x.size2()==y.size1()": "these arrays of signals do not fit: write np.dot(c, x) "
    "for a row times a column, A @ x for a matrix of shape (n, m) times (m,)",
}
_loaded: dict[str, str] = {}  # fingerprint of what each module was loaded from


class BuildError(Exception):
    """A module cannot be built into the FMU that was asked for."""


def sources(module: str) -> dict[str, Path]:
    """Return the files a model module is made of, by module name.

    Raises:
        BuildError: there is no such module, a file is no Python, or which data it
            reads is unclear.
    """
    try:
        files = closure(module)
        data_files(files)
    except NoSuchModule as error:
        if is_file(module):
            raise BuildError("no such file") from None
        top, _, rest = module.partition(".")
        if top in OWN_PACKAGES and rest:
            raise BuildError(
                f"{error}{_alike(top, rest)}; a model in a folder {top} of your own "
                f"is given by the path of its .py file"
            ) from None
        raise BuildError(
            f"{error}: give a dotted name such as plants.ball_screw.two_mass, or "
            f"the path of a .py file"
        ) from None
    except SyntaxError as error:
        raise BuildError(f"{error.filename}:{error.lineno}: {error.msg}") from None
    except DataUnclear as error:
        raise BuildError(str(error)) from None
    return files


def _alike(top: str, rest: str) -> str:
    """Return which modules of ours end in that name, as a question."""
    stem = rest.rpartition(".")[2]
    found = [
        ".".join(file.relative_to(HOME).with_suffix("").parts)
        for file in sorted((HOME / top).rglob(f"{stem}.py"))
    ]
    return f"; is it {' or '.join(found)}?" if found else ""


def load_model(module: str) -> Model:
    """Return the ``model`` of a module given by dotted name or file path.

    Raises:
        BuildError: no such module, it does not import, or it has no model.
    """
    loaded = load_module(module)
    model = getattr(loaded, "model", None)
    if not isinstance(model, Continuous | Sampled):
        if hasattr(loaded, "__path__"):
            raise BuildError(f"{module} is a package: name a model in it")
        raise BuildError(
            f"{module} has no model: end it with model = Continuous(...) or "
            f"model = Sampled(...)"
        )
    return model


def load_module(module: str) -> ModuleType:
    """Import a model module from its present sources.

    Raises:
        BuildError: no such module, or it does not import, or it may not be executed.
    """
    if why := refusal(module):
        raise BuildError(why)
    with at_home():
        return _load_module(module)


def _load_module(module: str) -> ModuleType:
    files, name = sources(module), module_name(module)
    if is_file(module) and name in sys.stdlib_module_names:
        raise BuildError(f"{module} has the name of a module of Python: rename it")
    _forget_stale(files)
    with importable(Path(module).resolve().parent if is_file(module) else None):
        try:
            imported = importlib.import_module(name)
        except Exception as error:
            what = f"{module} cannot be imported"
            raise BuildError(blame(error, files, what)) from error
    _loaded.update({n: _fingerprint(f) for n, f in files.items() if n in sys.modules})
    return imported


def blame(error: Exception, files: Mapping[str, Path], what: str) -> str:
    """Return a sentence with the model's own line at which an error arose."""
    own = {str(f) for f in files.values() if PACKAGE not in f.parents}
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename in own]
    reason = str(error).strip() or type(error).__name__
    reason = next((ours for theirs, ours in MEANT.items() if theirs in reason), reason)
    if not frames:
        return f"{what}: {reason}"
    line = frames[-1]
    return f"{what}: {line.filename}:{line.lineno}: {line.line}: {reason}"


def own_files(files: Mapping[str, Path]) -> dict[str, Path]:
    """Return those of a closure that are neither ``fmus`` nor Python's."""
    return {
        n: f
        for n, f in files.items()
        if PACKAGE not in f.parents and n not in sys.stdlib_module_names
    }


def _forget_stale(files: Mapping[str, Path]) -> None:
    """Drop the modules of a closure if one was loaded from other bytes."""
    own = own_files(files)
    if any(_stale(name, file) for name, file in own.items()):
        for name in own:
            sys.modules.pop(name, None)


def _stale(name: str, file: Path) -> bool:
    module = sys.modules.get(name)
    if module is None:
        return False
    origin = getattr(module, "__file__", None)
    if origin is None or Path(origin).resolve() != file.resolve():
        return True
    return _loaded.get(name, _fingerprint(file)) != _fingerprint(file)


def _fingerprint(file: Path) -> str:
    return files_digest({"": file}, data_files({"": file}))


@contextmanager
def importable(folder: Path | None) -> Iterator[None]:
    """Put a folder on the path; leave no bytecode that hides a quick edit."""
    importlib.invalidate_caches()
    path, written = sys.path[:], sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    if folder is not None:
        sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path[:], sys.dont_write_bytecode = path, written
