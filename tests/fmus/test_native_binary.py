"""The compiled library: what it exports and needs, and hosts without Python."""

import re
import subprocess
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tools import needed

from fmus import compile as compiler
from fmus.compile import (
    PLATFORMS,
    CompileError,
    compile_library,
    host_platform,
    universal_binary,
)
from fmus.native_source import adapter_sources, source_names

TOKEN = "token-100%"
linux_only = pytest.mark.skipif(
    not host_platform().startswith("linux"), reason="reads an ELF file"
)


def run(program: Path, *arguments: Any) -> str:
    command = [str(program), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, env={})
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_host_without_python_gets_the_same_numbers(
    compiled: Callable, host_program: Path
) -> None:
    built = compiled("pi")
    places = built.layout
    references = [places[name].reference for name in ("r", "u", "state.q")]
    text = run(host_program, built.library, TOKEN, "steps", 100, 1, 20_000, *references)
    rows = [[float(number) for number in line.split()] for line in text.splitlines()]
    it = built.new().begin()
    T_s = 1 / 20_000
    for k, row in enumerate(rows):
        it.set("r", k)
        it.step(k / 20_000, T_s)
        assert row == [it.get("u"), it.get("state.q")]
    assert len(rows) == 100


NOISE = ("exact", "sum", "jitter", "difference", "less", "more")
COUNTED = ("nanoseconds", "long", "short")  # by the clock they would drift


@pytest.mark.parametrize("noise", [*NOISE, *COUNTED, "half"])
@pytest.mark.parametrize("name", ["pi", "third"])
def test_no_tick_is_lost_or_doubled_in_ten_million_steps(
    compiled: Callable, host_program: Path, name: str, noise: str
) -> None:
    built = compiled(name)
    n = 10_000_000
    period: Fraction = built.model.period
    reference = built.layout["state.k"].reference
    step = (period.numerator, period.denominator)
    ticks = run(
        host_program, built.library, TOKEN, "count", n, *step, noise, reference, 1, 1
    )
    assert int(ticks) == n


@pytest.mark.parametrize("noise", ["exact", "sum", "difference", "jitter"])
def test_continuous_steps_always_take_the_same_number_of_substeps(
    compiled: Callable, host_program: Path, noise: str
) -> None:
    built = compiled("counter")
    reference = built.layout["state.x"].reference
    arguments = (1_000_000, 1, 20_000, noise, reference)
    last = run(host_program, built.library, TOKEN, "count", *arguments, 5, 5)
    assert int(last) == 5_000_001


@linux_only
@pytest.mark.parametrize("name", ["shaft", "late"])
def test_memory_stays_flat(compiled: Callable, host_program: Path, name: str) -> None:
    growth = run(host_program, compiled(name).library, TOKEN, "churn", 10_000)
    assert int(growth) <= 32  # a leak of 16 bytes each would be 36 pages


def declared_functions() -> set[str]:
    text = "".join(adapter_sources()[f"fmi{v}Functions.h"] for v in (2, 3))
    return set(re.findall(r"FMI[23]_Export fmi\w+TYPE\s+(\w+);", text))


