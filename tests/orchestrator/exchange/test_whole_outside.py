"""A loop closed outside of a composition that is one FMU: one sample, or none."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from walking import RUNNERS, Walk, place_of, walks
from wholes import Slave, composed

from fmus.build import build
from fmus.compile import PLATFORMS, host_platform
from orchestrator.exchange.whole.export import export_whole
from orchestrator.fmu.archive import unpacked
from orchestrator.fmu.description import read_fmu
from orchestrator.pytest_plugin import assert_fmu_conforms
from orchestrator.session import run

SMALL = Path(__file__).parents[2] / "fmus" / "small_models"
MODELS = Path(__file__).parents[1] / "models"
PLANT = MODELS / "integrator.py"
T = Fraction(1, 2000)
STEPS = 200
# two rates inside: a reference at 500 Hz, a controller at 2 kHz
INSIDE = f"""
stop = "1/10"
[components.tone]
fmu = "controllers.references.sine"
step = "1/500"
parameters = {{ frequency_hz = 20 }}
map = {{ x_r = {{ name = "x_r", gain = 30, unit = "V" }} }}
[components.pi]
fmu = "{SMALL / "pi.py"}"
step = "1/2000"
[components.pi.map]
r = {{ name = "r", gain = 1, unit = "V" }}
y = {{ name = "y", gain = 1, unit = "1" }}
u = {{ name = "u", gain = 1, unit = "1/s" }}
"""
ALONE = """
[connections]
"pi.r" = "tone.x_r"
[record]
"pi.u" = true
"""
PLANT_OUTSIDE = f"""
[components.plant]
fmu = "{PLANT}"
step = "1/2000"
start = {{ "state.x" = 1.0 }}
"""
LOOP = """
[connections]
"pi.y" = "plant.y"
"plant.u" = "pi.u"
"pi.r" = "tone.x_r"
[record]
"plant.y" = true
"""
HOLD = f"""
[components.hold]
fmu = "{MODELS / "hold.py"}"
step = "1/2000"
latency = 1
"""
LATE = LOOP.replace('"pi.y" = "plant.y"', '"pi.y" = "hold.y"\n"hold.u" = "plant.y"')
ENDS = {"inputs": ["pi.y"], "outputs": ["pi.u"]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """FMUs of the part inside: two.fmu, three.fmu, and plain.fmu without a clock."""
    folder = tmp_path_factory.mktemp("inside")
    (folder / "inside.toml").write_text(INSIDE + ALONE)
    inside = composed(folder / "inside.toml")
    export_whole(inside, folder / "two.fmu", **ENDS)
    export_whole(inside, folder / "three.fmu", fmi=3, **ENDS)
    export_whole(inside, folder / "plain.fmu", fmi=3, clock=False, **ENDS)
    return folder


def rows(folder: Path, text: str) -> dict[str, np.ndarray]:
    (folder / "scenario.toml").write_text(text)
    target = folder / f"run{len(list(folder.iterdir()))}"
    done = run(folder / "scenario.toml", target, report=False)
    return {name: np.array(done[name].values) for name in ("plant.y",)}


@pytest.mark.parametrize("name", ["two", "three", "plain"])
def test_a_loop_closed_outside_is_one_sample_late(
    folder: Path, tmp_path: Path, name: str
) -> None:
    """Any master that steps both and exchanges, and ticks no clock: one sample on the
    way back, no more."""
    late = rows(tmp_path, INSIDE + HOLD + PLANT_OUTSIDE + LATE)["plant.y"]
    inside = Slave(folder / f"{name}.fmu", tmp_path / "inside")
    plant = Slave(build(str(PLANT)), tmp_path / "plant")
    plant.begin(**{"state.x": 1.0})
    inside.begin(**{"pi.y": 1.0})
    found = [1.0]
    for k in range(STEPS):
        plant.set("u", *inside.get("pi.u"))
        inside.set("pi.y", *plant.get("y"))
        plant.step(k, T)
        inside.step(k, T)
        found += plant.get("y")
    np.testing.assert_array_equal(found, late)


def test_by_its_clock_it_is_not_late(folder: Path, tmp_path: Path) -> None:
    exact = rows(tmp_path, INSIDE + PLANT_OUTSIDE + LOOP)["plant.y"]
    outside = f"""
stop = "1/10"
[components.inside]
fmu = "{folder / "three.fmu"}"
step = "1/2000"
[connections]
"inside.pi.y" = "plant.y"
"plant.u" = "inside.pi.u"
[record]
"plant.y" = true
"""
    found = rows(tmp_path, outside + PLANT_OUTSIDE)["plant.y"]
    np.testing.assert_array_equal(found, exact)
    described = read_fmu(folder / "three.fmu")
    assert described.dependencies == {"pi.u": frozenset({"pi.y"})}


def test_without_its_clock_it_says_that_it_is_late(folder: Path) -> None:
    described = read_fmu(folder / "plain.fmu")
    assert not described.clocks
    assert described.clock is None
    told = described["pi.y"].description
    assert told.endswith("(read an outer step late)")
    assert "by the clock" in read_fmu(folder / "three.fmu")["pi.y"].description


def test_the_check_finds_nothing(folder: Path, request: pytest.FixtureRequest) -> None:
    names = ["three.fmu"]
    if request.config.getoption("--every-form"):
        names += ["two.fmu", "plain.fmu"]
    for name in names:
        assert_fmu_conforms(folder / name)


@pytest.mark.skipif(host_platform() != "linux-x86_64", reason="emulates from there")
def test_other_processors_and_systems_give_the_same_bits(
    folder: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    if not request.config.getoption("--every-form"):
        pytest.skip("compiles for all platforms: --every-form")
    whole = tmp_path / "whole.fmu"
    inside = composed(folder / "inside.toml")
    export_whole(inside, whole, **ENDS, platforms=list(PLATFORMS))
    described = read_fmu(whole)
    assert set(described.platforms) == {p.fmi2_folder for p in PLATFORMS.values()}
    ends = " ".join(f"1 {described[n].reference} 1" for n in ("pi.y", "pi.u"))
    found: list[list[Walk]] = []
    with unpacked(whole) as place:
        for platform in RUNNERS:
            kind = PLATFORMS[platform]
            file = f"{described.model_identifier}{kind.suffix}"
            library = place_of(place / "binaries" / kind.fmi2_folder / file, platform)
            head = f"{library} {described.token}"
            lines = [f"{head} {v}cs {float(T)!r} 1 0 {ends} 0.0" for v in "23"]
            found += walks(platform, {"whole": lines}, tmp_path).values()
    assert found == [found[0]] * 3
    assert found[0][0] == found[0][1]
