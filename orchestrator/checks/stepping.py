"""Dynamic items: steps, their sizes, and where time begins and ends."""

from collections.abc import Iterator

import numpy as np
from fmpy.fmi1 import FMICallException

from orchestrator.checks.item import Finding, Said, advice, dynamic
from orchestrator.checks.laboratory import (
    OK,
    STATUS,
    STEPS,
    Instance,
    Laboratory,
    Row,
    same,
)

TOLERANCE = 1e-6  # of a value's size
MANY = 2000


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
    wanted = _reached(lab, STEPS, lab.h)
    sizes = _sizes(STEPS * lab.h, lab.h)
    with lab.running() as one:
        lab.trying("stepping by sizes of all kinds")
        t = 0.0
        for h in sizes:
            status = one.status(one.step, t, h)
            if status != OK and declared:
                yield Finding(
                    f"canHandleVariableCommunicationStepSize = true, but a step of "
                    f"{h:.6g} s returns {STATUS[status]}"
                )
            if status != OK:
                yield f"a step of {h:.6g} s returns {STATUS[status]}"
                return
            t += h
        reached = one.row()
    # What twice the step makes of it tells how well the FMU integrates.
    doubled = _reached(lab, STEPS // 2, 2 * lab.h)
    allowed = 4 * np.abs(wanted - doubled) + TOLERANCE * np.maximum(np.abs(wanted), 1)
    excess = np.abs(reached - wanted) - allowed
    if not (excess > 0).any():
        yield f"{len(sizes)} steps of all sizes reach the same values"
        return
    worst = int(np.argmax(excess))
    yield Finding(
        f"after {STEPS * lab.h:g} s in {len(sizes)} steps {lab.column(worst)} is "
        f"{reached[worst]:.6g}, in {STEPS} equal ones {wanted[worst]:.6g}"
        + ("" if declared else "; the other step sizes are accepted without a word")
    )


def _reached(lab: Laboratory, count: int, h: float) -> Row:
    with lab.running() as one:
        if one.status(lambda: one.run(count, excited=False, h=h)) != OK:
            return np.full(len(one.row()), np.nan)
        return one.row()


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
)
def step_noise(lab: Laboratory) -> Iterator[Said]:
    lab.needs_co_simulation()
    h = lab.h

    def end(noise: str) -> Row:
        rng = np.random.default_rng(2)
        with lab.running(noise) as one:
            lab.trying(f"stepping {MANY} times, times {noise}")
            t = 0.0
            for k in range(MANY):
                size = h * (1 + 1e-12 * rng.uniform(-1, 1)) if noise == "noisy" else h
                one.step(t if noise == "summed" else k * h, size)
                t += size
            return one.row()

    exact = end("exact")
    for noise in ("summed", "noisy"):
        try:
            reached = end(noise)
        except FMICallException as error:
            yield Finding(f"times {noise}: {error}")
            continue
        if not same(exact[None], reached[None], 1e-6):
            yield Finding(f"times {noise} by rounding end at other values")
    yield f"{MANY} steps of {h:g} s"


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
        one.begin(stop=3 * h)
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
