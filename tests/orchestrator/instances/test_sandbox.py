"""What an FMU in a sandbox may do, what it is denied, and that this is said."""

import os
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hostile import hostile_fmu
from systems import part, system

from orchestrator.errors import SimulationError
from orchestrator.instances import possible, sandbox
from orchestrator.master.simulate import simulate
from orchestrator.scenario.reading import scenario_from
from orchestrator.system import Component, Isolation, System
from orchestrator.warned import collecting

MS = Fraction(1, 1000)
SANDBOX = Isolation(True, 30.0, sandbox=True)
MAY_WRITE_ITS_OWN, MAY_START_THREADS = 1 << 8, 1 << 9
only_where_there_is_one = pytest.mark.skipif(
    bool(sandbox.why_not()), reason=sandbox.why_not()
)


def alone(how: str, folder: Path, isolation: Isolation = SANDBOX) -> System:
    bad = Component("bad", hostile_fmu(how, folder), MS, isolation=isolation)
    return system("1/200", [bad], {}, {"bad.y": "1/1000"})


@only_where_there_is_one
def test_what_an_fmu_tries_is_denied_and_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outside = tmp_path / "outside"
    outside.write_text("secret")
    monkeypatch.setenv("HOSTILE_FILE", str(outside))
    with collecting() as warnings:
        result = simulate(alone("escapes", tmp_path), tmp_path / "run")
    (said,) = warnings
    assert said.startswith("bad (hostile2.fmu): Its sandbox denied ")
    denied = [
        f"open {outside} to read",
        f"open {outside} to write",
        "socket",
        "fork",
        "execve /bin/true",
        "kill",
        "chmod",
        f"rename {outside}",
        "ptrace",
    ]
    for one in denied:
        assert one in said
    assert result["bad.y"].values[3] == MAY_WRITE_ITS_OWN | MAY_START_THREADS
    assert len(result["bad.y"]) == 6
    assert outside.read_text() == "secret"


@only_where_there_is_one
def test_a_sandboxed_fmu_gives_the_bits_of_the_others(tmp_path: Path) -> None:
    parts = [part("a", "counter", "1/1000"), part("b", "counter", "1/1000")]
    given = system("1/100", parts, {"b.u": "a.k"}, {"b.seen": "1/1000"})
    inside = {**given.components, "b": replace(parts[1], isolation=SANDBOX)}
    here = simulate(given, tmp_path / "here")["b.seen"].values
    with collecting() as warnings:
        apart = simulate(replace(given, components=inside), tmp_path / "apart")
    np.testing.assert_array_equal(apart["b.seen"].values, here)
    assert warnings == []


@only_where_there_is_one
def test_a_crash_in_a_sandbox_ends_the_run_by_name(tmp_path: Path) -> None:
    with pytest.raises(SimulationError, match=r"bad .*SIGSEGV.* during doStep"):
        simulate(alone("crash", tmp_path), tmp_path / "run")


def test_where_the_kernel_has_none_it_is_refused_in_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(possible, "why_not", lambda: "this kernel has no Landlock")
    said = r'bad .*isolation = "sandbox": this kernel has no Landlock; run it elsewhere'
    with pytest.raises(SimulationError, match=said):
        simulate(alone("well", tmp_path), tmp_path / "run")


def test_a_scenario_asks_for_it() -> None:
    one = {"fmu": "x.fmu", "step": "1/1000", "isolation": "sandbox"}
    tables = {"stop": "1", "components": {"a": one}}
    read = scenario_from(tables, Path(os.devnull))
    assert read.spec.components["a"].isolation == "sandbox"
