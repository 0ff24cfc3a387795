"""Every FMU walks through the same bits on every platform, and asks for no memory.

2,000 random steps of each model, by FMI 2 and 3, by co-simulation and (where there
is) model exchange, natively, on an emulated ARM and in Windows as wine has it.
"""

import subprocess
from collections.abc import Sequence

import pytest
from modules import MODULES
from subject import subject
from tools import needed
from walking import HOST, NATIVE, RUNNERS, Walk, place_of, run, walks

from fmus.cache import cache_folder
from fmus.compile import compile_library, host_platform
from fmus.model import Continuous
from fmus.native_source import native_sources

# one of each kind of equation; all with --every-form
REPRESENTATIVES = (
    "controllers.ball_screw.mc_ppc",
    "controllers.leadscrew.gain_stairs",
    "controllers.xy_table.np_pi",
    "plants.ball_screw.drive",
    "plants.leadscrew.axis",
    "plants.xy_table.axis",
)
pytestmark = pytest.mark.skipif(
    host_platform() != "linux-x86_64", reason="emulates the others from there"
)


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
    place = place_of(library, platform)
    lines = [
        f"{place} {token} {v}cs {h!r} {int(not continuous)} {n_x} {rest}" for v in "23"
    ]
    if exchanged:
        lines += [
            f"{place} {token} {v}me {s.model.h_max / 10!r} 0 {n_x} {rest}" for v in "23"
        ]
    return lines


def on(platform: str, modules: Sequence[str]) -> tuple[str, dict[str, list[str]]]:
    return platform, {module: entries(module, platform) for module in modules}


@pytest.fixture(scope="module")
def chosen(request: pytest.FixtureRequest) -> Sequence[str]:
    return MODULES if request.config.getoption("--every-form") else REPRESENTATIVES


@pytest.fixture(scope="module")
def native(chosen, tmp_path_factory) -> dict[str, list[Walk]]:
    return walks(*on("linux-x86_64", chosen), tmp_path_factory.mktemp("native"))


@pytest.mark.parametrize("platform", [p for p in RUNNERS if p != "linux-x86_64"])
def test_other_processors_and_systems_give_the_same_bits(
    platform, chosen, native, tmp_path
):
    other = walks(*on(platform, chosen), tmp_path)
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
    _, lines = on("linux-x86_64", chosen)
    counted = run([str(program)], lines, tmp_path / "list.txt")
    assert counted == native  # whose count is zero, as nobody counted
