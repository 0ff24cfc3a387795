"""From the name of a model module to an FMU file, built once and then cached.

The cache (the user's, or FEEDDRIVE_CACHE) is keyed by the sources of the model
and of ``fmus``, the versions of the tools and the options; a hit imports neither
the model nor a tool.  Files appear in it whole or not at all, so that several
processes may build at once; one that is no longer what was written is made anew.
What is in it is trusted (``fmus.trust``).
"""

import os
import platform as host
import shutil
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

from fmus.cache import building, cache_folder, entry, publish
from fmus.closure import data_files, files_digest, module_name
from fmus.load import PACKAGE, BuildError, load_model, sources
from fmus.trust import is_trusted, trust

if TYPE_CHECKING:
    from fmus.bare_c import Real
    from fmus.preset import Value
    from fmus.subject import Fmi

__all__ = ["BuildError", "FmuKind", "build", "build_c", "build_made", "load_model"]

FmuKind: TypeAlias = Literal["native", "python"]
TOOLS: Mapping[FmuKind, tuple[str, ...]] = {
    "native": ("feeddrive-cosim", "casadi", "ziglang"),
    "python": ("feeddrive-cosim", "casadi", "pythonfmu", "ziglang"),
}


def build(
    module: str,
    *,
    kind: FmuKind = "native",
    fmi: "Fmi" = 2,
    period: Fraction | None = None,
    values: Mapping[str, "Value"] | None = None,
    origin: str = "",
    clock: bool = True,
    platforms: Sequence[str] | None = None,
    folder: Path | None = None,
) -> Path:
    """Return an FMU of ``module.model``, from the cache if it is there.

    ``module`` is a dotted name or the path of a model file.  ``period`` (s)
    replaces that of a sampled model, ``values`` the start values they name; the
    documentation then tells their ``origin``.  Without ``clock`` a sampled model
    has no input clock in FMI 3, which some importers take for a number.
    ``platforms``, called as by us or as in FMI (``win64``, ``x86_64-windows``),
    default to the host's; those of Python FMUs are pythonfmu's.  With ``folder``
    the file is copied there.

    Raises:
        BuildError: the options do not go together, or the module is missing, has
            no model, or one that cannot be traced or compiled.
        OSError: the file cannot be written; it is named.
    """
    _check_options(kind, fmi, period)
    if values and kind == "python":
        raise BuildError("Python FMUs keep the start values of their module")
    files = sources(module)
    wanted = None if platforms is None else _named(platforms)
    rate = f"-{period.numerator}_{period.denominator}" if period else ""
    here = (host.system(), host.machine())
    told = (sorted((values or {}).items()), origin)
    key = _key(
        files, kind, fmi, period, told, clock, here if wanted is None else wanted
    )
    place = cache_folder() / "fmus" / f"{module_name(module)}-{kind}{fmi}{rate}-{key}"
    fmu = _kept(place)
    if fmu is None:
        from fmus.package import native_contents, python_contents, subject_of
        from fmus.preset import Preset

        chosen = _platforms(kind, wanted)
        preset = Preset(period, values or {}, origin)
        subject = subject_of(module, preset, clock)
        cache = cache_folder() / "libraries"
        if kind == "native":
            contents = native_contents(subject, fmi, chosen, cache)
        else:
            contents = python_contents(subject, module, chosen, cache)
        fmu = _keep(contents, f"{subject.model.name}.fmu", place)
    if folder is None:
        return fmu
    return _copy(fmu, folder)


def build_made(
    name: str,
    contents: Callable[[Sequence[str], Path], Mapping[str, bytes]],
    told: object,
    *,
    fmi: "Fmi" = 2,
    platforms: Sequence[str] | None = None,
    folder: Path | None = None,
) -> Path:
    """Return the native FMU of what is no model module, from the cache if it is there.

    ``told`` is all that decides what is in it; ``contents(platforms, libraries)``
    returns its files by archive name.  The rest is as for ``build``.

    Raises:
        BuildError, OSError: as ``build``.
    """
    _check_options("native", fmi, None)
    wanted = None if platforms is None else _named(platforms)
    here = (host.system(), host.machine())
    key = _key({}, "native", fmi, told, here if wanted is None else wanted)
    place = cache_folder() / "fmus" / f"{name}-native{fmi}-{key}"
    fmu = _kept(place)
    if fmu is None:
        found = contents(_platforms("native", wanted), cache_folder() / "libraries")
        fmu = _keep(found, f"{name}.fmu", place)
    return fmu if folder is None else _copy(fmu, folder)


