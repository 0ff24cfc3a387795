"""Which Python a command may execute because a file names it.

Ours, and what lies in the project: below the nearest folder above the working folder
that has a ``pyproject.toml``, else below the working folder; links are resolved,
installed packages do not count, unless they say themselves that they bring models
(entry points of ``feeddrive.models``).  A program that calls our functions decides for
itself: the rule holds inside ``only_project``, where commands without ``--trust`` are.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

from fmus.closure import is_file
from fmus.own import HOME, OWN_PACKAGES

INSTALLED = ("site-packages", "dist-packages")
_ONLY_PROJECT: ContextVar[bool] = ContextVar("only_project", default=False)


@contextmanager
def only_project(wanted: bool = True) -> Iterator[None]:
    """Execute in this block only what is ours or the project's."""
    token = _ONLY_PROJECT.set(wanted)
    try:
        yield
    finally:
        _ONLY_PROJECT.reset(token)


def trusts_all() -> bool:
    """Tell whether this is no command, or one that was given ``--trust``."""
    return not _ONLY_PROJECT.get()


def project() -> Path:
    """Return the folder of the project that the working folder is in."""
    here = Path.cwd().resolve()
    above = (here, *here.parents)
    return next((f for f in above if (f / "pyproject.toml").is_file()), here)


def refusal(module: str) -> str | None:
    """Return why a module, by dotted name or path, is not executed; None if it is."""
    if not _ONLY_PROJECT.get():
        return None
    top = module.partition(".")[0]
    if not is_file(module) and top in (*OWN_PACKAGES, *packages_of_models()):
        return None
    place = Path(module) if is_file(module) else _place(module.partition(".")[0])
    if place is None or _belongs(place.resolve()):  # none: nothing to import
        return None
    return (
        f"{module} is Python code that lies neither in feeddrive nor in the project "
        f"{project()}; read it, and give --trust to execute it"
    )


def packages_of_models() -> tuple[str, ...]:
    """Return the installed packages that bring models, by their entry points."""
    found = entry_points(group="feeddrive.models")
    return tuple(entry.value.partition(".")[0] for entry in found)


def _place(top: str) -> Path | None:
    if top in sys.builtin_module_names or top in sys.stdlib_module_names:
        return Path(sys.prefix)
    try:
        spec = find_spec(top)
    except (ImportError, ValueError):
        return Path(sys.prefix)
    if spec is None:
        return None
    folders = [*(spec.submodule_search_locations or ()), spec.origin]
    return Path(folders[0] or sys.prefix)


def _belongs(file: Path) -> bool:
    if any(file.is_relative_to(HOME / package) for package in OWN_PACKAGES):
        return True
    root = project()
    return file.is_relative_to(root) and not set(INSTALLED) & set(file.parts)
