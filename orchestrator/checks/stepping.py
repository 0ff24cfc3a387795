"""Dynamic items: steps, their sizes, and where time begins and ends."""

from collections.abc import Iterator

import numpy as np
from fmpy.fmi1 import FMICallException

from orchestrator.checks.item import Finding, Said, advice, dynamic
from orchestrator.checks.laboratory import OK, STATUS, STEPS, Instance, Laboratory, same

TOLERANCE = 1e-3  # of a value's size: other steps mean other integration errors
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
    with lab.running() as one:
        wanted = one.run(STEPS, excited=False)[-1]
    declared = lab.description.variable_step
    cuts = np.sort(np.random.default_rng(1).uniform(0, STEPS * lab.h, STEPS // 2))
    times = np.array([0.0, *cuts, STEPS * lab.h])
    with lab.running() as one:
        lab.trying("stepping by sizes of all kinds")
        for t, h in zip(times[:-1], np.diff(times), strict=True):
            status = one.status(one.step, float(t), float(h))
            if status == OK:
                continue
            if declared:
                yield Finding(
                    f"canHandleVariableCommunicationStepSize = true, but a step of "
                    f"{h:.6g} s returns {STATUS[status]}"
                )
            else:
                yield "another step size is refused, as declared"
            return
        reached = one.row()
    equal = same(wanted[None], reached[None], TOLERANCE)
    if not equal and declared:
        yield Finding(_difference(lab, wanted, reached))
    elif not equal:
        yield Finding(
            "other step sizes are accepted, but the values lag without a word: "
            + _difference(lab, wanted, reached),
            mend="refuse a step that is not a multiple of the internal one",
        )
    else:
        yield f"{len(times) - 1} steps of all sizes reach the same values"


def _difference(lab: Laboratory, wanted: np.ndarray, reached: np.ndarray) -> str:
    worst = int(np.argmax(np.abs(wanted - reached) / np.maximum(np.abs(wanted), 1e-9)))
    return (
        f"after {STEPS * lab.h:g} s value {worst} is {reached[worst]:.6g}, with equal "
        f"steps {wanted[worst]:.6g}"
    )


@dynamic(
    17,
    "Rounding of time loses no step",
    "FMI 2.0.5 section 4.2.2; FMIKit issue 133",
    "count steps in integers, or compare times with a tolerance",
)
def step_noise(lab: Laboratory) -> Iterator[Said]:
    lab.needs_co_simulation()
    h = lab.h

    def end(noise: str) -> np.ndarray:
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
            yield Finding("a negative step is accepted")
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
