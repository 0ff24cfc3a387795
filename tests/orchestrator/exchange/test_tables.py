"""What is exported is what was recorded, bit for bit, as other tools lay it out."""

import csv
import struct
from fractions import Fraction
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import loadmat
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.exchange.tables import export
from orchestrator.result import Result
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

SCENARIO = """
stop = "0.01"
[components.tone]
fmu = "controllers.references.sine"
step = "20 kHz"
[record]
"tone.x_r" = ["20 kHz", "1 kHz"]
"tone.v_r" = "1 kHz"
"""
SLOW = Fraction(1, 1000)


@pytest.fixture(scope="module")
def tone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tone")
    (folder / "tone.toml").write_text(SCENARIO)
    return run(load_scenario(folder / "tone.toml"), folder / "run", report=False).folder


def test_csv_reads_back_to_the_same_bits(tone: Path, tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r'2 rates.*--at "1/20000" or "1/1000"'):
        export(tone, tmp_path / "x.csv")
    with export(tone, tmp_path / "x.csv", SLOW).open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["time [s]", "tone.x_r [m]", "tone.v_r [m/s]"]
    columns = np.array(rows, dtype=float).T
    slow = Result(tone).at(SLOW)
    assert columns[0].tolist() == slow["tone.x_r"].time.tolist()
    for column, name in zip(columns[1:], ("tone.x_r", "tone.v_r"), strict=True):
        assert column.tolist() == slow[name].values.tolist()


def test_mat_is_a_trajectory_file_of_level_4(tone: Path, tmp_path: Path) -> None:
    file = export(tone, tmp_path / "x.mat")
    types = dict(matrices(file.read_bytes()))
    assert types == {  # 51: letters as bytes, 20: 32-bit integers, 0: doubles
        "Aclass": 51, "name": 51, "description": 51, "dataInfo": 20,
        "data_1": 0, "data_2": 0, "data_3": 0,
    }  # fmt: skip
    found = loadmat(file, chars_as_strings=False)
    assert ["".join(row).strip() for row in found["Aclass"]] == [
        "Atrajectory", "1.1", "", "binTrans",
    ]  # fmt: skip
    names = ["".join(column).strip() for column in found["name"].T]
    assert names == ["time", "tone.x_r", "tone.v_r"]
    told = ["".join(column).strip() for column in found["description"].T]
    assert told == ["[s]", "[m]", "[m/s]"]
    assert found["dataInfo"].T.tolist() == [[0, 1, 0, -1], [2, 2, 0, -1], [3, 2, 0, -1]]
    assert found["data_1"].tolist() == [[0, 0.01]]
    result = Result(tone)
    for block, name in ((2, "tone.x_r"), (3, "tone.v_r")):
        time, values = found[f"data_{block}"]
        assert time.tolist() == result[name].time.tolist()
        assert values.tolist() == result[name].values.tolist()


def matrices(content: bytes):
    """Yield name and type of the matrices of a MAT file of level 4."""
    size = {0: 8, 2: 4, 5: 1}
    place = 0
    while place < len(content):
        kind, rows, columns, _, length = struct.unpack_from("<5i", content, place)
        name = content[place + 20 : place + 19 + length].decode()
        yield name, kind
        place += 20 + length + rows * columns * size[kind // 10 % 10]


def test_hdf5_has_a_group_per_rate_with_units(tone: Path, tmp_path: Path) -> None:
    result = Result(tone)
    with h5py.File(export(tone, tmp_path / "x.h5")) as file:
        assert set(file) == {"every_1_20000_s", "every_1_1000_s"}
        fast = file["every_1_20000_s/tone.x_r"]
        assert fast[:].tolist() == result["tone.x_r"].values.tolist()
        assert (fast.attrs["unit"], fast.attrs["published"]) == ("m", "0 1/20000")
        assert (
            file["every_1_1000_s/time"][:].tolist() == result["tone.v_r"].time.tolist()
        )
        assert "tone.x_r" not in file["every_1_1000_s"]


def test_the_verb_takes_folders_and_names_and_refuses_in_words(
    tone: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "300")
    (tmp_path / "runs/tone").mkdir(parents=True)
    tone.rename(tmp_path / "runs/tone/1")
    for name in ("runs/tone/1", "tone/1", "1"):
        said = exported(name, "-o", "x.csv", "--at", "1 kHz")
        assert said.stdout.startswith("written to x.csv: ")
    for arguments, reason in (
        (("1", "-o", "x.txt"), "ends in one of .csv, .mat, .h5"),
        (("1", "-o", "x.csv", "--at", "3 kHz"), "has no rows at 333.333 us (3 kHz)"),
        (("1", "-o", "x.csv", "--at", "fast"), "--at: 'fast' is not a time"),
        (("7", "-o", "x.csv"), "there is no run '7'"),
    ):
        refused = exported(*arguments)
        assert refused.exit_code == 2
        assert reason in refused.stderr
    (tmp_path / "runs/tone/1").rename(tone)


def exported(*arguments: str):
    return CliRunner().invoke(app, ["export", *arguments])
