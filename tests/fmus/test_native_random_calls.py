"""Whatever is called in whatever order, nothing outside an instance is touched."""

import ctypes
import shutil
import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from fmus.build import build

MODELS = Path(__file__).parent / "small_models"
CALLS = 100_000
SANITIZED = (
    *("gcc", "-g", "-O1", "-std=c99", "-fsanitize=address,undefined"),
    *("-fno-sanitize-recover=all", "-fno-omit-frame-pointer"),
    *("-DNO_MEMORY", "-Wl,--wrap=malloc,--wrap=calloc"),  # denied now and then
)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
@pytest.mark.parametrize(
    "model", ["pi", "spring_mass", "late"], ids=["sampled", "continuous", "delay"]
)
def test_random_calls_leave_sanitizers_silent(
    tmp_path: Path, model: str, version: int
) -> None:
    with zipfile.ZipFile(build(str(MODELS / f"{model}.py"))) as fmu:
        fmu.extractall(tmp_path)
    sources = [str(file) for file in tmp_path.glob("sources/*.c") if file.stem != "all"]
    program = tmp_path / "random_calls"
    driver = str(Path(__file__).with_name("random_calls.c"))
    command = [*SANITIZED, f"-DFMI={version}", "-I", str(tmp_path / "sources")]
    command += [driver, *sources, "-o", str(program), "-lm"]
    subprocess.run(command, check=True)
    done = subprocess.run(
        [str(program), str(CALLS), "1"], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr[:3000]
    calls, fine = (int(word.split()[0]) for word in done.stdout.split(",")[:2])
    assert calls == CALLS
    assert CALLS / 5 < fine < CALLS  # both the allowed and the refused were tried


@pytest.mark.parametrize("n", [2, 1000])
def test_a_sampled_model_has_no_continuous_states_to_read(
    compiled: Callable, version: int, n: int
) -> None:
    it = compiled("pi").new(version)
    it.enter()
    name = {2: "fmi2GetDerivatives", 3: "fmi3GetContinuousStateDerivatives"}[version]
    values = (ctypes.c_double * n)(*[7.0] * n)
    component = ctypes.c_void_p(it.fmu.component)
    status = getattr(it.fmu.dll, name)(component, values, ctypes.c_size_t(n))
    assert status == 3
    assert f"Pi has 0 continuous states, not {n}" in it.log[-1]
    assert set(values) == {7.0}


def test_arrays_that_are_missing_are_refused(compiled: Callable, version: int) -> None:
    it = compiled("pi").new(version).begin()
    reference = (ctypes.c_uint32 * 1)(it.layout["r"].reference)
    value, c = (ctypes.c_double * 1)(), it.fmu.component
    calls: list[tuple[Any, tuple[Any, ...]]] = []
    if version == 2:
        for name in ("GetReal", "SetReal", "GetBoolean", "SetBoolean"):
            call = getattr(it.fmu, f"fmi2{name}")
            calls += [(call, (c, None, 1, None)), (call, (c, reference, 1, None))]
        calls.append((it.fmu.fmi2GetInteger, (c, None, 1, None)))
    else:
        for name in ("GetFloat64", "SetFloat64"):
            call = getattr(it.fmu, f"fmi3{name}")
            calls += [
                (call, (c, None, 1, value, 1)),
                (call, (c, reference, 1, None, 1)),
            ]
        calls.append((it.fmu.fmi3GetInt32, (c, None, 1, None, 1)))
        calls.append((it.fmu.fmi3GetClock, (c, None, 1, None)))
        calls.append((it.fmu.fmi3GetIntervalDecimal, (c, None, 1, None, None)))
    for call, arguments in calls:
        message = it.refused(lambda c=call, a=arguments: c(*a))
        assert "an array of 1 elements was expected, NULL was given" in message
    it.step(0.0, 1 / 20_000)  # and it goes on


def test_a_written_state_that_is_damaged_is_refused(
    compiled: Callable, version: int
) -> None:
    it = compiled("pi").new(version).begin()
    it.step(0.0, 1 / 20_000)
    data = it.saved()
    for place in (8, 40, 60, len(data) // 2, len(data) - 1):
        damaged = bytearray(data)
        damaged[place] ^= 0x10
        message = it.refused(lambda d=bytes(damaged): it.restore(d))
        assert "this is no state of Pi" in message
    it.restore(data)
