"""Dynamic items: derivatives that an FMU gives or takes."""

from collections.abc import Iterator

import numpy as np

from orchestrator.checks.item import Finding, NotApplicable, Said, advice, dynamic
from orchestrator.checks.laboratory import OK, STATUS, Instance, Laboratory, start_of
from orchestrator.fmu import FmuVariable


@dynamic(
    22,
    "Directional derivatives are those of the model",
    "FMI 2.0.5 section 2.1.9; FMI 3.0.2 (directional derivatives)",
    "differentiate the equations that are evaluated",
)
def directional(lab: Laboratory) -> Iterator[Said]:
    lab.needs("providesDirectionalDerivative")
    unknowns = [u.variable.name for u in lab.model.outputs]
    outputs = [lab.description[n] for n in unknowns if not lab.description[n].shape]
    inputs = [
        v for v in lab.variables(causality="input") if v.sort == "real" and not v.shape
    ]
    outputs = [v for v in outputs if v.sort == "real"]
    if not inputs or not outputs:
        raise NotApplicable("it has no scalar real input or output")
    with lab.instance() as one:
        one.enter()
        for variable in inputs:
            yield from _one_direction(one, variable, outputs)


def _one_direction(
    one: Instance, known: FmuVariable, unknowns: list[FmuVariable]
) -> Iterator[Said]:
    at = (start_of(known) or [0.0])[0]
    delta = 1e-6 * max(1.0, abs(at))
    references = [v.reference for v in unknowns]
    one.lab.trying(f"asking for derivatives with respect to {known.name}")
    exact = one.fmu.getDirectionalDerivative(references, [known.reference], [1.0])
    sides = []
    for sign in (1, -1):
        one.set(known, [at + sign * delta])
        sides.append([one.get(v)[0] for v in unknowns])
    one.set(known, [at])
    quotient = (np.array(sides[0]) - np.array(sides[1])) / (2 * delta)
    for variable, given, found in zip(unknowns, exact, quotient, strict=True):
        if not np.isclose(given, found, rtol=1e-3, atol=1e-6):
            yield Finding(
                f"d {variable.name} / d {known.name} = {given:.6g}, differences give "
                f"{found:.6g}"
            )


@dynamic(
    23,
    "Derivatives of inputs are used or refused",
    "FMI 2.0.5 sections 4.2.1, 4.3.1 (canInterpolateInputs)",
    "return Error from fmi2SetRealInputDerivatives unless canInterpolateInputs",
)
def input_derivatives(lab: Laboratory) -> Iterator[Said]:
    lab.needs_co_simulation()
    inputs = [v for v in lab.variables(causality="input") if v.sort == "real"]
    if lab.description.fmi_major != 2 or not inputs:
        raise NotApplicable("it is of FMI 3 or has no real input")
    declared = bool(lab.interface.canInterpolateInputs)
    with lab.running() as one:
        lab.trying("setting the derivative of an input")
        reference = [inputs[0].reference]
        status = one.status(one.fmu.setRealInputDerivatives, reference, [1], [0.0])
    if declared and status != OK:
        yield Finding(f"canInterpolateInputs = true, but it returns {STATUS[status]}")
    if not declared and status == OK:
        yield advice("canInterpolateInputs = false, but a derivative is accepted")
    yield f"canInterpolateInputs = {declared}, the call returns {STATUS[status]}"
