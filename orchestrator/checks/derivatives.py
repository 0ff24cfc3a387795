"""Dynamic items: derivatives that an FMU gives or takes."""

from collections.abc import Iterator

import numpy as np

from orchestrator.checks.archive import Archive
from orchestrator.checks.instance import OK, Instance, Row
from orchestrator.checks.item import Finding, NotApplicable, Said, advice, dynamic
from orchestrator.checks.laboratory import Laboratory
from orchestrator.checks.moment import (
    Known,
    Unknown,
    interfaces,
    knowns,
    real_inputs,
    unknowns,
)
from orchestrator.fmu.description import FmuVariable
from orchestrator.instances.group import told

DIRECTIONAL = "providesDirectionalDerivatives"  # FMI 2 without the s
ADJOINT = "providesAdjointDerivatives"
FROM_START = 5  # steps before derivatives are asked for once more


@dynamic(
    22,
    "Directional and adjoint derivatives are those of the model",
    "FMI 2.0.5 section 2.1.9; FMI 3.0.2 section 2.2.11",
    "differentiate the equations that are evaluated, where they are evaluated",
)
def directional(lab: Laboratory) -> Iterator[Said]:
    declaring = [
        by
        for by in interfaces(lab)
        if _provides(by, DIRECTIONAL) or _provides(by, ADJOINT)
    ]
    if not declaring:
        raise NotApplicable("it declares no directional or adjoint derivatives")
    for by in declaring:
        outputs = [u for u in unknowns(by) if u.variable.causality == "output"]
        with by.instance() as one:
            one.enter()
            yield from _compared(one, "in initialisation", real_inputs(by), outputs)
            one.leave()
            one.run(FROM_START)
            if one.ended:
                continue
            yield from _compared(one, f"by {by.kind}", knowns(by), unknowns(by))


def _provides(lab: Laboratory, capability: str) -> bool:
    """Tell what the interface declares; fmpy overlooks the name in FMI 3."""
    tag = "CoSimulation" if lab.kind == "co-simulation" else "ModelExchange"
    element = Archive(lab.description.path).root.find(tag)
    names = (capability.removesuffix("s"), capability)
    return any(element.get(name) in ("true", "1") for name in names)


def _compared(
    one: Instance, where: str, movable: list[Known], watched: list[Unknown]
) -> Iterator[Said]:
    """Compare what is given with central differences, and both with each other."""
    columns = [(known, i) for known in movable for i in range(known.variable.size)]
    watched = [u for u in watched if u.variable.sort == "real"]
    rows = [(unknown, i) for unknown in watched for i in range(unknown.variable.size)]
    if not rows or not columns:
        return
    found, noise = _differences(one, columns, watched)
    # A co-simulation need not show an input before the next step.
    known = found if found.any() else None
    if _provides(one.lab, DIRECTIONAL):
        one.lab.trying(f"asking for directional derivatives {where}")
        given = np.array([_direction(one, *c, watched, len(rows)) for c in columns]).T
        yield from _told(f"{where} d {{}} / d {{}}", given, known, noise, rows, columns)
        known = given if known is None else known
    if _provides(one.lab, ADJOINT):
        one.lab.trying(f"asking for adjoint derivatives {where}")
        given = np.array([_adjoint(one, *r, movable, len(columns)) for r in rows])
        text = f"{where} the adjoint of d {{}} / d {{}}"
        yield from _told(text, given, known, noise, rows, columns)
    if not found.any():
        yield f"{where} no output shows an input at once, so no differences"


def _differences(
    one: Instance, columns: list[tuple[Known, int]], watched: list[Unknown]
) -> tuple[Row, Row]:
    """Return the quotients, shape (unknowns, knowns), and by how much they err."""
    found, noise = [], []
    for known, i in columns:
        at = known.read(one)
        delta = 1e-6 * max(1.0, abs(at[i]))
        sides = []
        for sign in (1, -1):
            moved = at.copy()
            moved[i] += sign * delta
            known.write(one, moved)
            sides.append(np.concatenate([u.read(one) for u in watched]))
        known.write(one, at)
        found.append((sides[0] - sides[1]) / (2 * delta))
        noise.append(1e-6 + 1e-14 * np.abs(sides[0]) / delta)
    return np.array(found).T, np.array(noise).T


def _direction(
    one: Instance, known: Known, place: int, watched: list[Unknown], size: int
) -> list[float]:
    seed = [float(i == place) for i in range(known.variable.size)]
    references = [u.variable.reference for u in watched]
    return one.face.directional(references, known.variable.reference, seed, size)


