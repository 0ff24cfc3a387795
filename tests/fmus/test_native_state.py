"""FMU states, reset and instances are exact and independent, bit for bit."""

import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

NAMES = ["shaft", "pi", "mix", "exact", "late"]
H = 5e-5


def drive(it: Any, first: int, last: int) -> list[bytes]:
    """Step with varying inputs; return the whole state after each step."""
    inputs = [v.name for v in it.layout.block("input")]
    states = []
    for k in range(first, last):
        for i, name in enumerate(inputs):
            it.set(name, np.full(it.layout[name].shape, np.sin(k + i)))
        it.step(k * H, H)
        states.append(it.saved())
    return states


@pytest.mark.parametrize("name", NAMES)
def test_a_restored_state_continues_bit_equal(
    compiled: Callable, version: int, name: str
) -> None:
    it = compiled(name).new(version).begin()
    drive(it, 0, 20)
    state = it.fmu.getFMUState()
    first = drive(it, 20, 40)
    it.fmu.setFMUState(state)
    assert drive(it, 20, 40) == first
    it.fmu.setFMUState(state)
    assert drive(it, 20, 40) == first
    it.fmu.freeFMUState(state)


@pytest.mark.parametrize("name", NAMES)
def test_reset_begins_anew_bit_equal(
    compiled: Callable, version: int, name: str
) -> None:
    it = compiled(name).new(version).begin()
    first = drive(it, 0, 30)
    it.fmu.reset()
    it.begin()
    assert drive(it, 0, 30) == first
    it.fmu.terminate()
    it.fmu.reset()
    it.begin()
    assert drive(it, 0, 30) == first


def test_a_state_goes_into_another_process(
    compiled: Callable, version: int, tmp_path: Path
) -> None:
    built = compiled("late")
    u, v = built.layout["u"].reference, built.layout["v"].reference
    it = built.new(version).begin()
    drive(it, 0, 20)
    (tmp_path / "state").write_bytes(it.saved())
    drive(it, 20, 21)
    kind = f"fmpy.fmi{version}.FMU{version}Slave"
    code = f"""
import sys, pathlib, fmpy.fmi2, fmpy.fmi3, numpy as np
it = {kind}(guid="token-100%", modelIdentifier="Late",
            unzipDirectory={str(built.folder)!r}, instanceName="other")
it.instantiate()
it.setFMUState(it.deserializeFMUState(pathlib.Path("state").read_bytes()))
u = np.full(3, np.sin([20, 20, 21])).tolist()
if {version} == 2:
    it.setReal({[u, u + 1, v]}, u)
else:
    it.setFloat64({[u, v]}, u)
it.doStep(20 * {H}, {H})
pathlib.Path("after").write_bytes(it.serializeFMUState(it.getFMUState()))
"""
    environment = {**os.environ, "PYTHONWARNINGS": "ignore"}
    subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=tmp_path, env=environment
    )
    assert (tmp_path / "after").read_bytes() == it.saved()


def test_many_states_can_be_kept(compiled: Callable, version: int) -> None:
    it = compiled("late").new(version).begin()
    states, blobs = [], []
    for k in range(50):
        blobs += drive(it, k, k + 1)
        states.append(it.fmu.getFMUState())
    for state, blob in reversed(list(zip(states, blobs, strict=True))):
        it.fmu.setFMUState(state)
        assert it.saved() == blob
        it.fmu.freeFMUState(state)


def test_instances_do_not_know_of_each_other(compiled: Callable, version: int) -> None:
    built = compiled("shaft")
    alone = drive(built.new(version, "alone").begin(), 0, 30)
    one = built.new(version, "one").begin()
    two = built.new(version, "two")
    two.set("K", 300.0)
    two.begin()
    together = []
    for k in range(30):
        together += drive(one, k, k + 1)
        drive(two, k, k + 1)
    assert together == alone


def test_threads_give_what_one_thread_gives(compiled: Callable, version: int) -> None:
    built = compiled("shaft")

    def run(K: float) -> bytes:
        it = built.new(version, f"K = {K}")
        it.set("K", K)
        it.begin()
        for k in range(2000):
            it.step(k * H, H)
        return bytes(it.saved())

    stiffness = [500.0, 600.0, 700.0, 800.0]
    serial = [run(K) for K in stiffness]
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(run, stiffness)) == serial


@pytest.mark.parametrize(
    "spoil",
    [
        lambda blob: b"",
        lambda blob: blob[:-1],
        lambda blob: blob + b"\0",
        lambda blob: b"X" + blob[1:],
        lambda blob: blob[:8] + b"X" + blob[9:],
    ],
    ids=["empty", "short", "long", "no magic", "other token"],
)
def test_a_foreign_state_is_refused(
    compiled: Callable, version: int, spoil: Callable[[bytes], bytes]
) -> None:
    it = compiled("shaft").new(version).begin()
    blob = it.saved()
    message = it.refused(lambda: it.restore(spoil(blob)))
    assert message.startswith("it: ")
    assert "no state of Shaft" in message
    it.restore(blob)
