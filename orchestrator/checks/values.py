"""Dynamic items: variables set and read at the right and at the wrong moment."""

from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException

from orchestrator.checks.instance import (
    FATAL,
    OK,
    Instance,
    excitation,
    same,
    start_of,
)
from orchestrator.checks.item import (
    WORDS,
    Finding,
    NotApplicable,
    Said,
    advice,
    dynamic,
)
from orchestrator.checks.laboratory import STEPS, Laboratory
from orchestrator.instances.group import told

SHOWN = 5


@dynamic(
    9,
    "Start values of the description are those of the binary",
    "FMI 2.0.5 section 2.2.7 (start); FMI 3.0.2 section 2.4.7",
    "write the values into modelDescription.xml that the binary starts with",
)
def burnt_in(lab: Laboratory) -> Iterator[Said]:
    described = [
        v
        for v in lab.description.variables.values()
        if v.start is not None
        and v.fmi_type not in WORDS
        and (v.causality in ("parameter", "input") or v.initial == "exact")
    ]
    with lab.instance() as one:
        one.enter()
        for variable in described:
            found = [float(v) for v in one.get(variable)]
            wanted = [float(v) for v in start_of(variable)]
            if not np.array_equal(found, wanted):
                yield Finding(
                    f"{variable.name}: start = {variable.start}, the binary has "
                    f"{' '.join(f'{v:.17g}' for v in found[:SHOWN])}"
                )
        one.leave()
        alone = one.run(STEPS)
    settable = [v for v in described if v.variability != "constant"]
    structural = [v for v in settable if v.causality == "structuralParameter"]
    with lab.instance("set") as one:
        lab.trying("setting all variables to their start values")
        if structural:  # they are set in a mode of their own, and before arrays
            one.configure(structural)
        for variable in settable:
            if variable in structural:
                continue
            one.set(variable, start_of(variable))
        one.begin()
        if not same(one.run(STEPS), alone):
            yield Finding("setting all start values as described gives another run")
    yield f"{len(described)} start values"


@dynamic(
    24,
    "Tunable parameters can be changed between steps, fixed ones not",
    "FMI 2.0.5 section 2.2.7 (variability), 4.2.1; FMI 3.0.2 section 2.4.7.4",
    "accept tunable parameters between steps, refuse fixed ones with Error",
)
def tunable(lab: Laboratory) -> Iterator[Said]:
    lab.needs_co_simulation()
    parameters = [v for v in lab.variables(causality="parameter") if v.sort == "real"]
    if not parameters:
        raise NotApplicable("it has no real parameter")
    parameters = lab.sampled("parameters", parameters)
    frozen = []
    for variability in ("tunable", "fixed"):
        for variable in parameters:
            if variable.variability != variability:
                continue
            with lab.running() as one:
                one.run(2)
                if one.ended:
                    raise NotApplicable("it ends the run in its first steps")
                lab.trying(f"changing {variability} parameter {variable.name}")
                value = excitation(variable, 0.01)
                status = one.status(one.set, variable, value)
                if variability == "fixed":
                    frozen += [variable.name] if status == OK else []
                elif status != OK:
                    yield Finding(
                        f"{variable.name} is tunable, but changing it returns "
                        f"{told(status)}"
                    )
                elif one.get(variable) != value:
                    yield Finding(f"{variable.name} keeps its value when it is changed")
    if frozen:
        more = f" and {len(frozen) - SHOWN} more" if len(frozen) > SHOWN else ""
        yield advice(
            f"fixed parameters are changed between steps: "
            f"{', '.join(frozen[:SHOWN])}{more}"
        )
    yield f"{len(parameters)} parameters"