def _adjoint(
    one: Instance, unknown: Unknown, place: int, movable: list[Known], size: int
) -> list[float]:
    seed = [float(i == place) for i in range(unknown.variable.size)]
    references = [k.variable.reference for k in movable]
    found: list[float] = one.fmu.getAdjointDerivative(
        [unknown.variable.reference], references, seed, nSensitivity=size
    )
    return found


def _told(
    text: str,
    given: Row,
    known: Row | None,
    noise: Row,
    rows: list[tuple[Unknown, int]],
    columns: list[tuple[Known, int]],
) -> Iterator[Said]:
    if known is None:
        return
    for i, j in np.argwhere(np.abs(given - known) > 1e-3 * np.abs(known) + noise):
        names = (_element(*pair) for pair in (rows[i], columns[j]))
        yield Finding(
            f"{text.format(*names)} = {given[i, j]:.6g}, should be {known[i, j]:.6g}"
        )


def _element(of: Known | Unknown, place: int) -> str:
    return f"{of.name}[{place}]" if of.variable.shape else of.name


@dynamic(
    23,
    "Derivatives of inputs and outputs are right or refused",
    "FMI 2.0.5 sections 4.2.1, 4.3.1 (canInterpolateInputs, maxOutputDerivativeOrder); "
    "FMI 3.0.2 section 2.2.12",
    "return Error unless canInterpolateInputs or maxOutputDerivativeOrder promise them",
)
def in_time(lab: Laboratory) -> Iterator[Said]:
    lab.needs_co_simulation()
    inputs = [v for v in lab.variables(causality="input") if v.sort == "real"]
    outputs = lab.sampled(
        "continuous outputs",
        [
            v
            for v in lab.variables(causality="output", variability="continuous")
            if v.sort == "real" and not v.shape
        ],
    )
    if not inputs and not outputs:
        raise NotApplicable("it has no real input and no continuous output")
    if inputs and lab.description.fmi_major == 2:
        yield from _of_input(lab, inputs[0])
    if outputs:
        yield from _of_outputs(lab, outputs)


def _of_input(lab: Laboratory, variable: FmuVariable) -> Iterator[Said]:
    declared = bool(lab.interface.canInterpolateInputs)
    with lab.running() as one:
        lab.trying("setting the derivative of an input")
        reference = [variable.reference]
        status = one.status(one.fmu.setRealInputDerivatives, reference, [1], [0.0])
    if declared and status != OK:
        yield Finding(f"canInterpolateInputs = true, but it returns {told(status)}")
    if not declared and status == OK:
        yield advice("canInterpolateInputs = false, but a derivative is accepted")
    yield f"canInterpolateInputs = {declared}, the call returns {told(status)}"


def _of_outputs(lab: Laboratory, outputs: list[FmuVariable]) -> Iterator[Said]:
    order = int(lab.interface.maxOutputDerivativeOrder or 0)
    references = [v.reference for v in outputs]
    rows = []
    given: list[float] = []
    with lab.running() as one:
        one.run(2 * FROM_START)
        for _ in range(3):  # one-sided differences need a step before and after
            one.run(1, excited=False)
            if one.ended:
                raise NotApplicable("it ends the run in its first steps")
            rows.append(np.array([one.get(v)[0] for v in outputs]))
    with lab.running() as one:  # an Error ends an instance, so it is the last call
        one.run(2 * FROM_START)
        one.run(2, excited=False)
        lab.trying("asking for derivatives of outputs")
        status = one.status(lambda: given.extend(one.face.rates(references)))
    if order == 0 and status == OK:
        yield advice("maxOutputDerivativeOrder = 0, but a derivative is given")
    if order > 0 and status != OK:
        yield Finding(
            f"maxOutputDerivativeOrder = {order}, but the call returns {told(status)}"
        )
    if order > 0 and status == OK:
        slopes = np.diff(rows, axis=0) / lab.h
        slack = np.ptp(slopes, axis=0) + 1e-3 * np.max(np.abs(slopes), axis=0) + 1e-9
        for i, variable in enumerate(outputs):
            if not abs(given[i] - slopes[:, i].mean()) <= 1.5 * slack[i]:
                yield Finding(
                    f"d {variable.name} / d t = {given[i]:.6g}, the steps before and "
                    f"after give {slopes[0, i]:.6g} and {slopes[1, i]:.6g}"
                )
    yield f"maxOutputDerivativeOrder = {order}, the call returns {told(status)}"
