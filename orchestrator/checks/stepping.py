"""Dynamic items: steps, their sizes, and where time begins and ends."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from fmpy.fmi1 import FMICallException

from orchestrator.checks.instance import (
    ERROR,
    OK,
    Instance,
    Row,
    start_of,
)
from orchestrator.checks.item import Finding, NotApplicable, Said, advice, dynamic
from orchestrator.checks.laboratory import STEPS, Laboratory
from orchestrator.fmu.description import FmuVariable
from orchestrator.instances.group import told

TOLERANCE = 1e-6  # of a value's size
NUDGE = 1e-9  # by which start values are moved to see how much a model cares
HUGE = 1e100  # beyond it a model has left what it describes
MANY = 2000
LAST = 10  # steps that tell how much one step changes
WHOLE = 0.25  # of what a step changes: less is no lost step


@dataclass(frozen=True)
class _End:
    """Where a run ends: its last row, the most that one of its last steps changed."""

    row: Row
    change: Row


def _end_of(rows: Row) -> _End:
    with np.errstate(invalid="ignore", over="ignore"):
        steps = np.abs(np.diff(rows[-LAST - 1 :], axis=0))
    return _End(rows[-1], np.max(steps, axis=0, initial=0.0))


def _differ(lab: Laboratory, reached: Row, wanted: Row, allowed: Row) -> int | None:
    """Return the place that differs most, None if none does by more than allowed.

    What overflows is not judged: there a last bit makes another infinity.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        excess = np.abs(reached - wanted) - allowed
    sizes = np.maximum(np.abs(reached), np.abs(wanted))
    wild = ~(sizes < HUGE)
    if wild.any():
        name = lab.column(int(np.argmax(wild)))
        lab.notes["huge"] = f"{name} grows beyond {HUGE:g} and is not judged"
    excess[wild | np.isnan(excess)] = 0.0
    return int(np.argmax(excess)) if (excess > 0).any() else None


def _sensitive(wanted: Row, nudged: Row) -> Row:
    """Return by how much values may differ, as they do when starts are nudged."""
    with np.errstate(invalid="ignore", over="ignore"):
        return TOLERANCE / NUDGE * np.abs(nudged - wanted)


def _nudged(lab: Laboratory, name: str) -> Instance | None:
    """Return a running instance whose start values are moved a little, if it can be."""
    exact = [v for v in lab.variables(initial="exact") if v.sort == "real"]
    local = [v for v in exact if v.causality == "local" and v.variability != "fixed"]
    for movable in (lab.excited + local, lab.excited):
        one = Instance(lab, name)
        one.enter()
        for variable in lab.sampled("start values", movable):
            if one.worst < ERROR:
                one.status(one.set, variable, _beside(variable))
        if movable and one.worst < ERROR and one.status(one.leave) == OK:
            return one
        one.free()
    return None


def _beside(variable: FmuVariable) -> list[float]:
    starts = start_of(variable) or [0.0] * variable.size
    high = float(variable.max) if variable.max else np.inf
    return [s + (d if s + d <= high else -d) for s in starts for d in [_nudge(s)]]


def _nudge(start: float) -> float:
    return NUDGE * max(1.0, abs(start))


@dynamic(
    16,
    "Variable steps do what is declared",
    "FMI 2.0.5 section 4.3.1 (canHandleVariableCommunicationStepSize); FMI 3.0.2 "
    "section 4.2.1",
    "integrate over the step that is asked for, or refuse it; never another one",
)
def variable_steps(lab: Laboratory) -> Iterator[Said]:
    lab.needs_co_simulation()
    declared = lab.description.variable_step
    with lab.running() as one:
        rows = one.run(STEPS, excited=False)
        count = len(rows) - one.ended  # rounding may end it a step before
    count -= count % 2
    if count < 2:
        raise NotApplicable("it ends the run in its first steps")
    wanted = _end_of(rows[:count])
    sizes = _sizes(count * lab.h, lab.h)
    with lab.running() as one:
        lab.trying("stepping by sizes of all kinds")
        t = 0.0
        for h in sizes:
            status = one.status(one.step, t, h)
            if status != OK and declared:
                yield Finding(
                    f"canHandleVariableCommunicationStepSize = true, but a step of "
                    f"{h:.6g} s returns {told(status)}"
                )
            if status != OK:
                yield f"a step of {h:.6g} s returns {told(status)}"
                return
            t += h
        if one.ended:
            yield f"it ends the run at {one.time:.6g} s when steps have all sizes"
            return
        reached = one.row()
    nudged = _reached_nudged(lab, count, wanted.row)
    with np.errstate(invalid="ignore", over="ignore"):
        allowed = (
            4 * _integrates(lab, count, wanted.row)
            + TOLERANCE * np.maximum(np.abs(wanted.row), 1)
            + 2 * WHOLE * wanted.change
            + _sensitive(wanted.row, nudged)
        )
    worst = _differ(lab, reached, wanted.row, allowed)
    if worst is None:
        yield f"{len(sizes)} steps of all sizes reach the same values"
        return
    yield Finding(
        f"after {count * lab.h:g} s in {len(sizes)} steps {lab.column(worst)} is "
        f"{reached[worst]:.6g}, in {count} equal ones {wanted.row[worst]:.6g}"
        + ("" if declared else "; the other step sizes are accepted without a word")
    )


