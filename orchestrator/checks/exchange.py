"""Dynamic item: what importers do with a model that they integrate themselves."""

from collections.abc import Iterator

import numpy as np

from orchestrator.checks.instance import OK
from orchestrator.checks.item import Finding, NotApplicable, Said, advice, dynamic
from orchestrator.checks.laboratory import Laboratory
from orchestrator.checks.moment import Known, interfaces, knowns
from orchestrator.instances.group import told


@dynamic(
    38,
    "Continuous states can be set by name while an importer integrates",
    "FMI 3.0.2 sections 2.3 and 3.2; FMI 2.0.5 section 3.2.1 has only "
    "fmi2SetContinuousStates",
    "accept states with initial = exact in event mode and continuous-time mode: "
    "importers that evaluate a model at given points set them so",
)
def states_by_name(lab: Laboratory) -> Iterator[Said]:
    exchange = next((i for i in interfaces(lab) if i.kind == "model exchange"), None)
    if exchange is None:
        raise NotApplicable("it has no model exchange")
    states = [k for k in knowns(exchange) if k.place is not None]
    exact = [k for k in states if k.variable.initial == "exact"]
    if not exact:
        raise NotApplicable("it has no continuous state with initial = exact")
    with exchange.running() as one:
        lab.trying("setting continuous states by name")
        for known in exact:
            value = known.moved(known.read(one), 0.01)
            status = one.status(one.set, known.variable, [float(v) for v in value])
            if status != OK:
                yield from _refused(lab, known, status)
                return
            if not np.array_equal(known.read(one), value):
                yield Finding(f"{known.name} keeps its value when it is set by name")
    yield f"{len(exact)} states"


def _refused(lab: Laboratory, known: Known, status: int) -> Iterator[Said]:
    text = f"setting {known.name} in continuous-time mode returns {told(status)}"
    yield advice(text) if lab.description.fmi_major == 3 else text