@linux_only
def test_every_function_of_both_standards_is_exported_and_nothing_else(
    compiled: Callable,
) -> None:
    text = subprocess.run(
        ["readelf", "--dyn-syms", "-W", compiled("pi").library],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    exported = {
        fields[7]
        for fields in map(str.split, text.splitlines())
        if len(fields) == 8 and fields[6].isdigit()
    }
    assert len(declared_functions()) > 100
    assert exported == declared_functions()


@linux_only
@pytest.mark.parametrize("name", ["shaft", "pi", "late"])
def test_only_libc_and_libm_are_needed(compiled: Callable, name: str) -> None:
    text = subprocess.run(
        ["readelf", "-d", "-V", "-W", compiled(name).library],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    needed = set(re.findall(r"\(NEEDED\).*\[(.*)\]", text))
    assert needed <= {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}
    versions = {
        tuple(map(int, v.split("."))) for v in re.findall(r"GLIBC_([\d.]+)", text)
    }
    assert max(versions) <= (2, 17)


def test_other_folders_give_the_same_bytes(compiled: Callable, tmp_path: Path) -> None:
    generated = compiled("shaft").generated
    made = [
        compile_library("Shaft", generated, host_platform(), tmp_path / folder)
        for folder in ("here", "some other place/with spaces")
    ]
    one, other = (path.read_bytes() for path in made)
    assert one == other == compiled("shaft").library.read_bytes()
    assert str(tmp_path).encode() not in one
    assert str(Path.cwd()).encode() not in one


def test_a_second_build_is_taken_from_the_cache(
    compiled: Callable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    generated = compiled("pi").generated
    first = compile_library("Pi", generated, host_platform(), tmp_path)
    monkeypatch.setattr(compiler, "_zig_cc", None)
    assert compile_library("Pi", generated, host_platform(), tmp_path) == first
    assert not list(tmp_path.glob(".building-*"))


def test_builders_at_the_same_time_do_not_disturb_each_other(
    compiled: Callable, tmp_path: Path
) -> None:
    names = ["pi", "pi", "shaft", "pi"]

    def build(name: str) -> bytes:
        built = compiled(name)
        identifier = built.model.name
        path = compile_library(identifier, built.generated, host_platform(), tmp_path)
        return path.read_bytes()

    expected = [compiled(name).library.read_bytes() for name in names]
    with ThreadPoolExecutor(len(names)) as pool:
        assert list(pool.map(build, names)) == expected
    assert not list(tmp_path.glob(".building-*"))


HEADERS = {
    "linux-x86_64": (b"\x7fELF", 18, b"\x3e\x00"),
    "linux-aarch64": (b"\x7fELF", 18, b"\xb7\x00"),
    "macos-x86_64": (b"\xcf\xfa\xed\xfe", 4, b"\x07\x00\x00\x01"),
    "macos-arm64": (b"\xcf\xfa\xed\xfe", 4, b"\x0c\x00\x00\x01"),
}


@pytest.mark.parametrize("platform", HEADERS)
def test_each_platform_gets_its_own_binary(
    compiled: Callable, tmp_path: Path, platform: str
) -> None:
    magic, offset, machine = HEADERS[platform]
    library = compile_library("Pi", compiled("pi").generated, platform, tmp_path)
    data = library.read_bytes()
    assert library.suffix == PLATFORMS[platform].suffix
    assert data.startswith(magic)
    assert data[offset : offset + 2] == machine[:2]
    assert b"fmi3DoStep" in data


def test_one_file_serves_both_macs() -> None:
    slices = {"macos-x86_64": b"intel" * 1000, "macos-arm64": b"apple" * 4000}
    data = universal_binary(slices)
    words = np.frombuffer(data[:48], dtype=">u4")
    assert words[0] == 0xCAFEBABE
    assert words[1] == 2
    for entry, part in zip(words[2:12].reshape(2, 5), slices.values(), strict=True):
        offset, size = entry[2:4]
        assert offset % 2 ** entry[4] == 0
        assert data[offset : offset + size] == part


def test_an_unknown_platform_is_named(tmp_path: Path) -> None:
    with pytest.raises(CompileError, match="amiga: no such platform; there are linux"):
        compile_library("Pi", {}, "amiga", tmp_path)


def test_a_refused_source_shows_command_and_complaint(
    tmp_path: Path,
) -> None:
    with pytest.raises(CompileError) as caught:
        compile_library("Pi", {"model_data.c": "int f( {"}, host_platform(), tmp_path)
    message = str(caught.value)
    assert "ziglang cc -target" in message
    assert "error: expected" in message
    assert "pip install" in message


def test_a_missing_compiler_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(name: str) -> str:
        raise compiler.PackageNotFoundError(name)

    monkeypatch.setattr(compiler, "version", missing)
    with pytest.raises(CompileError, match="pip install 'feeddrive"):
        compile_library("Pi", {}, host_platform(), tmp_path)


@pytest.mark.parametrize("standard", ["FMI2", "FMI3"])
def test_two_models_can_be_linked_into_one_program(
    compiled: Callable, tmp_path: Path, standard: str
) -> None:
    needed("gcc")
    objects: list[str] = []
    for name in "pi", "shaft":
        folder = tmp_path / name
        folder.mkdir()
        sources = adapter_sources() | compiled(name).generated
        for file, text in sources.items():
            (folder / file).write_text(text)
        prefix = f"-D{standard}_FUNCTION_PREFIX={name}_"
        command = ["gcc", "-std=c99", "-c", prefix, *source_names(sources)]
        subprocess.run(command, cwd=folder, check=True)
        objects += map(str, folder.glob("*.o"))
    (tmp_path / "main.c").write_text("""
        const char *pi_fmi2GetVersion(void), *shaft_fmi3GetVersion(void);
        int main(void) { return pi_fmi2GetVersion() == shaft_fmi3GetVersion(); }
    """)
    command = ["gcc", "main.c", *objects, "-o", "both", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    assert run(tmp_path / "both") == ""
