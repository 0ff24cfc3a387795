"""An FMU runs in this process if it was built here, whatever it says of itself."""

import shutil
import subprocess
import sys
import tomllib
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import tomli_w
from broken import MISBEHAVES, MODES, pack
from systems import system

from fmus.build import build
from fmus.cache import digest
from fmus.trust import is_trusted
from orchestrator.errors import SimulationError
from orchestrator.fmu.description import read_fmu
from orchestrator.instances.instance import LocalInstance
from orchestrator.master.simulate import open_instance, simulate
from orchestrator.result import Result
from orchestrator.scenario.lock import LOCK
from orchestrator.session import run
from orchestrator.system import Component

PI = Path(__file__).parents[2] / "fmus" / "small_models" / "pi.py"
OURS = (
    '<VendorAnnotations><Tool name="feeddrive"><Model kind="continuous"/></Tool>'
    "</VendorAnnotations><ModelVariables>"
)


def is_local(fmu: Path) -> bool:
    with ExitStack() as stack:
        return isinstance(open_instance("it", read_fmu(fmu), stack), LocalInstance)


def test_a_forged_fmu_cannot_end_the_process_of_the_run(tmp_path: Path) -> None:
    text = MISBEHAVES.replace("<ModelVariables>", OURS)
    forged = pack("misbehaves", text, tmp_path)
    assert read_fmu(forged).kind == "continuous"
    assert not is_trusted(forged)
    parameters = {"mode": MODES.index("exit"), "at": 0.005}
    bad = Component("bad", forged, Fraction("1/1000"), parameters=parameters)
    with pytest.raises(SimulationError, match=r"bad.*ended with exit code 7"):
        simulate(system("1/100", [bad], record={"bad.y": "1/1000"}), tmp_path)


def test_a_strangers_lock_with_its_digest_makes_no_fmu_trusted(tmp_path: Path) -> None:
    """All that a stranger can write says that the FMU is ours and is the one locked."""
    here, stranger = tmp_path / "here", tmp_path / "stranger"
    here.mkdir()
    scenario = {"stop": "1/100", "components": {"bad": {"fmu": str(PI)}}}
    file = tmp_path / "s.toml"
    scenario["record"] = {"bad.u": True}
    file.write_text(tomli_w.dumps(scenario))
    run(file, stranger, report=False)
    forged = pack("misbehaves", MISBEHAVES.replace("<ModelVariables>", OURS), tmp_path)
    shutil.copyfile(forged, stranger / "fmus" / "bad.fmu")
    lock = tomllib.loads((stranger / LOCK).read_text())
    lock["lock"]["digests"]["bad"] = digest(forged)
    how = {"mode": MODES.index("exit"), "at": 0.005}
    lock["components"]["bad"]["parameters"] = how
    lock["components"]["bad"]["start"] = {}
    lock["components"]["bad"]["kind"] = "continuous"
    lock["record"] = {"bad.y": "1/1000"}
    (stranger / LOCK).write_text(tomli_w.dumps(lock))
    command = [sys.executable, "-m", "orchestrator", "run", str(stranger / LOCK)]
    done = subprocess.run(
        command, cwd=here, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1, done.stderr
    said = " ".join(done.stderr.split())
    assert "bad (bad.fmu): its process ended with exit code 7 during doStep" in said


def test_what_was_built_here_is_known_under_any_name(tmp_path: Path) -> None:
    copy = tmp_path / "renamed.fmu"
    shutil.copyfile(build(str(PI)), copy)
    assert is_trusted(copy)
    assert is_local(copy)
    with copy.open("ab") as file:
        file.write(b"\0")
    assert not is_trusted(copy)


def rows(fmu: Path, folder: Path) -> Result:
    pi = Component("pi", fmu, Fraction(1, 2000), start={"r": 1.0})
    record = {"pi.u": "1/2000"}
    return simulate(system("1/20", [pi], record=record), folder)


def test_ours_of_another_machine_gives_the_same_rows_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = build(str(PI), period=Fraction(1, 2000))
    ours = rows(here, tmp_path / "ours")
    monkeypatch.setattr("fmus.trust._folder", lambda: tmp_path / "other machine")
    assert not is_local(here)
    assert read_fmu(here).kind == "sampled"
    theirs = rows(here, tmp_path / "theirs")
    assert np.ptp(np.array(ours["pi.u"])) > 0
    np.testing.assert_array_equal(np.array(ours["pi.u"]), np.array(theirs["pi.u"]))


def test_an_fmu_damaged_in_the_cache_is_built_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("FEEDDRIVE_CACHE", str(tmp_path))
    fmu = build(str(PI))
    whole = fmu.read_bytes()
    for damage in (whole[:-100], b"", whole[:5000] + b"\0" * 10 + whole[5010:]):
        fmu.write_bytes(damage)
        assert not is_trusted(fmu)
        assert build(str(PI)).read_bytes() == whole
        assert "is damaged in the cache, so it is made anew" in caplog.text
        caplog.clear()
