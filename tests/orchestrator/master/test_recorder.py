"""Rows are not begun where they cannot be ended."""

import shutil
from collections import namedtuple
from pathlib import Path

import pytest
from systems import part, system

from orchestrator.errors import SimulationError
from orchestrator.master.simulate import simulate

Usage = namedtuple("Usage", "total used free")


def test_rows_that_would_not_fit_on_the_disk_are_refused_before_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted = system("10", [part("a", "counter", "1/1000")], {}, {"a.k": "1/1000"})
    needed = 10_001 * 2 * 8
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(10**9, 0, needed - 1))
    with pytest.raises(SimulationError, match=r"10,001 rows need .* record less"):
        simulate(counted, tmp_path)
    assert not (tmp_path / "result").exists()
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(10**9, 0, needed))
    assert len(simulate(counted, tmp_path)["a.k"].values) == 10_001