def _integrates(lab: Laboratory, count: int, wanted: Row) -> Row:
    """Return how well the FMU integrates: what twice the step makes of the values.

    Half the step has to make less of them; else it does not integrate the step.
    """
    doubled = np.abs(wanted - _reached(lab, count // 2, 2 * lab.h))
    halved = np.abs(wanted - _reached(lab, 2 * count, lab.h / 2))
    return np.where(halved > 1.5 * doubled, 0.0, doubled)


def _reached(lab: Laboratory, count: int, h: float) -> Row:
    with lab.running() as one:
        if one.status(lambda: one.run(count, excited=False, h=h)) != OK or one.ended:
            return np.full(sum(v.size for v in lab.watched), np.nan)
        return one.row()


def _reached_nudged(lab: Laboratory, count: int, otherwise: Row) -> Row:
    one = _nudged(lab, "nudged")
    if one is None:
        return otherwise
    try:
        rows = one.run(count, excited=False)
        return otherwise if one.ended else np.asarray(rows[-1])
    finally:
        one.free()


def _sizes(stop: float, h: float) -> list[float]:
    """Return steps between a half and a whole ``h`` that end at ``stop``."""
    rng = np.random.default_rng(1)
    sizes: list[float] = []
    while (left := stop - sum(sizes)) > 1e-9 * h:
        size = float(h * rng.uniform(0.5, 1.0))
        sizes.append(left if left < 1.5 * h and left - size < 0.5 * h else size)
    return sizes


@dynamic(
    17,
    "Rounding of time loses no step",
    "FMI 2.0.5 section 4.2.2; FMIKit issue 133",
    "count steps in integers, or compare times with a tolerance",
    seconds=120.0,
)
def step_noise(lab: Laboratory) -> Iterator[Said]:
    lab.needs_co_simulation()
    h = lab.h
    with lab.running("first") as one:
        lab.trying(f"stepping {MANY} times")
        many = lab.as_many(MANY, lambda k: one.step(k * h, h), 15.0)
        count = round(one.time / h) - 1 if one.ended else many
    if count < 1:
        raise NotApplicable("it ends the run in its first steps")
    exact = _noisy(lab, "exact", Instance(lab, "exact").begin(), count)
    for noise in ("summed", "noisy"):
        try:
            reached = _noisy(lab, noise, Instance(lab, noise).begin(), count).row
        except FMICallException as error:
            yield Finding(f"times {noise}: {error}")
            continue
        scale = np.maximum(np.abs(exact.row), 1e-9)
        allowed = np.maximum(TOLERANCE * scale, WHOLE * exact.change)
        if _differ(lab, reached, exact.row, allowed) is None:
            continue
        if one_nudged := _nudged(lab, "nudged"):
            nudged = _noisy(lab, "from a nudge", one_nudged, count).row
            allowed = np.maximum(allowed, _sensitive(exact.row, nudged))
        worst = _differ(lab, reached, exact.row, allowed)
        if worst is not None:
            yield Finding(
                f"times {noise} by rounding end at other values: {lab.column(worst)} "
                f"is {reached[worst]:.9g}, not {exact.row[worst]:.9g}"
            )
    yield f"{count} steps of {h:g} s"


def _noisy(lab: Laboratory, noise: str, one: Instance, count: int) -> _End:
    """Step with times that are exact, summed or noisy, and free the instance."""
    rng, h = np.random.default_rng(2), lab.h
    rows: list[Row] = []
    try:
        lab.trying(f"stepping {count} times, times {noise}")
        t = 0.0
        for k in range(count):
            size = h * (1 + 1e-12 * rng.uniform(-1, 1)) if noise == "noisy" else h
            one.step(t if noise == "summed" else k * h, size)
            t += size
            if k >= count - LAST - 1:
                rows.append(one.row())
    finally:
        one.free()
    return _end_of(np.array(rows))


@dynamic(
    18,
    "Time begins where it is told and ends at the stop time",
    "FMI 2.0.5 sections 2.1.6, 4.2.2; FMI 3.0.2 sections 2.3.2, 4.2.1",
    "take the start time from setupExperiment, refuse steps that are not positive or "
    "go past a stop time that was defined",
)
def times(lab: Laboratory) -> Iterator[Said]:
    lab.needs_co_simulation()
    h = lab.h
    with lab.instance("later") as one:
        try:
            one.begin(100 * h)
            one.run(5)
        except FMICallException as error:
            yield Finding(f"start time {100 * h:g} s: {error}")
    with lab.running("standing") as one:
        lab.trying("stepping by 0 s")
        if one.status(one.step, 0.0, 0.0) == OK:
            yield advice("a step of 0 s is accepted")
    with lab.running("backwards") as one:
        lab.trying("stepping backwards")
        one.run(2)
        if one.status(one.step, 2 * h, -h) == OK:
            yield advice("a negative step is accepted")
    with lab.instance("ended") as one:
        one.begin(0.0, 3 * h, None)
        yield from _past_the_end(one, h)


def _past_the_end(one: Instance, h: float) -> Iterator[Said]:
    try:
        one.run(3)
    except FMICallException as error:
        yield Finding(f"stop time {3 * h:g} s cannot be reached: {error}")
        return
    one.lab.trying("stepping past the stop time")
    if one.status(one.step, 3 * h, h) == OK:
        yield advice(f"a step past the stop time ({3 * h:g} s) is accepted")
