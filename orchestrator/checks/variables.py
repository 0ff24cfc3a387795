"""Static items about variables, structure and units."""

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import numpy as np

from fmus.units import UnitError, base_unit
from orchestrator.checks.archive import Archive
from orchestrator.checks.item import (
    WORDS,
    Finding,
    NotApplicable,
    Said,
    advice,
    static,
)
from orchestrator.fmu.description import FmuVariable

PARAMETERS = ("parameter", "structuralParameter")
SHOWN = 5  # names written out in one finding
ENERGY = {"kg": 1, "m": 2, "s": -2}
FREQUENCY = {"s": -1}
TELL_QUANTITY = (
    'write quantity="Torque", "Energy", "Frequency" or "AngularVelocity", and the '
    "radian into the base units of an angle"
)


@static(
    3,
    "Names are unique and legal, aliases agree",
    "FMI 2.0.5 sections 2.2.7, 2.2.9; FMI 3.0.2 sections 2.4.7, 2.4.9",
    'rename the variable, or declare variableNamingConvention="flat"; give only '
    "one variable of an alias set a start value",
)
def names(fmu: Archive) -> Iterator[Said]:
    for problem in fmu.problems.get(3, ()):
        yield Finding(problem)
    if fmu.major == 2:
        yield from _aliases(fmu.description.variables.values())


def _aliases(variables: Any) -> Iterator[Said]:
    sets: dict[tuple[str, int], list[FmuVariable]] = defaultdict(list)
    for variable in variables:
        sets[variable.sort, variable.reference].append(variable)
    for members in sets.values():
        if len(members) < 2:
            continue
        known = ", ".join(v.name for v in members[:SHOWN])
        constant = {v.variability == "constant" for v in members}
        if len(constant) > 1:
            yield Finding(f"aliases {known}: some are constant, others are not")
        if len({v.unit for v in members}) > 1:
            yield Finding(f"aliases {known}: their units differ")
        starts = [v for v in members if v.start is not None]
        if len(starts) > 1 and constant == {False}:
            yield Finding(f"aliases {known}: more than one has a start value")


@static(
    4,
    "Causality, variability, initial and start go together",
    "FMI 2.0.5 section 2.2.7 (tables); FMI 3.0.2 section 2.4.7.4",
    "give the variable a combination from the standard's table, and a start value "
    "exactly where it asks for one",
)
def roles(fmu: Archive) -> Iterator[Said]:
    for problem in fmu.problems.get(4, ()):
        yield Finding(problem)


@static(
    5,
    "The model structure is complete",
    "FMI 2.0.5 section 2.2.8; FMI 3.0.2 section 2.4.8",
    "list every output, every state derivative, and in InitialUnknowns exactly the "
    "outputs, calculated parameters, states and derivatives that are computed in "
    "initialisation",
)
def structure(fmu: Archive) -> Iterator[Said]:
    for problem in fmu.problems.get(5, ()):
        yield Finding(problem)
    model = fmu.model
    place = {id(v): i for i, v in enumerate(model.modelVariables)}
    for title, unknowns in (
        ("Outputs", model.outputs),
        ("InitialUnknowns", model.initialUnknowns),
    ):
        if fmu.major == 2:
            order = [place.get(id(u.variable), -1) for u in unknowns]
            if order != sorted(order):
                yield Finding(f"ModelStructure/{title} is not in ascending order")
    yield (
        f"{len(model.outputs)} outputs, {len(model.derivatives)} derivatives, "
        f"{len(model.initialUnknowns)} initial unknowns"
    )


@static(
    6,
    "Outputs say what they depend on",
    "FMI 2.0.5 section 2.2.8 (dependencies); FMI 3.0.2 section 2.4.8",
    "write the attribute dependencies; without it an importer has to assume every "
    "input and finds loops that are none",
)
def dependencies_given(fmu: Archive) -> Iterator[Said]:
    description = fmu.description
    if not description.outputs:
        raise NotApplicable("it has no outputs")
    silent = [n for n in description.outputs if description.dependencies.get(n) is None]
    if silent and description.inputs:
        yield advice(f"outputs without dependencies: {_listed(silent)}")


@static(
    7,
    "Units are given and defined",
    "FMI 2.0.5 section 2.2.2; FMI 3.0.2 section 2.4.3; implementers' guide 4.1",
    'give every real variable a unit ("1" if it has none) that UnitDefinitions '
    "defines by its base units, factor and offset",
)
def units(fmu: Archive) -> Iterator[Said]:
    for problem in fmu.problems.get(7, ()):
        yield Finding(problem)
    reals = [
        v
        for v in fmu.description.variables.values()
        if v.sort == "real" and v.causality != "independent"  # in s, whatever it says
    ]
    if bare := [v.name for v in reals if v.unit is None]:
        yield advice(f"{len(bare)} of {len(reals)} without a unit: {_listed(bare)}")
    used = {v.unit: v for v in reals if v.unit is not None}
    for unit, variable in used.items():
        if variable.base_unit is None:
            yield advice(f"unit {unit!r} has no base units, so nobody can convert it")
            continue
        try:
            usual = base_unit(unit)
        except UnitError:
            continue  # a name of their own; the definition counts
        theirs = variable.base_unit
        same = np.isclose(
            [usual.factor, usual.offset], [theirs.factor, theirs.offset], rtol=1e-6
        )
        mine = usual.exponents | {"rad": 0}
        if mine != theirs.exponents | {"rad": 0} or not same.all():
            yield advice(
                f"unit {unit!r} is defined as {_definition(theirs)}, but usually "
                f"means {_definition(usual)}"
            )
    yield from _quantities(fmu)
    yield f"{len(reals)} real variables, {len(used)} units"


