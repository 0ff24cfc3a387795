"""Which source files a model is made of, found without importing them.

A model module is named by its dotted name or by the path of its file.  Its
closure is the module, the packages it lies in, and everything these import
from the same top-level package, from the folder of a model file, or from the
packages of this distribution.  Imports made by other means than ``import``
statements are not seen.  Data files that these modules read by
``fmus.data.read_data`` belong to the model as well.
"""

import ast
import sys
from collections.abc import Iterator, Mapping
from functools import lru_cache
from hashlib import sha256
from importlib.machinery import PathFinder
from pathlib import Path, PurePosixPath

from fmus.own import HOME, OWN_PACKAGES

READ_DATA = "read_data"  # the one function of fmus by which models read files
REMEMBERED = 4096  # sources whose syntax tree is not walked again


class NoSuchModule(LookupError):
    """There is no such model module."""


class DataUnclear(ValueError):
    """Which data file a module reads cannot be told, or it is missing."""


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


def data_files(files: Mapping[str, Path]) -> dict[str, Path]:
    """Return the data files that modules read, by path as in an installed package.

    Raises:
        DataUnclear: which file is read is not written out, or it is not there.
    """
    found = {}
    for name, file in files.items():
        package = file.name == "__init__.py"
        above = name.split(".") if package else name.split(".")[:-1]
        for data in _data_names(file):
            path = file.parent / data
            if not path.is_file():
                raise DataUnclear(f"{file} reads {data}, which is not beside it")
            found["/".join([*above, data])] = path
    return dict(sorted(found.items()))


def digest(module: str) -> str:
    """Return a fingerprint (hex) of the names and bytes of all a model is made of."""
    files = closure(module)
    return files_digest(files, data_files(files))


def files_digest(*groups: Mapping[str, Path]) -> str:
    """Return a fingerprint (hex) of groups of named files."""
    whole = sha256()
    for files in groups:
        for name, file in sorted(files.items()):
            content = file.read_bytes()
            whole.update(f"{name}\0{len(content)}\0".encode() + content)
        whole.update(b"\0")
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


def _imports(name: str, file: Path) -> tuple[str, ...]:
    """Return every name that an import statement of a file might load."""
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    return _imported(package, str(file), file.read_bytes())


@lru_cache(REMEMBERED)
def _imported(package: str, file: str, content: bytes) -> tuple[str, ...]:
    names: list[str] = []
    for node in ast.walk(ast.parse(content, file)):
        if isinstance(node, ast.Import):
            names.extend(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                above = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*above, base] if base else above)
            names.append(base)
            names.extend(f"{base}.{alias.name}" for alias in node.names)
    return tuple(names)


def _data_names(file: Path) -> tuple[str, ...]:
    """Return the names of the files that a module reads by ``read_data``."""
    return _data_named(str(file), file.read_bytes())


@lru_cache(REMEMBERED)
def _data_named(file: str, content: bytes) -> tuple[str, ...]:
    found: list[str] = []
    for node in ast.walk(ast.parse(content, file)):
        if not isinstance(node, ast.Call) or _called(node) != READ_DATA:
            continue
        match node:
            case ast.Call(
                args=[ast.Name(id="__file__"), ast.Constant(value=str(data))],
                keywords=[],
            ) if _below(data):
                found.append(data)
            case _:
                raise DataUnclear(
                    f"{file}:{node.lineno}: write the file out, as in "
                    f'{READ_DATA}(__file__, "table.json"), beside the module or below'
                )
    return tuple(found)


def _called(node: ast.Call) -> str | None:
    match node.func:
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name
    return None


def _below(data: str) -> bool:
    path = PurePosixPath(data)
    return bool(path.name) and not path.is_absolute() and ".." not in path.parts
