"""A composition as one FMU in tools of others: the rows of ``run``, bit for bit."""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from effort import EFFORT
from numpy.typing import NDArray
from third_party import fmus_in
from wholes import CIRCLE, THREE_RATES

from fmus.subject import Fmi
from orchestrator.exchange.whole.export import export_whole
from orchestrator.master.simulate import plan, simulate
from orchestrator.peers import environment
from orchestrator.peers.second_opinion import peer_job
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run, run_earlier
from orchestrator.system import Component, System

PAIR = """
stop = "1/5"
[components.one]
fmu = "MassSpringSubSystem1"
step = "1/1000"
[components.two]
fmu = "MassSpringSubSystem2"
step = "1/1000"
[connections]
"one.x2" = "two.x2"
"two.x1" = "one.x1"
[record]
"one.x1" = true
"two.x2" = true
"""
SPLIT = "ball_screw_pole_placement/p_pi_split_track_500"
CASES: dict[str, tuple[str, Sequence[str], Fraction]] = {
    "split at 20 kHz": (SPLIT, ["stop=1/20"], Fraction(1, 20_000)),
    "position at 4 kHz": (
        SPLIT,
        ["stop=1/20", "position.step=1/4000"],
        Fraction(1, 20_000),
    ),
    "20, 4 and 1 kHz": (
        SPLIT,
        ["stop=1/20", "position.step=1/4000", "trajectory.step=1/1000"],
        Fraction(1, 20_000),
    ),
    "gantry": ("gantry/mimo_split_diagonal_200", ["stop=1"], Fraction(1, 15_000)),
    "three rates": (THREE_RATES, [], Fraction(1, 12_000)),
    "initial circle": (CIRCLE, [], Fraction(1, 10)),
    "OpenModelica's pair": (PAIR, [], Fraction(1, 1000)),
}
SAMPLE = ("position at 4 kHz", "initial circle", "OpenModelica's pair")


@pytest.fixture(scope="module", params=["fmpy", "ecospy", "libcosimpy", "fmucontainer"])
def tool(request: pytest.FixtureRequest) -> environment.Peer:
    """A tool that is installed, or can be."""
    peer = environment.PEERS[request.param]
    try:
        environment.install(peer)
    except environment.PeerError as error:
        pytest.skip(str(error))
    return peer


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("case", CASES)
def test_other_tools_show_the_rows_of_the_run(
    tool: environment.Peer, case: str, fmi: Fmi, tmp_path: Path
) -> None:
    if tool.name == "libcosimpy" and fmi == 3:
        pytest.skip("libcosim reads FMI 1 and 2")
    if not EFFORT.every and case not in SAMPLE:
        pytest.skip("--every-form has every composition")
    given, sets, step = CASES[case]
    if "\n" in given:
        if "MassSpring" in given:
            for name, file in fmus_in("gemseo-fmu==3.1.1", "linux", tmp_path).items():
                given = given.replace(f'"{name}"', f'"{file}"')
        (tmp_path / "scenario.toml").write_text(given)
        given = str(tmp_path / "scenario.toml")
    scenario = load_scenario(given, sets)
    done = run(scenario, tmp_path / "run", report=False)
    composition = compose(scenario, run_earlier)
    # Ecos dies of any clock it reads about
    made = export_whole(composition, tmp_path / "whole.fmu", fmi=fmi, clock=False)
    whole = {"whole": Component("whole", made, step)}
    record = {f"whole.{name}": (step,) for name in done}
    given = System("whole", composition.system.stop, whole, {}, record)
    if tool.name == "libcosimpy" and 10**9 * step % 1:
        with pytest.raises(environment.PeerError, match="no whole number of nanosec"):
            shown(tool, given, tmp_path)
        return
    rows, names = shown(tool, given, tmp_path)
    instants = np.round(rows[:, 0] / float(step)).astype(int)
    compared = 0
    for values, name in zip(rows.T[1:], names, strict=True):
        signal = done[name]
        at = np.round(np.asarray(signal.time) / float(step)).astype(int)
        _, ours, theirs = np.intersect1d(at, instants, return_indices=True)
        expected = np.asarray(signal.values)[ours]
        np.testing.assert_array_equal(values[theirs], expected, err_msg=name)
        compared += len(ours)
    assert compared >= len(names) * 10


def shown(
    tool: environment.Peer, given: System, folder: Path
) -> tuple[NDArray[np.float64], list[str]]:
    """Return a tool's time and rows of the one FMU, and the names of the columns."""
    job = {**peer_job(plan(given).wiring), "folder": str(folder)}
    rows = environment.carry_out(tool, job)
    names = [name for _, name, *_ in job["signals"]]
    if tool.name != "fmucontainer":
        return rows, names
    (step,) = {c.period for c in given.components.values()}  # it has made another FMU
    container = {"it": Component("it", folder / "container.fmu", step)}
    record = {f"it.seen.whole.{name}": (step,) for name in names}
    found = simulate(System("it", given.stop, container, {}, record), folder / "it")
    columns = [found[name] for name in record]
    return np.array([columns[0].time, *(c.values for c in columns)]).T, names