@dynamic(
    26,
    "What is not allowed is refused, and can be gone on from",
    "FMI 2.0.5 sections 2.1.3, 4.2.4; FMI 3.0.2 section 2.2.3",
    "return Error with a message and leave the instance as it was",
)
def refusals(lab: Laboratory) -> Iterator[Said]:
    constants = lab.variables(variability="constant")
    outputs = [v for v in lab.variables(causality="output") if v.sort == "real"]
    attempts: list[tuple[str, Any]] = [
        ("an unknown reference is read", Instance.read_unknown)
    ]
    for group, what in ((constants, "a constant"), (outputs, "an output")):
        if group and group[0].sort == "real":
            variable = group[0]
            attempts.append(
                (
                    f"{what} ({variable.name}) is set",
                    lambda one, v=variable: one.set(v, [1.0] * v.size),
                )
            )
    for what, attempt in attempts:
        with lab.running() as one:  # after an Error nothing else may be tried on it
            one.run(2)
            lab.trying(f"trying whether {what}")
            one.messages.clear()
            status = one.status(attempt, one)
            if status == OK and not one.messages:
                yield advice(f"{what} without an objection")
            elif status == OK:
                yield f"{what}: returns OK, objects by a message only"
            elif status >= FATAL:
                yield Finding(f"{what}: returns Fatal, which ends every instance")
                return
            lab.trying("resetting after a refusal")
            one.reset()
            one.begin()
            one.run(2)
    with lab.instance("early") as early:
        if lab.kind == "co-simulation":
            lab.trying("stepping before initialisation")
            if early.status(early.step, 0.0, lab.h) == OK:
                yield advice("a step before initialisation is accepted")


@dynamic(
    27,
    "NaN, infinity and huge numbers do no lasting harm",
    "FMI 2.0.5 section 2.1.3; implementers' guide 3",
    "refuse the value, or give NaN; a reset has to bring the model back",
    seconds=10.0,
)
def wild_numbers(lab: Laboratory) -> Iterator[Said]:
    inputs = [v for v in lab.variables(causality="input") if v.sort == "real"]
    if not inputs:
        raise NotApplicable("it has no real input")
    wanted = lab.trajectory()
    with lab.instance() as one:
        for value in (np.nan, np.inf, -np.inf, 1e300):
            one.begin()
            lab.trying(f"setting an input to {value}")
            with suppress(FMICallException):
                one.set(inputs[0], [value] * inputs[0].size)
                one.run(3, excited=False)
            lab.trying(f"resetting after an input of {value}")
            one.reset()
        one.begin()
        if not same(one.run(STEPS), wanted):
            yield Finding("a reset after NaN or infinity does not bring the model back")


@dynamic(
    36,
    "Events and early returns come only when they were allowed",
    "FMI 3.0.2 section 4.2 (eventModeUsed, earlyReturnAllowed)",
    "without eventModeUsed and earlyReturnAllowed go on to the end of the step",
)
def no_surprises(lab: Laboratory) -> Iterator[Said]:
    lab.needs_co_simulation()
    if lab.description.fmi_major != 3:
        raise NotApplicable("events of co-simulation are of FMI 3")
    with lab.running() as one:
        lab.trying("stepping without events and early returns")
        for k in range(STEPS):
            if one.ended:
                return
            event, ended, early, reached = one.fmu.doStep(k * lab.h, lab.h)
            if event or early:
                what = "an event" if event else "an early return"
                yield Finding(f"step {k} reports {what}, which was not allowed")
                return
            if ended:
                yield f"step {k} ends the simulation, as it may"
                return
            if not np.isclose(reached, (k + 1) * lab.h, rtol=1e-9):
                yield Finding(
                    f"step {k} ends at {(k + 1) * lab.h:.9g} s, but "
                    f"lastSuccessfulTime = {reached:.9g} s"
                )
                return


@dynamic(
    37,
    "What is set before the initialisation is what runs",
    "FMI 2.0.5 section 4.2.4; FMI 3.0.2 section 2.3.2",
    "overwrite nothing that was set, neither in fmi2SetupExperiment nor later",
)
def survives(lab: Laboratory) -> Iterator[Said]:
    parameters = lab.movable_parameters
    if not parameters:
        raise NotApplicable("it has no real parameter that can be set")
    with lab.instance() as one:
        lab.trying("setting parameters before the experiment is set up")
        for variable in parameters:
            one.set(variable, excitation(variable, 0.02))
        one.begin()
        lost = [
            variable.name
            for variable in parameters
            if not np.allclose(
                one.get(variable), excitation(variable, 0.02), rtol=1e-6, atol=0
            )
        ]
    if lost:
        more = f" and {len(lost) - SHOWN} more" if len(lost) > SHOWN else ""
        yield Finding(
            f"after initialisation these are not what was set: "
            f"{', '.join(lost[:SHOWN])}{more}"
        )
    yield f"{len(parameters)} parameters"
