"""Compile native FMUs for six platforms with one compiler, the ziglang wheel.

The adapters are compiled once per platform and kept in a cache; per FMU only
the generated file is compiled and linked to them.  The same sources give the
same bytes, wherever they are built.
"""

import hashlib
import os
import platform as host
import shutil
import struct
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import MappingProxyType

from fmus.cache import building, cache_folder, entry, publish
from fmus.native_source import adapter_sources, source_names

FLAGS = (
    "-mcpu=baseline",
    "-O2",
    "-ffp-contract=off",
    "-fno-sanitize=undefined",
    "-g0",
    "-std=c99",
    "-fvisibility=hidden",
    "-Wall",
    "-Wextra",
    "-Werror",
)


class CompileError(Exception):
    """The C compiler is missing or refused a source."""


@dataclass(frozen=True)
class Platform:
    """Where a binary runs, what zig calls that, and where FMI puts it.

    ``compiled`` and ``linked`` are flags besides ``FLAGS``.
    """

    name: str
    triple: str
    fmi2_folder: str
    fmi3_folder: str
    suffix: str
    compiled: tuple[str, ...] = ("-fPIC",)
    linked: tuple[str, ...] = ("-shared",)


PLATFORMS: Mapping[str, Platform] = MappingProxyType(
    {
        p.name: p
        for p in (
            Platform(
                "linux-x86_64",
                "x86_64-linux-gnu.2.17",
                "linux64",
                "x86_64-linux",
                ".so",
            ),
            Platform(
                "linux-aarch64",
                "aarch64-linux-gnu.2.17",
                "aarch64-linux",
                "aarch64-linux",
                ".so",
            ),
            Platform(
                "windows-x86_64",
                "x86_64-windows-gnu",
                "win64",
                "x86_64-windows",
                ".dll",
            ),
            Platform(
                "macos-x86_64",
                "x86_64-macos.10.13",
                "darwin64",
                "x86_64-darwin",
                ".dylib",
            ),
            Platform(
                "macos-arm64",
                "aarch64-macos.11.0",
                "darwin64",
                "aarch64-darwin",
                ".dylib",
            ),
            # a core module, no component: docs/decisions/0045
            Platform(
                "wasm32",
                "wasm32-wasi",
                "wasm32-wasip1",
                "wasm32-wasip1",
                ".wasm",
                (),
                ("-mexec-model=reactor", "-Wl,--export-dynamic"),
            ),
        )
    }
)
# for C alone that a page in a browser carries out: no library, no system, no FMU
WEB = Platform(
    "web",
    "wasm32-freestanding",
    "",
    "",
    ".wasm",
    (),
    ("-Wl,--no-entry", "-Wl,--export-dynamic"),
)


def platforms_named(name: str) -> tuple[str, ...]:
    """Return our names of a platform written as ours or as FMI does.

    ``win64`` and ``x86_64-windows`` are ``windows-x86_64``, ``darwin64`` both for
    macOS; a name that is neither is returned as it is.
    """
    if name in PLATFORMS:
        return (name,)
    found = (p for p in PLATFORMS.values() if name in (p.fmi2_folder, p.fmi3_folder))
    return tuple(p.name for p in found) or (name,)


def host_platform() -> str:
    """Return the name of the platform this program runs on.

    Raises:
        CompileError: it is none of ``PLATFORMS``.
    """
    system = {"Darwin": "macos"}.get(host.system(), host.system().lower())
    machine = host.machine().lower()
    machine = {"amd64": "x86_64"}.get(machine, machine)
    if system == "linux" and machine == "arm64":
        machine = "aarch64"
    name = f"{system}-{machine}"
    if name not in PLATFORMS:
        raise CompileError(f"{name}: no FMUs for this platform; there are {_known()}")
    return name


def compile_library(
    identifier: str,
    generated: Mapping[str, str],
    platform: str,
    cache: Path,
    adapters: Mapping[str, str] | None = None,
    libraries: Sequence[str] = (),
) -> Path:
    """Compile a model's generated sources and link them to the adapters.

    ``adapters`` are those of an FMU built before, ours of today by default;
    ``libraries`` are those of the system that are linked as well, except on Windows.
    Returns ``<cache>/<digest>/<identifier><suffix>``, made now or found there.

    Raises:
        CompileError: unknown platform, or the compiler is missing or fails.
    """
    target = _target(platform)
    name = identifier + target.suffix
    adapters = adapter_sources() if adapters is None else adapters
    digest = _digest(target, {**adapters, **generated}, identifier)
    place = cache / digest
    if found := entry(place):
        return found[name]
    objects = _adapters(target, adapters, cache)
    headers = {name: text for name, text in adapters.items() if name[-2:] == ".h"}
    with building(cache) as folder:
        _write(folder, {**headers, **generated})
        for file in objects:
            shutil.copyfile(file, folder / file.name)
        inputs = source_names(generated) + [file.name for file in objects]
        linked = ["-lm"]
        if target.suffix != ".dll":
            linked += [f"-l{system}" for system in libraries]
        made = ["-s", *target.linked, "-o", name]
        _zig_cc(target, [*made, *inputs, *linked], folder)
        publish([folder / name], place)
    return place / name


