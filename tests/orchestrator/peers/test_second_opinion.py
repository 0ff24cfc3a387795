"""Other tools get our trajectories from our FMUs, one sample late where they add it."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from systems import MODELS
from typer.testing import CliRunner, Result

from orchestrator.cli import app
from orchestrator.cli import second_opinion as command
from orchestrator.errors import ScenarioError
from orchestrator.peers import environment
from orchestrator.peers import second_opinion as opinions
from orchestrator.scenario.reading import Scenario, load_scenario, scenario_from

SPLIT = "ball_screw_pole_placement/p_pi_split_track_500"
OTHERS = ["ecospy", "libcosimpy", "fmucontainer"]
LATE = {"trajectory", "encoder", "position", "velocity", "inversion"}


@pytest.fixture(params=["fmpy", *OTHERS])
def tool(request: pytest.FixtureRequest) -> str:
    """A tool that is installed, or can be."""
    name: str = request.param
    try:
        environment.install(environment.PEERS[name])
    except environment.PeerError as error:
        pytest.skip(str(error))
    return name


def two_counters(
    latency: int = 0, b: Mapping[str, Any] | None = None, **other: Any
) -> Scenario:
    """A counter read by another one."""
    counter = {"fmu": str(MODELS / "counter.py"), "step": "1/1000"}
    tables = {
        "stop": "1/100",
        "components": {
            "a": {**counter, "latency": latency},
            "b": {**counter, **(b or {})},
        },
        "connections": {"b.u": "a.k"},
        "record": {"b.seen": True},
        **other,
    }
    return scenario_from(tables, Path("two_counters.toml"))


def test_a_tool_gives_our_trajectories_with_its_own_sample_of_delay(tool: str) -> None:
    scenario = load_scenario(SPLIT, ["stop=0.05"])
    found = opinions.second_opinion(scenario, [tool])
    (peer,) = found.peers
    assert peer.refusal == ""
    assert set(found.added) == LATE
    assert peer.rows == found.rows - (tool == "libcosimpy")  # has no row at 0
    assert {s.signal for s in peer.signals} >= {"plant.x_2", "filters.u"}
    # libcosim hands over steps that differ in their last bits, as its times do
    allowed = 1e-10 if tool == "libcosimpy" else 0.0
    for signal in peer.signals:
        assert signal.label_offset == 0
        assert signal.difference <= allowed * signal.largest, signal
        assert signal.as_written > 1e-4 * signal.largest, signal


def test_a_reader_sees_the_sample_before_in_a_tool(tool: str) -> None:
    ours = opinions.second_opinion(two_counters(latency=1), [tool])
    late = opinions.second_opinion(two_counters(), [tool])
    assert (ours.added, late.added) == (("b",), ("a", "b"))
    for found in (ours, late):
        (peer,) = found.peers
        assert peer.refusal == ""
        assert [s.difference for s in peer.signals] == [0.0, 0.0]
    seen = {s.signal: s.as_written for s in late.peers[0].signals}
    assert seen == {"a.k": 1.0, "b.seen": 2.0}  # counts: a sample is 1


def test_a_conversion_is_done_where_the_tool_can_and_told_where_it_cannot(
    tool: str,
) -> None:
    other = {"name": "u", "gain": -2.0, "offset": 0.5}
    scenario = two_counters(b={"map": {"w": other}}, connections={"b.w": "a.k"})
    (peer,) = opinions.second_opinion(scenario, [tool]).peers
    if tool in ("libcosimpy", "fmucontainer"):
        assert "b.u needs a conversion of units" in peer.refusal
    else:
        assert [s.difference for s in peer.signals] == [0.0, 0.0]


def test_labels_that_are_a_sample_late_are_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    honest = opinions.carry_out

    def late(peer: environment.Peer, job: Mapping[str, Any]) -> NDArray[np.float64]:
        table = honest(peer, job)
        table[:, 0] += job["step"]
        return table

    monkeypatch.setattr(opinions, "carry_out", late)
    (peer,) = opinions.second_opinion(two_counters(), ["fmpy"]).peers
    assert [(s.label_offset, s.difference) for s in peer.signals] == [(1, 0.0)] * 2


def test_a_tool_that_crashes_or_is_not_there_is_told_apart(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    crashing = tmp_path / "python"
    crashing.write_text("#!/bin/sh\nkill -SEGV $$\n")
    crashing.chmod(0o755)
    monkeypatch.setenv("FEEDDRIVE_PEER_ECOSPY", str(crashing))
    monkeypatch.setenv("FEEDDRIVE_PEER_LIBCOSIMPY", str(tmp_path / "none"))
    found = opinions.second_opinion(two_counters(), ["ecospy", "libcosimpy", "fmpy"])
    refusals = {peer.peer: peer.refusal for peer in found.peers}
    assert "crashed (SIGSEGV)" in refusals["ecospy"]
    assert "no such Python" in refusals["libcosimpy"]
    assert refusals["fmpy"] == ""


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stop": "1/3000"}, "multiple of 1/1000 s"),
        ({"latency": 2}, "latency of more than one sample"),
    ],
)
def test_what_the_tools_cannot_do_is_refused(
    changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ScenarioError, match=message):
        opinions.second_opinion(two_counters(**changes), ["fmpy"])


def test_the_command_prints_one_column_per_tool() -> None:
    arguments = ["second-opinion", SPLIT, "--set", "stop=0.01", "--tool", "fmpy"]
    printed = CliRunner().invoke(app, arguments)
    assert printed.exit_code == 0, printed.output
    assert "act one sample later" in printed.output
    as_json = json.loads(CliRunner().invoke(app, [*arguments, "--json"]).stdout)
    assert as_json["peers"][0]["signals"][0]["label_offset"] == 0


def test_three_tools_that_agree_against_us_are_believed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def apart(by: Mapping[str, float]) -> Result:
        def carried(peer: environment.Peer, job: Mapping[str, Any]) -> NDArray[Any]:
            k = np.arange(job["count"] + 1)
            # a.k, which the others hear a sample late, and b.seen
            columns = k * job["step"], np.maximum(k - 1.0, 0), np.maximum(k - 2.0, 0)
            table = np.array(columns).T
            table[5:, 2] += by.get(peer.name, 0.0)
            return table

        monkeypatch.setattr(opinions, "carry_out", carried)
        monkeypatch.setattr(opinions, "version", lambda *_: "0")
        monkeypatch.setattr(opinions, "python_of", lambda _: Path("python"))
        monkeypatch.setattr(command, "load", lambda *_: two_counters())
        tools = [part for name in by for part in ("--tool", name)]
        return CliRunner().invoke(app, ["second-opinion", "two", *tools])

    three = ("fmpy", "ecospy", "libcosimpy")
    assert apart(dict.fromkeys(three, 0.0)).exit_code == 0
    assert apart(dict.fromkeys(three[:2], 0.5)).exit_code == 0  # two are too few
    assert apart(dict(zip(three, (0.5, 1.0, 2.0), strict=True))).exit_code == 0
    found = apart(dict.fromkeys(three, 0.5))
    assert found.exit_code == 1
    assert "b.seen: fmpy, ecospy, libcosimpy agree against this run" in found.stderr


def test_a_tool_nobody_knows_is_refused_by_name() -> None:
    result = CliRunner().invoke(app, ["second-opinion", SPLIT, "--tool", "fmpi"])
    assert result.exit_code == 2
    assert "did you mean 'fmpy'" in " ".join(result.output.split())
