"""The same system in other people's tools, and how far they are from us.

The tools step everything at one rate and exchange only after a step (Jacobi):
there every sampled component acts one sample late.  Our run beside them is
therefore the system with latency 1 on each sampled component, which is what
the difference is taken to; the difference to the scenario as it is written says
what that sample does.  A tool's rows are laid beside ours by its own times,
then shifted by the whole samples at which they agree best: the label offset.
"""

import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ScenarioError
from orchestrator.fmu.description import FmuVariable
from orchestrator.fmu.start_values import Written
from orchestrator.master.groups import only_python
from orchestrator.master.layout import Column, Wiring
from orchestrator.master.simulate import plan, simulate
from orchestrator.peers.agreement import Rows, against
from orchestrator.peers.environment import (
    Peer,
    PeerError,
    carry_out,
    every_peer,
    python_of,
    version,
)
from orchestrator.result import Result
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import Scenario
from orchestrator.session import naming, run_earlier
from orchestrator.system import System

SHIFTS = (0, 1, -1, 2, -2)  # samples, the likeliest first


@dataclass(frozen=True)
class SignalOpinion:
    """One signal: ``largest`` magnitude of ours, ``difference`` in the same order of
    exchange, ``label_offset`` (samples by which the tool's time is late), and
    ``as_written``, the difference to the scenario without the added samples."""

    signal: str
    unit: str
    largest: float
    difference: float
    label_offset: int
    as_written: float


@dataclass(frozen=True)
class PeerOpinion:
    """What one tool made of it: its rows and signals, or why there are none."""

    peer: str
    version: str
    rows: int
    refusal: str
    signals: tuple[SignalOpinion, ...]


@dataclass(frozen=True)
class SecondOpinion:
    """All tools on one scenario; ``added`` names the components that act a sample
    later in them than the scenario says, ``against`` the signals in which at least
    three tools agree with each other and not with us, and those tools."""

    scenario: str
    step: str
    rows: int
    added: tuple[str, ...]
    peers: tuple[PeerOpinion, ...]
    against: Mapping[str, tuple[str, ...]]


def second_opinion(
    scenario: Scenario, peers: Iterable[str] | None = None
) -> SecondOpinion:
    """Run a scenario here and in the tools named, or in all there are.

    Raises:
        ScenarioError: the tools cannot run such a system (several rates, offsets,
            a latency above one sample, arrays).
        FeedDriveError: it does not run here.
    """
    known = every_peer()
    with naming(scenario), tempfile.TemporaryDirectory(prefix="feeddrive-") as kept:
        folder = Path(kept)
        composition = compose(scenario, run_earlier)
        written = _recording(composition.system)
        alike, added = _as_jacobi(written)
        here = simulate(written, folder / "written")
        ours = simulate(alike, folder / "alike")
        job = peer_job(plan(alike).wiring)
        rows = len(next(iter(ours.values())))
        wiring, rows_of = plan(alike).wiring, dict[str, dict[str, Rows]]()
        found = tuple(
            _opinion(known[name], job, wiring, ours, here, folder / name, rows_of)
            for name in known
            if peers is None or name in peers
        )
        contrary = {n: against(ours[n].values, rows_of.get(n, {})) for n in ours}
    period = next(iter(written.components.values())).period
    contrary = {name: tools for name, tools in contrary.items() if tools}
    return SecondOpinion(scenario.name, str(period), rows, added, found, contrary)


def _recording(system: System) -> System:
    """Return the system with all connected outputs recorded at its one rate.

    Raises:
        ScenarioError: see above.
    """
    periods = {c.period for c in system.components.values()}
    if len(periods) > 1:
        listed = ", ".join(f"{c.name} {c.period} s" for c in system.components.values())
        raise ScenarioError(
            f"the other tools step everything at one rate, this has {listed}; give "
            f"one to all with --set <component>.step=..."
        )
    (period,) = periods
    for c in system.components.values():
        if c.offset or c.latency > 1:
            raise ScenarioError(
                f"components.{c.name}: the other tools know no offset and no latency "
                f"of more than one sample"
            )
    if system.faults:
        raise ScenarioError("the other tools know no faults; leave them out")
    if system.stop % period:
        raise ScenarioError(f"stop: the other tools need a multiple of {period} s")
    wiring = plan(system).wiring
    outputs = {
        f"{edge.source}.{_ours(system, edge.source, edge.output)}"
        for edge in wiring.edges
    }
    recorded = {
        column.name
        for columns in wiring.tables.values()
        for column in columns
        if _is_output(wiring, column)
    }
    names = sorted(outputs | recorded)
    return replace(system, record=dict.fromkeys(names, (period,)))


def _ours(system: System, component: str, theirs: str) -> str:
    """Return the name a component's map gives to an FMU's variable."""
    mapped = system.components[component].map
    return next((name for name, m in mapped.items() if m.name == theirs), theirs)


def _as_jacobi(system: System) -> tuple[System, tuple[str, ...]]:
    """Return the system as the tools exchange, and whom that delays by a sample."""
    parts = plan(system).wiring.parts
    added = tuple(
        name
        for name, part in parts.items()
        if part.kind == "sampled" and not part.component.latency
    )
    components = {
        name: replace(c, latency=1) if name in added else c
        for name, c in system.components.items()
    }
    return replace(system, components=components), added


