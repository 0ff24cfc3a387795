"""Every FMU walks through the same bits on every platform, and asks for no memory.

2,000 random steps of each model, by FMI 2 and 3, by co-simulation and (where there
is) model exchange, natively, on an emulated ARM and in Windows as wine has it.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import pytest
from modules import MODULES
from subject import subject
from tools import needed

from fmus.cache import cache_folder
from fmus.compile import PLATFORMS, compile_library, host_platform
from fmus.model import Continuous
from fmus.native_source import native_sources

HOST = Path(__file__).with_name("walk_host.c")
NATIVE = Path(__file__).parents[2] / "fmus" / "native"
STEPS = 2_000
# one of each kind of equation; all with --every-form
REPRESENTATIVES = (
    "controllers.ball_screw.mc_ppc",
    "controllers.leadscrew.gain_stairs",
    "controllers.xy_table.np_pi",
    "plants.ball_screw.drive",
    "plants.leadscrew.axis",
    "plants.xy_table.axis",
)
RUNNERS = {
    "linux-x86_64": (),
    "linux-aarch64": ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"),
    "windows-x86_64": ("wine64",),
}
pytestmark = pytest.mark.skipif(
    host_platform() != "linux-x86_64", reason="emulates the others from there"
)


class Walk(NamedTuple):
    digest: str
    last: float
    allocations: int


def groups(variables: Sequence) -> str:
    told = [f"{v.reference} {v.size}" for v in variables if not v.boolean]
    return " ".join([str(len(told)), *told])


def entries(module: str, platform: str) -> list[str]:
    """Return the lines of the list for one model: all forms it exists in."""
    s = subject(module)
    token = f"token-of-{s.model.name}"
    generated = native_sources(s.model, s.traced, s.layout, s.model.name, token)
    library = compile_library(
        s.model.name, generated, platform, cache_folder() / "libraries"
    )
    continuous = isinstance(s.model, Continuous)
    exchanged = continuous and not (s.model.advance or s.model.delay)
    inputs = [v for v in s.layout.block("input") if not v.boolean]
    starts = " ".join(repr(x) for v in inputs for x in v.start)
    rest = f"{groups(inputs)} {groups(s.layout.block('output'))} {starts}"
    h = 5 * s.model.h_max if continuous else float(s.model.period)
    n_x = s.layout.count["state"]
    place = f"Z:{library}" if platform.startswith("windows") else str(library)
    lines = [
        f"{place} {token} {v}cs {h!r} {int(not continuous)} {n_x} {rest}" for v in "23"
    ]
    if exchanged:
        lines += [
            f"{place} {token} {v}me {s.model.h_max / 10!r} 0 {n_x} {rest}" for v in "23"
        ]
    return lines


def walks(platform: str, modules: Sequence[str], folder: Path) -> dict[str, list[Walk]]:
    """Return the walks of each model on a platform."""
    *runner, program = *RUNNERS[platform], folder / f"walk_host-{platform}.exe"
    if runner and runner[0] == "wine64" and not shutil.which("wine64"):
        runner[0] = "/usr/lib/wine/wine64"
    needed(*runner[:1])
    command = [sys.executable, "-m", "ziglang", "cc", "-O2", "-std=c99", "-Wall"]
    command += ["-target", PLATFORMS[platform].triple, "-ffp-contract=off"]
    command += [f"-I{NATIVE}", str(HOST), "-o", str(program)]
    subprocess.run(command, check=True)
    lines = {module: entries(module, platform) for module in modules}
    return run([*runner, str(program)], lines, folder / f"{platform}.txt")


def run(
    command: Sequence[str], lines: dict[str, list[str]], list_file: Path
) -> dict[str, list[Walk]]:
    list_file.write_text("\n".join(line for each in lines.values() for line in each))
    wine = Path(command[0]).name.startswith("wine")
    told = f"Z:{list_file}" if wine else str(list_file)
    quiet = os.environ | {
        "WINEDEBUG": "-all",
        "WINEPREFIX": str(list_file.parent / "w"),
    }
    done = subprocess.run(
        [*command, told, str(STEPS)], capture_output=True, text=True, env=quiet
    )
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-500:]
    rows = iter(done.stdout.split("\n"))
    found = {}
    for module, each in lines.items():
        fields = [next(rows).split() for _ in each]
        found[module] = [Walk(a, float(b), int(c)) for a, b, c in fields]
    return found


@pytest.fixture(scope="module")
def chosen(request: pytest.FixtureRequest) -> Sequence[str]:
    return MODULES if request.config.getoption("--every-form") else REPRESENTATIVES


@pytest.fixture(scope="module")
def native(chosen, tmp_path_factory) -> dict[str, list[Walk]]:
    return walks("linux-x86_64", chosen, tmp_path_factory.mktemp("native"))


@pytest.mark.parametrize("platform", [p for p in RUNNERS if p != "linux-x86_64"])
def test_other_processors_and_systems_give_the_same_bits(
    platform, chosen, native, tmp_path
):
    other = walks(platform, chosen, tmp_path)
    differing = [m for m in chosen if other[m] != native[m]]
    assert not differing


def test_both_versions_of_fmi_give_the_same_bits(native):
    for two, three, *exchanged in native.values():
        assert two == three
        assert exchanged[:1] == exchanged[1:]


def test_no_memory_is_asked_for_while_stepping(chosen, native, tmp_path):
    needed("gcc")
    program = tmp_path / "counting"
    flags = ["-O2", "-rdynamic", "-DCOUNT_ALLOCATIONS", "-ffp-contract=off"]
    command = ["gcc", *flags, f"-I{NATIVE}", HOST, "-o", program, "-ldl"]
    subprocess.run(command, check=True)
    lines = {module: entries(module, "linux-x86_64") for module in chosen}
    counted = run([str(program)], lines, tmp_path / "list.txt")
    assert counted == native  # whose count is zero, as nobody counted
