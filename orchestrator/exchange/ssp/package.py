"""Where the files of a system structure lie, and which of them is meant.

A package is an ``.ssp`` archive, a folder that holds ``.ssd`` files, or one ``.ssd``.
An archive is unpacked into a folder of the caller's.  A source is opened only inside
the folder of its description, or, ``sources_anywhere``, among the files of this
computer; nothing is ever fetched.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from urllib.parse import unquote, urlsplit
from urllib.request import url2pathname
from zipfile import ZipFile

from orchestrator.errors import FmuError, ScenarioError, did_you_mean
from orchestrator.exchange.ssp.xml import DEFAULT
from orchestrator.fmu.archive import DAMAGE, checked_members

_ANYWHERE: ContextVar[bool] = ContextVar("anywhere", default=False)


@contextmanager
def sources_anywhere(wanted: bool) -> Iterator[None]:
    """Open in this block sources outside of packages as well."""
    token = _ANYWHERE.set(wanted)
    try:
        yield
    finally:
        _ANYWHERE.reset(token)


def is_package(name: str | Path) -> bool:
    """Tell whether a path is a system structure and no scenario of ours."""
    path = Path(name)
    if path.is_dir():
        return any(path.glob("*.ssd"))
    return path.suffix.lower() in (".ssp", ".ssd")


def unpack(path: Path, folder: Path) -> Path:
    """Return the folder with the files of a package, an archive unpacked.

    Raises:
        ScenarioError: no such file, or it is no archive that is safe to unpack.
    """
    if path.is_dir():
        return path
    if not path.is_file():
        raise ScenarioError(f"{path}: no such file")
    if path.suffix.lower() == ".ssd":
        return path.parent
    try:
        found = checked_members(path)
        with ZipFile(path) as archive:
            archive.extractall(folder, found)
    except FmuError as error:
        raise ScenarioError(str(error)) from None
    except DAMAGE as error:
        raise ScenarioError(
            f"{path}: cannot be unpacked ({error}); the archive is damaged or the "
            f"disk is full"
        ) from None
    return folder


def description(path: Path, folder: Path, variant: str | None) -> Path:
    """Return the description that is meant: ``SystemStructure.ssd`` or a variant.

    Raises:
        ScenarioError: there is none, or several and none is the default.
    """
    known = {file.name: file for file in sorted(folder.glob("*.ssd"))}
    if path.suffix.lower() == ".ssd":
        known = {path.name: path} if variant is None else known
    if variant is not None:
        for name in (variant, f"{variant}.ssd"):
            if name in known:
                return known[name]
        raise ScenarioError(
            f"{path}: has no variant {variant!r}; {did_you_mean(variant, known)}"
        )
    if DEFAULT in known:
        return known[DEFAULT]
    if len(known) == 1:
        return next(iter(known.values()))
    if not known:
        raise ScenarioError(
            f"{path}: holds no {DEFAULT}; a package has one at its top, or another "
            f".ssd there that --variant names"
        )
    raise ScenarioError(
        f"{path}: holds several systems and none is {DEFAULT}; choose one with "
        f"--variant: {', '.join(known)}"
    )


def inside(root: Path, base: Path, source: str) -> Path:
    """Return the file a source names, looked up from the folder of its document.

    Raises:
        ScenarioError: it lies outside the package, or is not there.
    """
    parts = urlsplit(source)
    is_file = parts.scheme == "file" and parts.netloc in ("", "localhost")
    if (parts.scheme or parts.netloc) and not is_file:
        raise ScenarioError(
            f"source {source!r} lies outside the package, and nothing is fetched; put "
            f"the file into the package and name it by a relative path"
        )
    file = base / (url2pathname(parts.path) if is_file else unquote(parts.path))
    outside = is_file or not file.resolve().is_relative_to(root.resolve())
    if outside and not _ANYWHERE.get():
        raise ScenarioError(
            f"source {source!r} lies outside the package, where nothing is opened "
            f"unasked; look at it and give --trust, or put the file into the package "
            f"and name it by a relative path"
        )
    if not file.is_file():
        where = "" if outside else " in the package"
        raise ScenarioError(f"source {source!r}: there is no such file{where}")
    return file
