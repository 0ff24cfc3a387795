"""Rows are not begun where they cannot be ended."""

import shutil
from collections import namedtuple
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from systems import part, system

from orchestrator.errors import SimulationError
from orchestrator.master.recorder import Recorder
from orchestrator.master.simulate import plan, simulate

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


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_rows_that_cannot_be_ended_do_not_mask_what_ended_the_run(
    tmp_path: Path,
) -> None:
    counted = system("1", [part("a", "counter", "1/1000")], {}, {"a.k": "1/1000"})
    tables = plan(counted).wiring.tables
    recorder = Recorder(tmp_path, tables, np.zeros(8))
    (table,) = recorder.tables.values()
    table._file.close()
    table._file = Path("/dev/full").open("wb")  # noqa: SIM115 - closed by the recorder
    table._stream = pyarrow.ipc.new_stream(table._file, table._schema)
    table.row(0.0)
    recorder.close(complete=False)
    assert table._file.closed
