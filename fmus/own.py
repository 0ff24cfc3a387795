"""The packages of this distribution, found by where they stand.

A user's folder ``controllers`` or ``plants`` beside a script or a test may come
first on ``sys.path``.  ``at_home`` lets ours be imported all the same, and then
gives the user's names back: functions of ours keep their own modules.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.machinery import PathFinder
from pathlib import Path
from types import ModuleType

HOME = Path(__file__).resolve().parent.parent
OWN_PACKAGES = ("controllers", "fmus", "plants")
_SHADOWED = ("controllers", "plants")  # fmus is imported, or this would not run
_hidden: dict[str, ModuleType] = {}  # ours, while a user's have their names


@contextmanager
def at_home() -> Iterator[None]:
    """Import ``controllers`` and ``plants`` from this distribution in this block."""
    theirs = {n: m for n, m in _modules().items() if not _is_ours(m)}
    shadows = bool(theirs) or any(found_elsewhere(name) for name in _SHADOWED)
    for name in theirs:
        del sys.modules[name]
    sys.modules.update(_hidden)
    _hidden.clear()
    _import_packages()
    try:
        yield
    finally:
        if shadows:
            _hidden.update(_modules())
            for name in _hidden:
                del sys.modules[name]
        sys.modules.update(theirs)


def found_elsewhere(name: str) -> bool:
    """Tell whether ``import name`` would find a package that is not ours."""
    spec = PathFinder.find_spec(name, sys.path)
    file = spec.origin if spec else None
    return file is not None and not Path(file).resolve().is_relative_to(HOME / name)


def _import_packages() -> None:
    """Import the packages alone; their modules are then found inside them."""
    sys.path.insert(0, str(HOME))
    try:
        for name in _SHADOWED:
            import_module(name)
    finally:
        sys.path.remove(str(HOME))


def _modules() -> dict[str, ModuleType]:
    return {
        name: module
        for name, module in list(sys.modules.items())
        if name.partition(".")[0] in _SHADOWED
    }


def _is_ours(module: ModuleType) -> bool:
    file = getattr(module, "__file__", None)
    return file is not None and Path(file).resolve().is_relative_to(HOME)
