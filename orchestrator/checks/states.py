"""Dynamic items: states that are saved, restored and reset."""

from collections.abc import Iterator

import numpy as np

from orchestrator.checks.instance import Row, same
from orchestrator.checks.item import Finding, Said, dynamic
from orchestrator.checks.laboratory import STEPS, Laboratory

HALF = STEPS // 2


@dynamic(
    19,
    "A saved state continues bit by bit",
    "FMI 2.0.5 section 2.1.8; FMI 3.0.2 (getting and setting the complete FMU state)",
    "put everything that influences later values into the state, time included",
)
def saved(lab: Laboratory) -> Iterator[Said]:
    lab.needs("canGetAndSetFMUstate")
    with lab.running() as one:
        one.run(HALF)
        lab.trying("saving the state")
        state, time = one.fmu.getFMUState(), one.time
        first = one.run(HALF)
        for _ in range(2):
            lab.trying("restoring the state")
            one.restore(state, time)
            if not same(one.run(HALF), first):
                yield Finding("after restoring a state the values differ")
                break
        lab.trying("freeing the state")
        one.fmu.freeFMUState(state)
        lab.trying("saving and freeing 1000 states")
        for _ in range(1000):
            one.fmu.freeFMUState(one.fmu.getFMUState())


def _elsewhere(lab: Laboratory) -> Iterator[Said]:
    with lab.instance() as one:
        one.begin()
        lab.trying("reading a state written by another process")
        state = one.fmu.deserializeFMUState(lab.kept["state"])
        one.restore(state, lab.kept["time"])
        if not same(one.run(HALF), lab.kept["rows"]):
            yield Finding("a state that another process wrote gives other values")
        one.fmu.freeFMUState(state)


@dynamic(
    20,
    "A written state continues in another process",
    "FMI 2.0.5 section 2.1.8; FMI 3.0.2 (serialisation); FMPy issue 811",
    "write values, never addresses; use one size for one model",
    then=_elsewhere,
)
def written(lab: Laboratory) -> Iterator[Said]:
    lab.needs("canSerializeFMUstate")
    with lab.running() as one:
        one.run(HALF)
        lab.trying("writing the state")
        state = one.fmu.getFMUState()
        texts = [one.fmu.serializeFMUState(state) for _ in range(2)]
        one.fmu.freeFMUState(state)
        if texts[0] != texts[1]:
            yield Finding("writing one state twice gives different bytes")
        lab.kept |= {"state": texts[0], "time": one.time}
        lab.kept["rows"] = one.run(HALF)
    yield f"{len(texts[0])} bytes"


@dynamic(
    21,
    "Reset begins anew, bit by bit",
    "FMI 2.0.5 section 2.1.6 (fmi2Reset); FMI 3.0.2 section 2.3; Reference-FMUs 204",
    "set everything back to the values after instantiation, time and inputs included",
)
def reset(lab: Laboratory) -> Iterator[Said]:
    with lab.running() as one:
        first = one.run(STEPS)
        lab.trying("resetting between steps")
        one.reset()
        one.begin()
        again = one.run(STEPS)
        if not same(again, first):
            yield Finding(f"after a reset {_differing(again, first)}")
        lab.trying("resetting after terminate")
        one.fmu.terminate()
        one.reset()
        one.begin()
        if not same(one.run(STEPS), first):
            yield Finding("after terminate and reset the values differ")


def _differing(again: Row, first: Row) -> str:
    if again.shape != first.shape:
        return f"there are {len(again)} rows, before there were {len(first)}"
    unequal = (again != first) & ~(np.isnan(again) & np.isnan(first))
    return f"{int(np.sum(np.any(unequal, axis=1)))} of {len(first)} rows differ"
