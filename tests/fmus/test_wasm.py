"""The module in an FMU for WebAssembly is an FMU, with the bits of the native one."""

import json
import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from tools import needed

from fmus.build import build
from orchestrator.fmu.description import read_fmu

DRIVE = "plants.ball_screw.drive"
STEPPED = Path(__file__).parents[1] / "support" / "fmi3.mjs"
H = 1 / 20_000


def test_the_module_steps_with_the_bits_of_the_native_fmu(
    slave: Callable, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    if not request.config.getoption("--every-form"):
        pytest.skip("--every-form compiles the C library for WASI")
    needed("node")
    file = build(DRIVE, fmi=3, platforms=["wasm32"])
    with zipfile.ZipFile(file) as archive:
        (binary,) = [n for n in archive.namelist() if n.startswith("binaries/")]
        assert binary == "binaries/wasm32-wasip1/BallScrewDrive.wasm"
        (tmp_path / "module.wasm").write_bytes(archive.read(binary))
    variables = read_fmu(file).variables
    switch = variables["friction.on"].reference
    names = ["x_1", "x_2"]
    inputs = [2 * np.sin(0.05 * k) for k in range(400)]
    job = {
        "token": fmpy.read_model_description(str(file)).instantiationToken,
        "input": variables["u"].reference,
        "outputs": [variables[name].reference for name in names],
        "start": [[switch, 1]],
        "inputs": inputs,
        "h": H,
    }
    command = ["node", str(STEPPED), str(tmp_path / "module.wasm"), json.dumps(job)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    there = np.array(json.loads(done.stdout))

    native = slave(build(DRIVE))
    references = native.references
    native.setBoolean([references["friction.on"]], [True])
    native.setupExperiment(startTime=0.0)
    native.enterInitializationMode()
    native.exitInitializationMode()
    rows = []
    for k, u in enumerate(inputs):
        native.setReal([references["u"]], [u])
        native.doStep(k * H, H)
        rows.append(native.getReal([references[name] for name in names]))
    assert np.ptp(there, axis=0).min() > 0
    assert np.array(rows).tobytes() == there.tobytes()
