"""A composition as one FMU walks through the same bits on every platform."""

import zipfile
from fractions import Fraction
from pathlib import Path

import fmpy
import pytest
from effort import EFFORT
from walking import RUNNERS, place_of, walks
from wholes import THREE_RATES

from fmus.compile import PLATFORMS, host_platform
from fmus.subject import Fmi
from orchestrator.exchange.whole.export import export_whole
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import find_scenario, load_scenario
from orchestrator.session import run_earlier

pytestmark = pytest.mark.skipif(
    host_platform() != "linux-x86_64", reason="emulates the others from there"
)


def line(file: Path, platform: str, step: Fraction, folder: Path) -> str:
    """Return what walk_host.c reads of an FMU on a platform."""
    about = fmpy.read_model_description(str(file))
    fmi = int(about.fmiVersion[0])
    names = PLATFORMS[platform]
    place = names.fmi2_folder if fmi == 2 else names.fmi3_folder
    with zipfile.ZipFile(file) as archive:
        (member,) = [
            m for m in archive.namelist() if m.startswith(f"binaries/{place}/")
        ]
        library = Path(archive.extract(member, folder / f"{fmi}-{platform}"))
    causes = {v.valueReference: v.causality for v in about.modelVariables}
    outputs = [str(r) for r, cause in causes.items() if cause == "output"]
    group = " ".join([str(len(outputs)), *(f"{r} 1" for r in outputs)])
    token = about.guid if fmi == 2 else about.instantiationToken
    return (
        f"{place_of(library, platform)} {token} {fmi}cs {float(step)!r} 1 0 0 {group}"
    )


@pytest.mark.parametrize(
    "name", ["three rates", "ball_screw_pole_placement/mc_ppc_track_500"]
)
def test_an_arm_and_windows_give_the_bits(name: str, tmp_path: Path) -> None:
    if name != "three rates" and not EFFORT.every:
        pytest.skip("--every-form tries a published one")
    file, step = tmp_path / "scenario.toml", Fraction(1, 12000)
    if name == "three rates":
        file.write_text(THREE_RATES)
    else:
        file, step = find_scenario(name), Fraction(1, 20000)
    composition = compose(load_scenario(file), run_earlier)
    versions: tuple[Fmi, ...] = 2, 3
    made = [
        export_whole(
            composition, tmp_path / f"{fmi}.fmu", platforms=list(RUNNERS), fmi=fmi
        )
        for fmi in versions
    ]
    found = {
        platform: walks(
            platform,
            {"whole": [line(file, platform, step, tmp_path) for file in made]},
            tmp_path,
        )
        for platform in RUNNERS
    }
    native = found.pop("linux-x86_64")
    assert native["whole"][0].last != 0
    assert [found[platform] for platform in found] == [native] * len(found)