def _columns(wiring: Wiring) -> list[Column]:
    return [column for columns in wiring.tables.values() for column in columns]


def _is_output(wiring: Wiring, column: Column) -> bool:
    found = _outputs(wiring).get(column.index)
    return found is not None and found[1].causality == "output"


def _outputs(wiring: Wiring) -> dict[int, tuple[str, FmuVariable]]:
    """Return component and variable of every place that holds a published number."""
    return {
        part.published + place: (name, variable)
        for name, part in wiring.parts.items()
        for place, variable in enumerate(v for v in part.read for _ in range(v.size))
    }


def _inputs(wiring: Wiring) -> dict[int, tuple[str, FmuVariable]]:
    return {
        part.first_input + place: (name, variable)
        for name, part in wiring.parts.items()
        for place, variable in enumerate(v for v in part.inputs for _ in range(v.size))
    }


def peer_job(wiring: Wiring) -> dict[str, Any]:
    """Return the system as ``peers/child.py`` wants it."""
    outputs, inputs, system = _outputs(wiring), _inputs(wiring), wiring.system
    if why := only_python(wiring):
        raise ScenarioError(f"{why}, which the other tools do not do")
    for part in wiring.parts.values():
        for copy in part.copies:
            if copy.whole is not None:
                raise ScenarioError(
                    f"{copy.ends} is rounded into a range, which the other tools cannot"
                )
    period = next(iter(system.components.values())).period
    return {
        "step": float(period),
        "period": [period.numerator, period.denominator],
        "count": int(system.stop / period),
        "components": {
            name: {
                "fmu": str(part.fmu.path.absolute()),
                "fmi": part.fmu.fmi_major,
                "start": [
                    [v.name, v.reference, v.sort, values[0]]
                    for v, values in map(_scalar, part.start)
                ],
            }
            for name, part in wiring.parts.items()
        },
        "connections": [
            {
                "source": _variable(*outputs[copy.source]),
                "sink": _variable(*inputs[copy.sink]),
                "gain": copy.affine.gain,
                "offset": copy.affine.offset,
            }
            for part in wiring.parts.values()
            for copy in part.copies
        ],
        "signals": [_variable(*outputs[c.index]) for c in _columns(wiring)],
    }


def _scalar(start: Written) -> Written:
    if start[0].shape or start[0].is_text:
        raise ScenarioError(
            f"{start[0].name}: the other tools take no FMI 3 arrays and no texts"
        )
    return start


def _variable(component: str, variable: FmuVariable) -> list[Any]:
    if variable.shape:
        raise ScenarioError(
            f"{component}.{variable.name}: the other tools take no FMI 3 arrays"
        )
    return [component, variable.name, variable.reference, variable.sort]


def _opinion(
    peer: Peer,
    job: Mapping[str, Any],
    wiring: Wiring,
    ours: Result,
    here: Result,
    folder: Path,
    rows_of: dict[str, dict[str, Rows]],
) -> PeerOpinion:
    """Return one tool's opinion, and note its rows of every signal."""
    folder.mkdir()
    given = {**job, "folder": str(folder)}
    release = ""
    try:
        release = version(peer, python_of(peer))
        table = carry_out(peer, given)
        if peer.name == "fmucontainer":
            table = carry_out(every_peer()["fmpy"], _contained(given))
    except PeerError as error:
        return PeerOpinion(peer.name, release, 0, str(error), ())
    at = np.rint(table[:, 0] / job["step"]).astype(int)
    signals = []
    for column, values in zip(_columns(wiring), table[:, 1:].T, strict=True):
        theirs = column.affine.gain * values + column.affine.offset
        mine, written = ours[column.name], here[column.name].values
        shift = min(SHIFTS, key=lambda s: _apart(theirs, mine.values, at - s))
        rows_of.setdefault(column.name, {})[peer.name] = at - shift, theirs
        signals.append(
            SignalOpinion(
                column.name,
                mine.unit,
                float(np.max(np.abs(mine.values))),
                _apart(theirs, mine.values, at - shift),
                shift,
                _apart(theirs, written, at - shift),
            )
        )
    return PeerOpinion(peer.name, release, len(table), "", tuple(signals))


def _contained(job: Mapping[str, Any]) -> dict[str, Any]:
    """Return the job of running the container that a tool has built."""
    import fmpy

    container = Path(job["folder"]) / "container.fmu"
    described = fmpy.read_model_description(str(container), validate=False)
    references = {v.name: v.valueReference for v in described.modelVariables}
    return {
        **job,
        "components": {"container": {"fmu": str(container), "fmi": 2, "start": []}},
        "connections": [],
        "signals": [
            ["container", name, references[name], sort]
            for component, variable, _, sort in job["signals"]
            for name in [f"seen.{component}.{variable}"]
        ],
    }


def _apart(
    theirs: NDArray[np.float64], ours: NDArray[np.float64], at: NDArray[np.int64]
) -> float:
    """Return the largest difference at the rows that both have."""
    both = (at >= 0) & (at < len(ours))
    if not np.any(both):
        return float("inf")
    return float(np.max(np.abs(theirs[both] - ours[at[both]])))
