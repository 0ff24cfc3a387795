"""Which source files a model is made of, found without importing them.

A model module is named by its dotted name or by the path of its file.  Its
closure is the module, the packages it lies in, and everything these import
from the same top-level package, from the folder of a model file, or from the
packages of this distribution.  Imports made by other means than ``import``
statements are not seen.
"""

import ast
import sys
from collections.abc import Iterator, Mapping
from hashlib import sha256
from importlib.machinery import PathFinder
from pathlib import Path

from fmus.own import HOME, OWN_PACKAGES


class NoSuchModule(LookupError):
    """There is no such model module."""


def module_name(module: str) -> str:
    """Return the name under which a model module is imported."""
    return Path(module).stem if is_file(module) else module


def is_file(module: str) -> bool:
    """Tell the path of a model file from a dotted name."""
    return module.endswith(".py")


def closure(module: str) -> dict[str, Path]:
    """Return the file of every module a model module is made of, by name.

    Raises:
        NoSuchModule: there is no such file or module.
    """
    name = module_name(module)
    roots = _roots(module)
    if _file(name, roots) is None:
        raise NoSuchModule(f"there is no module {module!r}")
    found: dict[str, Path] = {}
    waiting = [name]
    while waiting:
        name = waiting.pop()
        file = _file(name, roots)
        if name in found or file is None:
            continue
        found[name] = file
        waiting.extend(_parents(name))
        waiting.extend(_imports(name, file))
    return dict(sorted(found.items()))


def digest(module: str) -> str:
    """Return a fingerprint (hex) of the names and bytes of a model's sources."""
    return files_digest(closure(module))


def files_digest(files: Mapping[str, Path]) -> str:
    """Return a fingerprint (hex) of named files."""
    whole = sha256()
    for name, file in sorted(files.items()):
        content = file.read_bytes()
        whole.update(f"{name}\0{len(content)}\0".encode() + content)
    return whole.hexdigest()


def _roots(module: str) -> dict[str, Path]:
    """Return the folder in which each top-level name of the closure lies."""
    roots: dict[str, Path] = dict.fromkeys(OWN_PACKAGES, HOME)
    if is_file(module):
        folder = Path(module).resolve().parent
        for path in sorted(folder.iterdir()) if folder.is_dir() else ():
            module_there = path.suffix == ".py" or (path / "__init__.py").is_file()
            if module_there and path.stem not in OWN_PACKAGES:
                roots[path.stem] = folder
    else:
        top = module.partition(".")[0]
        if top not in roots and (place := _folder(top)):
            roots[top] = place
    return roots


def _folder(top: str) -> Path | None:
    """Return the folder that holds a top-level module, without importing it."""
    if not top:
        return None
    spec = PathFinder.find_spec(top, sys.path)
    if spec is None or not spec.origin:
        return None
    file = Path(spec.origin)
    return file.parent.parent if file.name == "__init__.py" else file.parent


def _file(name: str, roots: dict[str, Path]) -> Path | None:
    folder = roots.get(name.partition(".")[0])
    if folder is None or not name:
        return None
    path = folder.joinpath(*name.split("."))
    for file in (path / "__init__.py", path.with_suffix(".py")):
        if file.is_file():
            return file
    return None


def _parents(name: str) -> Iterator[str]:
    while "." in name:
        name = name.rpartition(".")[0]
        yield name


def _imports(name: str, file: Path) -> Iterator[str]:
    """Yield every name that an import statement of a file might load."""
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(file.read_bytes(), str(file))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                above = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*above, base] if base else above)
            yield base
            yield from (f"{base}.{alias.name}" for alias in node.names)