def _quantities(fmu: Archive) -> Iterator[Said]:
    """Tell at which inputs and outputs a unit leaves open what is measured.

    N.m and J have the same base units, and so have 1/s and rad/s to whom ignores
    the radian: the wrong connection is converted by 1 without a word.
    """
    open_: dict[str, list[str]] = defaultdict(list)
    for element in fmu.model.modelVariables:
        variable = fmu.description.variables.get(element.name)
        if variable is None or variable.causality not in ("input", "output"):
            continue
        type_ = element.declaredType
        if element.quantity or (type_ is not None and type_.quantity):
            continue
        unit = variable.base_unit
        if unit is None:
            continue
        if unit.exponents == ENERGY:
            open_["a torque or an energy"].append(f"{element.name} ({variable.unit})")
        elif unit.exponents == FREQUENCY and "Hz" not in str(variable.unit):
            open_["a frequency or an angular velocity"].append(
                f"{element.name} ({variable.unit})"
            )
    for what, named in open_.items():
        yield advice(f"{what}, says no quantity: {_listed(named)}", TELL_QUANTITY)


def _definition(unit: Any) -> str:
    powers = ".".join(f"{name}{n}" for name, n in unit.exponents.items()) or "1"
    shift = f" + {unit.offset:g}" if unit.offset else ""
    return f"{unit.factor:.9g} {powers}{shift}"


@static(
    8,
    "Start values lie in their bounds, nominal values are positive",
    "FMI 2.0.5 section 2.2.7; FMI 3.0.2 section 2.4.7; implementers' guide 5.2",
    "correct start, min, max or nominal of the variable named",
)
def bounds(fmu: Archive) -> Iterator[Said]:
    for variable in fmu.description.variables.values():
        yield from _in_bounds(variable)
    for element in fmu.root.iter():
        nominal = element.get("nominal") if isinstance(element.tag, str) else None
        if nominal is not None and not float(nominal) > 0:
            yield Finding(f"line {element.sourceline}: nominal = {nominal}")


def _in_bounds(variable: FmuVariable) -> Iterator[Said]:
    if variable.sort not in ("real", "integer") or variable.fmi_type in WORDS:
        return
    try:
        low = float(variable.min) if variable.min else -np.inf
        high = float(variable.max) if variable.max else np.inf
        start = [float(word) for word in (variable.start or "").split()]
    except ValueError as error:
        yield Finding(f"{variable.name}: {error}")
        return
    if low > high:
        yield Finding(f"{variable.name}: min = {low:g} is more than max = {high:g}")
    for value in start:
        if not np.isfinite(value):
            yield Finding(f"{variable.name}: start = {value}")
        elif not low <= value <= high:
            yield Finding(f"{variable.name}: start = {value:g} is not in its bounds")


@static(
    36,
    "Arrays and clocks are declared in full",
    "FMI 3.0.2 sections 2.4.7, 4.2 (hasEventMode)",
    "give dimensions a start or a structural parameter, clocks an interval, and "
    "set hasEventMode where there are clocks",
)
def arrays_and_clocks(fmu: Archive) -> Iterator[Said]:
    if fmu.major != 3:
        raise NotApplicable("arrays and clocks are of FMI 3")
    parameters = {
        element.get("valueReference")
        for element in fmu.root.iter()
        if element.get("causality") == "structuralParameter"
    }
    for dimension in fmu.root.iter("Dimension"):
        reference = dimension.get("valueReference")
        if reference is not None and reference not in parameters:
            yield Finding(
                f"line {dimension.sourceline}: dimension refers to {reference}, which "
                f"is no structural parameter"
            )
    clocks = list(fmu.root.iter("Clock"))
    for clock in clocks:
        if clock.get("intervalVariability") is None:
            yield Finding(f"clock {clock.get('name')} has no intervalVariability")
        counter, resolution = clock.get("intervalCounter"), clock.get("resolution")
        decimal = clock.get("intervalDecimal")
        if counter and resolution and decimal:
            fraction = int(counter) / int(resolution)
            if not np.isclose(fraction, float(decimal), rtol=1e-9, atol=0):
                yield Finding(
                    f"clock {clock.get('name')}: intervalCounter / resolution = "
                    f"{fraction:.9g} s, but intervalDecimal = {decimal} s"
                )
    simulation = [e for e in fmu.interfaces() if e.tag == "CoSimulation"]
    if clocks and any(e.get("hasEventMode") != "true" for e in simulation):
        yield Finding("there are clocks, but hasEventMode is not true")
    arrays = len({dimension.getparent() for dimension in fmu.root.iter("Dimension")})
    yield f"{arrays} arrays, {len(clocks)} clocks"


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more
