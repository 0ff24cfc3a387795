"""``check`` finds nothing in our FMUs: both versions, both kinds, both interfaces,
with a clock and without.

All models with ``--every-form``, otherwise one of each sort.
"""

from pathlib import Path
from zipfile import ZipFile

import pytest
from lxml import etree
from modules import EXCHANGED, MODULES
from subject import subject

from fmus.build import build
from orchestrator.checks import Report, check_fmu

REPRESENTATIVES = ("plants.ball_screw.two_mass", "controllers.ball_screw.mc_ppc")
CLOCKED = [m for m in MODULES if not subject(m).continuous]


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Give each test its models."""
    everything = metafunc.config.getoption("--every-form")
    if "module" in metafunc.fixturenames:
        metafunc.parametrize("module", MODULES if everything else REPRESENTATIVES)
    if "clockless" in metafunc.fixturenames:
        metafunc.parametrize(
            "clockless", CLOCKED if everything else ["controllers.ball_screw.mc_ppc"]
        )
    if "exchanged" in metafunc.fixturenames:
        metafunc.parametrize(
            "exchanged", EXCHANGED if everything else ["plants.ball_screw.two_mass"]
        )


def assert_nothing_found(report: Report) -> None:
    assert [f for o in report.outcomes for f in o.findings] == []
    assert [o.reason for o in report.outcomes if o.verdict == "could not be run"] == []
    assert report.clean


@pytest.mark.parametrize("fmi", [2, 3])
def test_native_fmus_pass_every_item(module: str, fmi: int) -> None:
    report = check_fmu(build(module, fmi=fmi))  # type: ignore[arg-type]
    assert_nothing_found(report)
    assert report.counts["pass"] >= 30


def test_fmi_3_without_a_clock_passes_every_item(clockless: str) -> None:
    report = check_fmu(build(clockless, fmi=3, clock=False))
    assert_nothing_found(report)
    assert report.counts["pass"] >= 30


def test_python_fmus_pass_every_item(module: str) -> None:
    assert_nothing_found(check_fmu(build(module, kind="python")))


@pytest.mark.parametrize("fmi", [2, 3])
def test_model_exchange_passes_every_item(
    exchanged: str, fmi: int, tmp_path: Path
) -> None:
    native = build(exchanged, fmi=fmi)  # type: ignore[arg-type]
    report = check_fmu(without_co_simulation(native, tmp_path))
    assert_nothing_found(report)
    tried = {o.item.number: o for o in report.outcomes if o.item.part == "dynamic"}
    assert "model exchange" in tried[8].seen[0]
    assert tried[16].reason == "it has no co-simulation"


def without_co_simulation(fmu: Path, folder: Path) -> Path:
    target = folder / "exchange.fmu"
    with ZipFile(fmu) as old, ZipFile(target, "w") as new:
        for member in old.infolist():
            content = old.read(member)
            if member.filename == "modelDescription.xml":
                root = etree.fromstring(content)
                root.remove(root.find("CoSimulation"))
                content = etree.tostring(root, encoding="UTF-8", xml_declaration=True)
            new.writestr(member, content)
    return target
