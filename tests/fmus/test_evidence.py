"""What an FMU brings along is true in another process and in another tool."""

import csv
import io
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from lxml import etree
from modules import MODULES
from subject import subject

from fmus.build import build
from fmus.evidence import FOLDER

CHECKED = ("plants.ball_screw.drive", "controllers.ball_screw.mc_ppc")
CLOSE = 1e-9  # of the largest value of a column


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "shipped" in metafunc.fixturenames:
        everything = metafunc.config.getoption("--every-form")
        chosen = MODULES if everything else (*CHECKED, "plants.xy_table.axis")
        metafunc.parametrize("shipped", chosen)


def columns(archive: zipfile.ZipFile, name: str) -> dict[str, np.ndarray]:
    head, *rows = csv.reader(io.StringIO(archive.read(f"{FOLDER}/{name}").decode()))
    return dict(zip(head, np.array(rows, dtype=float).T, strict=True))


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmpy_computes_the_response_that_the_fmu_brings(shipped, fmi):
    fmu = build(shipped, fmi=fmi)
    with zipfile.ZipFile(fmu) as archive:
        if f"{FOLDER}/response.csv" not in archive.namelist():
            assert not [
                v for v in subject(shipped).layout.block("output") if not v.shape
            ]
            return
        wanted = columns(archive, "response.csv")
        held = (
            columns(archive, "step.csv")
            if f"{FOLDER}/step.csv" in archive.namelist()
            else {}
        )
        root = etree.fromstring(archive.read(f"{FOLDER}/step.exp"))
    experiment = next(root.iter("Experiment"))
    names = [name for name in held if name != "time"]
    stimuli = np.zeros(2, [("time", float)] + [(name, float) for name in names])
    for name in held:
        stimuli[name] = held[name]
    times = wanted.pop("time")
    result = fmpy.simulate_fmu(
        str(fmu),
        fmi_type="CoSimulation",
        stop_time=float(experiment.get("stopTime")),
        output_interval=float(experiment.get("stepSize")),
        input=stimuli if names else None,
        output=list(wanted),
    )
    assert len(result) == len(times)
    for name, column in wanted.items():
        error = np.max(np.abs(result[name] - column))
        assert error <= CLOSE * np.max(np.abs(column), initial=1e-300)


def test_check_repeats_the_experiment_in_a_process_of_its_own():
    for module in CHECKED:
        for fmi in (2, 3):
            command = [sys.executable, "-m", "orchestrator", "check", "--only", "33"]
            fmu = str(build(module, fmi=fmi))
            done = subprocess.run([*command, "--json", fmu], capture_output=True)
            verdicts = [i["verdict"] for i in json.loads(done.stdout)["items"]]
            assert verdicts == ["pass", "pass"]
            assert done.returncode == 0


def test_icon_pictures_and_terminals_are_there():
    module = "controllers.ball_screw.mc_ppc"
    s = subject(module)
    for fmi, icon in ((2, "model.png"), (3, "terminalsAndIcons/icon.png")):
        with zipfile.ZipFile(
            build("controllers.ball_screw.mc_ppc", fmi=fmi)
        ) as archive:
            assert archive.read(icon).startswith(b"\x89PNG\r\n")
            page = archive.read("documentation/index.html").decode()
            assert page.count("<svg") == 2
            if fmi == 2:
                continue
            told = etree.fromstring(
                archive.read(f"{Path(icon).parent}/terminalsAndIcons.xml")
            )
    members = {
        terminal.get("name"): {m.get("variableName") for m in terminal}
        for terminal in told.iter("Terminal")
    }
    assert members == {
        side: {v.name for v in s.layout.block(block)}
        for side, block in (("inputs", "input"), ("outputs", "output"))
    }
