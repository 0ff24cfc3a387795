"""Every published scenario goes out as SSP and comes back as it was."""

from pathlib import Path

import pytest
from effort import EFFORT

from orchestrator.exchange.ssp.beside import write_beside
from orchestrator.exchange.ssp.load import load_package
from orchestrator.exchange.ssp.write import export_ssp, members
from orchestrator.scenario.compose import compose
from orchestrator.scenario.lock import locked
from orchestrator.scenario.reading import load_scenario, scenarios, studies
from orchestrator.session import run_earlier

SAMPLE = ("ball_screw_pole_placement/p_pi_split_track_500", "gantry/circle_1")


def published() -> list[str]:
    return [f"{study.name}/{name}" for study in studies() for name in scenarios(study)]


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    metafunc.parametrize("name", published() if EFFORT.every else SAMPLE)


def test_it_comes_back_with_its_lock_and_its_bytes(name: str, tmp_path: Path) -> None:
    before = compose(load_scenario(name), run_earlier)
    package = export_ssp(before, tmp_path / "one.ssp")
    after = compose(load_package(package), run_earlier)
    was, now = locked(before), locked(after)
    assert was.pop("lock")["digests"] == now.pop("lock")["digests"]
    assert was == now
    beside = load_scenario(write_beside(package, tmp_path / "beside"))
    again = export_ssp(compose(beside, run_earlier), tmp_path / "two.ssp")
    assert again.read_bytes() == package.read_bytes()
    assert members(compose(beside, run_earlier)) == members(before)