def compile_alone(
    name: str,
    sources: Mapping[str, str],
    platform: str | Platform,
    cache: Path,
    libraries: Sequence[str] = (),
    flags: Sequence[str] = (),
) -> Path:
    """Compile C sources that need no adapters into a shared library.

    ``libraries`` are those of the system it is linked to, such as "dl"; ``flags``
    follow ours and are those of the compiler.

    Returns ``<cache>/<digest>/<name><suffix>``, made now or found there.

    Raises:
        CompileError: unknown platform, or the compiler is missing or fails.
    """
    target = _target(platform)
    file = name + target.suffix
    linked = [f"-l{system}" for system in libraries]
    place = cache / _digest(target, sources, name, *linked, *flags)
    if not entry(place):
        with building(cache) as folder:
            _write(folder, sources)
            inputs = source_names(sources) + linked
            made = [*flags, "-s", *target.linked, "-o", file]
            _zig_cc(target, [*made, *inputs], folder)
            publish([folder / file], place)
    return place / file


def _adapters(target: Platform, sources: Mapping[str, str], cache: Path) -> list[Path]:
    """Return the object files of the adapters, compiled now or found."""
    ready = cache / _digest(target, sources, "adapters")
    names = [f"{Path(name).stem}.o" for name in source_names(sources)]
    if not entry(ready):
        with building(cache) as folder:
            _write(folder, sources)
            # One call each: zig keeps only the first object of several.
            for name, source in zip(names, source_names(sources), strict=True):
                _zig_cc(target, ["-c", source, "-o", name], folder)
            publish([folder / name for name in names], ready)
    return [ready / name for name in names]


def _target(platform: str | Platform) -> Platform:
    if isinstance(platform, Platform):
        return platform
    try:
        return PLATFORMS[platform]
    except KeyError:
        message = f"{platform}: no such platform; there are {_known()}"
        raise CompileError(message) from None


def _known() -> str:
    return ", ".join(PLATFORMS)


def _digest(target: Platform, sources: Mapping[str, str], *more: str) -> str:
    flags = [*FLAGS, *target.compiled, *target.linked]
    parts = [target.triple, *flags, compiler_version(), *more]
    parts += [part for item in sorted(sources.items()) for part in item]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]


def compiler_version() -> str:
    """Return the version of the ziglang wheel.

    Raises:
        CompileError: it is not installed.
    """
    try:
        return version("ziglang")
    except PackageNotFoundError:
        raise CompileError(
            "the C compiler is missing: pip install 'feeddrive-cosim[build]'"
        ) from None


def _write(folder: Path, sources: Mapping[str, str]) -> None:
    for name, text in sources.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")


def _zig_cc(target: Platform, arguments: Sequence[str], folder: Path) -> None:
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target.triple]
    command += [*FLAGS, *target.compiled, *arguments]
    environment = dict(os.environ)
    if "HOME" not in environment:  # where zig would keep what all builds share
        environment.setdefault("ZIG_GLOBAL_CACHE_DIR", str(cache_folder() / "zig"))
    done = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        errors="replace",
        env=environment,
    )
    if done.returncode == 0:
        return
    tail = "\n".join(done.stderr.strip().splitlines()[-20:])
    raise CompileError(
        f"compiling for {target.name} failed:\n  {' '.join(command)}\n{tail}\n"
        "If the model was traced, this is a defect of feeddrive; if the compiler "
        "itself is damaged: pip install --force-reinstall ziglang"
    )


def universal_binary(slices: Mapping[str, bytes]) -> bytes:
    """Join Mach-O files of both Mac architectures into one that serves both.

    ``slices`` maps "macos-x86_64" and "macos-arm64" to files; FMI 2 has one
    folder, darwin64, for the two.  Format: Apple, mach-o/fat.h.
    """
    cpu = {"macos-x86_64": (0x01000007, 3), "macos-arm64": (0x0100000C, 0)}
    align = 14  # 16 KiB, the page of arm64
    header = struct.pack(">II", 0xCAFEBABE, len(slices))
    position, body = 1 << align, b""
    for name, data in slices.items():
        entry = (*cpu[name], position + len(body), len(data), align)
        header += struct.pack(">5I", *entry)
        body += data + bytes(-len(data) % (1 << align))
    return header.ljust(position, b"\0") + body
