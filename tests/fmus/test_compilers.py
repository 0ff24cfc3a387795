"""Other people's compilers take the sources, in C and as C++, with all warnings."""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from modules import MODULES
from subject import subject
from tools import needed

from fmus.native_source import ALL, adapter_sources, native_sources, source_names

STRICT = ["-Wall", "-Wextra", "-pedantic-errors", "-Werror", "-Wvla"]
ZIG = [sys.executable, "-m", "ziglang", "cc"]
COMPILERS = {
    "gcc": ["gcc", "-std=c99", *STRICT],
    "clang": ["clang", "-std=c99", *STRICT],
    "g++": ["g++", "-x", "c++", *STRICT],
    "clang++": ["clang++", "-x", "c++", *STRICT],
    "zig for Windows": [*ZIG, "-target", "x86_64-windows-gnu", "-Wgnu", *STRICT],
}
VARIANTS = {
    "as it is": [],
    "optimised": ["-O2", "-ffp-contract=fast"],
    "no heap": ["-DFEEDDRIVE_INSTANCES=3"],
    "prefixes": ["-DFMI2_FUNCTION_PREFIX=two_", "-DFMI3_FUNCTION_PREFIX=three_"],
}
# one with dead time, one with functions that C libraries name alike
REPRESENTATIVES = ("plants.xy_table.axis", "controllers.gantry.double_lead")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "model" in metafunc.fixturenames:
        everything = metafunc.config.getoption("--every-form")
        metafunc.parametrize("model", MODULES if everything else REPRESENTATIVES)


def write(model: str, folder: Path) -> None:
    s = subject(model)
    generated = native_sources(s.model, s.traced, s.layout, s.model.name, "token")
    for name, text in (adapter_sources() | generated).items():
        (folder / name).write_text(text)


def compiles(command: Sequence[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not done.stderr


@pytest.mark.parametrize("compiler", COMPILERS)
def test_compilers_find_nothing_to_complain_about(compiler, model, tmp_path):
    command = COMPILERS[compiler]
    needed(command[0])
    write(model, tmp_path)
    for flags in VARIANTS.values():
        compiles([*command, *flags, "-c", ALL, "-o", "all.o"], tmp_path)


@pytest.mark.parametrize("compiler", ["gcc", "g++"])
def test_files_can_be_compiled_one_by_one(compiler, tmp_path):
    needed(compiler)
    write("plants.xy_table.axis", tmp_path)
    files = {file.name: "" for file in tmp_path.iterdir()}
    for name in source_names(files):
        command = [*COMPILERS[compiler], "-c", name, "-o", "one.o"]
        compiles(command, tmp_path)


HOST = """
#include "component.h"
#include <stdio.h>
int main(void) {
    Component *c[4];
    int i, k;
    for (i = 0; i < 4; i++)
        c[i] = component_new("one", feeddrive_model.token, 0, 0, 0, 0, 0);
    if (!c[0] || !c[1] || !c[2] || c[3])
        return 1;
    component_move(c[1], "", INSTANTIATED, INITIALIZING);
    component_exit_initialization(c[1], "");
    for (k = 0; k < 1000; k++)
        if (component_step(c[1], "", k * 1e-4, 1e-4) != STATUS_OK)
            return 2;
    component_free(c[0]);
    return !component_new("again", feeddrive_model.token, 0, 0, 0, 0, 0);
}
"""


def test_a_pool_of_three_has_three_places_and_never_calls_the_heap(tmp_path):
    needed("gcc", "nm")
    write("plants.xy_table.axis", tmp_path)
    (tmp_path / "host.c").write_text(f'#include "{ALL}"\n{HOST}')
    flags = ["-DFEEDDRIVE_INSTANCES=3", "-fsanitize=undefined", "-g"]
    command = ["gcc", "-std=c99", *flags, "host.c", "-o", "host", "-lm"]
    compiles(command, tmp_path)
    subprocess.run([tmp_path / "host"], check=True)
    compiles(["gcc", *COMPILERS["gcc"][1:], flags[0], "-c", ALL], tmp_path)
    names = subprocess.run(
        ["nm", "-u", tmp_path / "all.o"], check=True, capture_output=True, text=True
    ).stdout.split()
    assert not {"malloc", "calloc", "realloc", "free"} & set(names)