def _kept(place: Path) -> Path | None:
    """Return the FMU of a place in the cache, None if there is none that is whole."""
    for fmu in entry(place).values():
        if not is_trusted(fmu):
            trust(fmu)
        return fmu
    return None


def build_c(
    module: str,
    *,
    folder: Path,
    real: "Real" = "double",
    period: Fraction | None = None,
    values: Mapping[str, "Value"] | None = None,
    origin: str = "",
) -> Path:
    """Write a sampled model as plain C into a folder of its name; return that.

    Raises:
        BuildError: as ``build``, or the model is continuous.
        OSError: the files cannot be written.
    """
    from fmus.bare_c import REALS, bare_c
    from fmus.compile import CompileError
    from fmus.package import subject_of
    from fmus.preset import Preset

    if real not in REALS:
        raise BuildError(f"real = {real!r}: choose from {', '.join(REALS)}")
    subject = subject_of(module, Preset(period, values or {}, origin))
    try:
        files = bare_c(subject, real, cache_folder() / "libraries")
    except CompileError as error:
        raise BuildError(str(error)) from None
    target = folder / subject.model.name
    target.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (target / name).write_text(text, encoding="utf-8", newline="\n")
    return target


def _copy(fmu: Path, folder: Path) -> Path:
    """Copy an FMU into a folder, whole or not at all."""
    target = folder / fmu.name
    folder.mkdir(parents=True, exist_ok=True)
    partial = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        shutil.copyfile(fmu, partial)
        partial.replace(target)
    except OSError as error:  # which would name the source
        raise OSError(error.errno, error.strerror, str(target)) from None
    finally:
        partial.unlink(missing_ok=True)
    return target


def _check_options(kind: FmuKind, fmi: int, period: Fraction | None) -> None:
    if kind not in get_args(FmuKind):
        raise BuildError(f"there is no kind {kind!r} of FMU: choose native or python")
    if fmi not in (2, 3):
        raise BuildError(f"FMI {fmi} is not written here: choose 2 or 3")
    if kind == "python" and fmi != 2:
        raise BuildError("Python FMUs are FMI 2 only: ask for that or for a native one")
    if period is not None and period <= 0:
        raise BuildError(f"a period of {period} s is not positive")


def _named(platforms: Sequence[str]) -> tuple[str, ...]:
    from fmus.compile import platforms_named

    return tuple(sorted({ours for name in platforms for ours in platforms_named(name)}))


def _platforms(kind: FmuKind, wanted: tuple[str, ...] | None) -> tuple[str, ...]:
    """Return the platforms to build for; an unknown one is refused."""
    if kind == "native":
        from fmus.compile import PLATFORMS, CompileError, host_platform

        known = tuple(PLATFORMS)
    else:
        from fmus.python_fmu import PYTHON_PLATFORMS

        known = PYTHON_PLATFORMS
    if wanted is None and kind == "python":
        return known
    if wanted is None:
        try:
            return (host_platform(),)
        except CompileError as error:
            raise BuildError(str(error)) from None
    unknown = [name for name in wanted if name not in known]
    if unknown or not wanted:
        raise BuildError(
            f"a {kind} FMU cannot be built for {', '.join(unknown) or 'no platform'}: "
            f"choose from {', '.join(known)}"
        )
    return wanted


_version = cache(version)


def _key(files: Mapping[str, Path], kind: FmuKind, *options: Any) -> str:
    """Return a fingerprint of everything an FMU is made from."""
    try:
        tools = [f"{tool} {_version(tool)}" for tool in TOOLS[kind]]
    except PackageNotFoundError as error:
        raise BuildError(
            f"{error.name} is needed to build a {kind} FMU and is not installed: "
            f"pip install 'feeddrive-cosim[build]'"
        ) from None
    own = {
        str(file.relative_to(PACKAGE)): file
        for file in PACKAGE.rglob("*")
        if file.suffix in (".py", ".c", ".h")
    }
    of_model = files_digest(files, data_files(files))
    text = f"{of_model} {files_digest(own)} {kind} {tools} {options}"
    return sha256(text.encode()).hexdigest()[:16]


def _keep(contents: Mapping[str, bytes], name: str, place: Path) -> Path:
    """Write the archive into the cache in one go; another process may be first."""
    from fmus.archive import write_archive

    with building(place.parent) as workspace:
        try:
            write_archive(workspace / name, contents)
            trust(workspace / name)
        except OSError as error:  # which need not name a file
            raise OSError(error.errno, error.strerror, str(place / name)) from None
        publish([workspace / name], place)
    return place / name
