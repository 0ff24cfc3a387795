"""What a composition's own equations give, linearised: beside what was measured.

The master's timetable is carried out once over a hyperperiod on the linearised parts
(``linear``), with one unknown for each number that is remembered and for each that is
injected.  That is exact for any rates, latencies and dead times; it needs the models
of all that lies in the loops, or between what is excited and observed.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil

import numpy as np
from numpy.typing import NDArray

from fmus.load import load_model
from orchestrator.errors import ResponseError
from orchestrator.fmu.ports import Port, ports
from orchestrator.master.loaded import Loaded
from orchestrator.master.series import Series
from orchestrator.master.simulate import plan
from orchestrator.response.bench import Bench, bench
from orchestrator.response.linear import Linear
from orchestrator.response.measured import Measured, Response, Transfer
from orchestrator.response.window import Window
from orchestrator.scenario.compose import Composition

Real = NDArray[np.float64]
Bools = NDArray[np.bool_]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Traced:
    """G (lines, observed, excited) of the equations, linearised at ``t`` (s)."""

    t: float
    G: Complex

    @property
    def L(self) -> Complex:
        """The open loops of what is broken and observed there, T = -G."""
        L: Complex = -self.G @ np.linalg.inv(np.eye(self.G.shape[1]) + self.G)
        return L


def beside(composition: Composition, found: Measured) -> tuple[Traced | None, str]:
    """Return ``traced``, or nothing, and in words what it is or why there is none."""
    try:
        equations = traced(composition, found)
    except ResponseError as error:
        return None, str(error)
    if isinstance(found, Transfer):
        name, measured, exact = "G", found.G, equations.G
    else:
        assert isinstance(found, Response)
        eye = np.eye(len(found.breaks))
        name, measured, exact = "S", found.S, eye + equations.G
    most = np.max(np.abs(exact), axis=0)
    apart = np.divide(
        np.abs(measured - exact), most, out=np.zeros(exact.shape), where=most > 0
    )
    return equations, (
        f"the models' equations, linearised at {equations.t:g} s, are within "
        f"{100 * np.max(apart):.2g} % of the largest {name}"
    )


def traced(composition: Composition, found: Measured) -> Traced:
    """Return what the models' equations give at the lines of a measurement.

    They are linearised where the composition is at the end of that measurement,
    without injection and without the steps of its quantisers.

    Raises:
        ResponseError: a part on the way has no model here, or is not to be
            linearised; it names it.
    """
    observed = found.observed if isinstance(found, Transfer) else None
    with bench(composition, found.breaks, observed) as at:
        t = found.ended
        return Traced(float(t), hyperperiod(at, t).response(found.hz))


def hyperperiod(at: Bench, t: Fraction) -> Window:
    """Return the equations of a bench over a hyperperiod, linearised at t (s).

    Raises:
        ResponseError: as of ``traced``.
    """
    composition = at.composition
    _refuse_what_is_not_ours(composition, at)
    points = _points(composition, at, t)
    n = int(at.rates.whole / at.rates.T)
    ones = [np.ones(n)] * len(at.breaks)
    wiring = plan(at.system(ones, n, 1)).wiring
    parts = {
        name: Linear(
            wiring.parts[name], load_model(composition.module(name)), points[name]
        )
        for name in at.rates.way
    }
    _refuse_no_slope(parts)
    settled = 2 + ceil(max(p.late for p in parts.values()) / at.rates.whole)
    timetable = plan(at.system(ones, n, settled + 3))
    return Window(at, timetable, parts, settled)


def linked(at: Bench, t: Fraction) -> Bools:
    """Return what equations, linearised at t (s), lead from where to where.

    (observed, breaks); where there are no equations anything may be.
    """
    if at.links is None:
        try:
            at.links = hyperperiod(at, t).linked()
        except ResponseError:
            at.links = np.ones((len(at.observed), len(at.breaks)), bool)
    return at.links


def refuse_growth(at: Bench, t: Fraction) -> None:
    """Refuse a bench whose equations, linearised at t (s), have a mode that grows.

    Where there are no equations nothing is said.

    Raises:
        ResponseError: it grows; it says how fast.
    """
    try:
        found = hyperperiod(at, t).growth()
    except ResponseError:
        return
    if found is None:
        return
    names = ", ".join(b.name for b in at.breaks)
    raise ResponseError(
        f"{at.option} {names}: unstable, so it has no response: by the models' "
        f"equations, linearised at {float(t):g} s, a mode {found}; look at the signs "
        f"and sizes of the gains on the way ({', '.join(sorted(at.rates.way))})"
    )


def _refuse_no_slope(parts: Mapping[str, Linear]) -> None:
    for name, part in parts.items():
        if not all(np.all(np.isfinite(matrix)) for matrix in part.at):
            raise ResponseError(
                f"no linearised equations beside it: {name} has no finite slope where "
                f"it is then"
            )


def _refuse_what_is_not_ours(composition: Composition, at: Bench) -> None:
    for name in sorted(at.rates.way):
        source = composition.sources[name]
        if source.endswith(".fmu"):
            raise ResponseError(
                f"no linearised equations beside it: {name} is {source}, whose "
                f"equations are not known here"
            )
    for name in composition.system.groups:
        raise ResponseError(
            f"no linearised equations beside it: groups.{name} is iterated"
        )
    for name in composition.system.faults:
        raise ResponseError(f"no linearised equations beside it: {name} has faults")


def _points(
    composition: Composition, at: Bench, t: Fraction
) -> Mapping[str, Mapping[int, float]]:
    """Return states and inputs of the parts on the way, by value reference, at t."""
    parts, fmus = composition.system.components, composition.fmus
    wanted: list[Port] = [
        port
        for name in sorted(at.rates.way)
        for variable in fmus[name].variables.values()
        if variable.causality == "input" or variable.name.startswith("state.")
        for port in ports(parts[name], fmus[name], variable.name)
    ]
    record = dict.fromkeys((p.full_name for p in wanted), (t,))
    system = at.system([None] * len(at.breaks), int(t / at.rates.T), 1)
    loaded = Loaded()
    try:
        run = Series(
            plan(replace(system, record=record)), frozenset(record), loaded
        ).run
        rows, _ = run({})
    finally:
        loaded.drop()
    found: dict[str, dict[int, float]] = {name: {} for name in at.rates.way}
    for port in wanted:
        reference = port.variable.reference + port.element
        found[port.component][reference] = float(rows[port.full_name].values[-1])
    return found
