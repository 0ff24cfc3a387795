"""The verb ``doctor``: does this installation have what it needs, tried and told."""

import ctypes
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from time import perf_counter
from typing import Annotated, NamedTuple

import typer

from orchestrator.cli.output import command, print_json, print_table, waiting

ANSWER = 42
SOURCE = f"""
#ifdef _WIN32
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
int answer(void) {{ return {ANSWER}; }}
"""


class Finding(NamedTuple):
    """What was tried, how it went, what was found; ``needed``: nothing runs without."""

    what: str
    well: bool
    found: str
    needed: bool = True

    @property
    def state(self) -> str:
        if self.well:
            return "ok"
        return "FAILS" if self.needed else "not there"


@command
def doctor(
    json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Try what feeddrive needs: compiler, kernel, cache, pictures, other tools."""
    with waiting("trying"):
        found = [*_tried()]
    if json:
        told = [{**one._asdict(), "state": one.state} for one in found]
        print_json({"healthy": _healthy(found), "findings": told})
    else:
        rows = [[one.what, one.state, one.found] for one in found]
        print_table(["what", "state", "found"], rows)
    if not _healthy(found):
        raise typer.Exit(1)


def _healthy(found: list[Finding]) -> bool:
    return all(one.well or not one.needed for one in found)


def _tried() -> Iterator[Finding]:
    from orchestrator.scenario.lock import versions

    told = versions()
    yield Finding("python", sys.version_info >= (3, 11), told.pop("python"))
    yield Finding("packages", True, ", ".join(f"{k} {v}" for k, v in told.items()))
    yield _trial("platform", _platform)
    yield _trial("compiler", _compiler)
    yield _trial("kernel", _kernel)
    yield _trial("cache", _cache)
    yield _trial("pictures", _pictures)
    yield from _peers()


def _trial(what: str, attempt: Callable[[], str]) -> Finding:
    try:
        return Finding(what, True, attempt())
    except Exception as error:  # whatever is wrong here is what is looked for
        return Finding(what, False, f"{type(error).__name__}: {error}")


def _platform() -> str:
    from fmus.compile import host_platform

    return f"{host_platform()}, for which FMUs are built unless --platform says others"


def _compiler() -> str:
    from fmus.compile import compile_alone, compiler_version, host_platform

    begun = perf_counter()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        built = compile_alone("s", {"s.c": SOURCE}, host_platform(), Path(folder))
        answered = ctypes.CDLL(str(built)).answer()
    if answered != ANSWER:
        raise RuntimeError(f"what it compiled answers {answered}, not {ANSWER}")
    return f"zig {compiler_version()}, a library in {perf_counter() - begun:.2f} s"


def _kernel() -> str:
    from orchestrator.native.library import library

    begun = perf_counter()
    library()
    return f"compiled or from the cache, loaded in {perf_counter() - begun:.2f} s"


def _cache() -> str:
    from fmus.cache import building, cache_folder

    folder = cache_folder()
    with building(folder) as trial:
        (trial / "written").write_bytes(b"x")
    sizes = []
    for place, _, names in os.walk(folder):
        for name in names:
            with suppress(FileNotFoundError):  # other processes build meanwhile
                sizes.append((Path(place) / name).stat().st_size)
    size = sum(sizes) / 1e6
    return f"{folder}: {len(sizes):,} files, {size:,.0f} MB, can be written"


def _pictures() -> str:
    from orchestrator.pictures.layered import laid_out

    graph = {"id": "root", "children": [{"id": "a", "width": 10, "height": 10}]}
    begun = perf_counter()
    laid_out(graph)
    return f"layouts by ELK, {perf_counter() - begun:.2f} s"


def _peers() -> Iterator[Finding]:
    from orchestrator.peers.environment import PEERS, PeerError, python_of, version

    for peer in PEERS.values():
        what = f"peer {peer.name}"
        try:
            python = python_of(peer)
        except PeerError as error:
            yield Finding(what, False, str(error), needed=False)
        else:
            yield Finding(what, True, f"{version(peer, python)} in {python}", False)
