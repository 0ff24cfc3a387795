"""What stands in front of pythonfmu refuses with a message what it would crash on."""

import ctypes
import os
import subprocess
from pathlib import Path
from zipfile import ZipFile

import fmpy
import pytest
from callbacks import collecting
from fmpy import read_model_description
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions

from fmus.build import build
from fmus.compile import host_platform

pytestmark = pytest.mark.skipif(
    host_platform() != "linux-x86_64",
    reason="pythonfmu has no binary for this platform that is tried here",
)
MODEL_EXCHANGE, CO_SIMULATION = 0, 1


class Unpacked:
    """A Python FMU in a folder, instantiated by the bare call of FMI."""

    def __init__(self, folder: Path) -> None:
        fmu = build("plants.ball_screw.encoder", kind="python")
        fmpy.extract(str(fmu), str(folder))
        description = read_model_description(str(folder))
        self.guid = description.guid
        self.uri = (folder / "resources").as_uri()
        self.slave = FMU2Slave(
            guid=self.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="unused",
        )
        self.said: list[str] = []
        self.callbacks = collecting(self.said)

    def instantiate(self, **changed: object) -> int | None:
        call = {
            "name": "one",
            "kind": CO_SIMULATION,
            "token": self.guid,
            "uri": self.uri,
        } | changed
        name, token, uri = (
            None if call[key] is None else str(call[key]).encode()
            for key in ("name", "token", "uri")
        )
        callbacks = ctypes.byref(self.callbacks)
        return self.slave.fmi2Instantiate(
            name, call["kind"], token, uri, callbacks, 0, 1
        )


@pytest.fixture
def unpacked(tmp_path: Path) -> Unpacked:
    return Unpacked(tmp_path / "unpacked")


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"token": "{not-this-one}"}, "token"),
        ({"token": None}, "token"),
        ({"name": ""}, "needs a name"),
        ({"name": None}, "needs a name"),
        ({"kind": MODEL_EXCHANGE}, "no model exchange"),
        ({"uri": None}, "fmuResourceLocation"),
        ({"uri": "/tmp/a/path"}, "fmuResourceLocation"),
        ({"uri": "file://elsewhere/resources"}, "fmuResourceLocation"),
        ({"uri": "file:///no/such/folder"}, "slavemodule.txt"),
        ({"uri": "file:///100%25%"}, "slavemodule.txt"),
    ],
)
def test_a_wrong_argument_gives_no_instance_and_a_message(
    unpacked: Unpacked, wrong: dict[str, object], said: str
) -> None:
    assert unpacked.instantiate(**wrong) is None
    [message] = unpacked.said
    assert said in message


@pytest.mark.parametrize(
    "name", ["plain", "two words", "Prüfstand é", "日本", "100%", "50%25", "a%41b"]
)
@pytest.mark.parametrize("form", ["file://{}", "file:{}", "file://localhost{}"])
def test_it_runs_from_every_folder(tmp_path: Path, name: str, form: str) -> None:
    unpacked = Unpacked(tmp_path / name)
    unpacked.uri = form.format(unpacked.uri.removeprefix("file://"))
    instance = unpacked.instantiate()
    assert instance, unpacked.said
    unpacked.slave.fmi2FreeInstance(instance)


def test_a_folder_that_pythonfmu_would_misread_is_refused(tmp_path: Path) -> None:
    unpacked = Unpacked(tmp_path / "a%20b")
    assert unpacked.instantiate() is None
    assert "%20" in unpacked.said[0].replace("%%", "%")


def test_an_importer_need_not_give_callbacks(unpacked: Unpacked) -> None:
    for callbacks in (fmi2CallbackFunctions(), None):
        slave = unpacked.slave
        texts = (text.encode() for text in ("one", unpacked.guid, unpacked.uri))
        name, token, uri = texts
        given = None if callbacks is None else ctypes.byref(callbacks)
        one = slave.fmi2Instantiate(name, CO_SIMULATION, token, uri, given, 0, 1)
        assert one
        slave.fmi2FreeInstance(one)


def test_a_host_without_python_is_told_so(
    host_program: Path, unpacked: Unpacked
) -> None:
    library = next((Path(unpacked.slave.unzipDirectory) / "binaries").rglob("Enc*.so"))
    done = subprocess.run(
        [host_program, library, unpacked.guid, "churn", "1"],
        env={**os.environ, "RESOURCES": unpacked.uri},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1  # no signal
    assert "needs a host that runs Python" in done.stderr
    assert "undefined symbol: _Py" in done.stderr


def test_every_platform_holds_both_libraries() -> None:
    with ZipFile(build("plants.ball_screw.encoder", kind="python")) as archive:
        held = {n for n in archive.namelist() if n.startswith("binaries/")}
        gates = {n: archive.read(n) for n in held if "/Encoder." in n}
    assert held == {
        "binaries/linux64/Encoder.so",
        "binaries/linux64/libpythonfmu-export.so",
        "binaries/win64/Encoder.dll",
        "binaries/win64/pythonfmu-export.dll",
    }
    for gate in gates.values():
        assert b"fmi2Instantiate\0" in gate
        assert b"fmi2GetStringStatus\0" in gate
