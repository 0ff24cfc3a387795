"""Bringing all FMUs to their initial state together.

1. instantiate each, set up its experiment, write parameters and start values, enter
   initialisation; an FMU that refuses this without a stop time is made anew with it;
2. in dependency order: write inputs, read outputs, copy;
3. where outputs depend on each other in a circle, solve for the inputs at
   which the circle was opened: repeated substitution, which reaches a fixed point
   to the last bit where it gets there, else Newton's method (``newton.py``);
   refused with the circle's edges when neither converges;
4. write all inputs, exit initialisation, compare what was written with what the
   FMU holds (``kept.py``), switch its logging off, read and copy once more.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.instances.protocol import Instance
from orchestrator.master.kept import held, refuse_changed
from orchestrator.master.layout import Edge, Part, Wiring
from orchestrator.master.newton import TOLERANCE, Refused, newton
from orchestrator.master.order import initial_order
from orchestrator.master.places import Copy, carry, fitted, store, views
from orchestrator.master.texts import publish
from orchestrator.warned import warn

SUBSTITUTIONS = 200

Vector = NDArray[np.float64]


def initialise(
    wiring: Wiring,
    instances: Mapping[str, Instance],
    vector: Vector,
    *,
    quiet: bool = True,
) -> None:
    """Initialise all instances and fill the vector with the values at t = 0.

    ``quiet``: from then on the FMUs log errors only.

    Raises:
        SimulationError: an FMU refuses, or a circle has no solution that is found.
    """
    for name, part in wiring.parts.items():
        _begin(part, instances[name], vector, wiring.system.stop)
    order, opened = initial_order(wiring)
    unknown = places_opened(wiring, opened)
    if unknown:
        _solve(wiring, instances, vector, order, unknown, opened)
    else:
        _sweep(wiring, instances, vector, order, set())
    for name, part in wiring.parts.items():
        instance = instances[name]
        instance.push()
        before = held(part, instance)
        instance.exit_initialization()
        refuse_changed(part, before, held(part, instance))
        if quiet:
            instance.quiet()
    for name, part in wiring.parts.items():
        _exchange(part, instances[name], vector, part.copies)


def _begin(part: Part, instance: Instance, vector: Vector, stop: Fraction) -> None:
    told = float(stop) if part.component.experiment.stop else None
    instance.instantiate()
    try:
        _enter(part, instance, told)
    except SimulationError as refused:
        if told is not None:
            raise
        try:
            instance.instantiate()
            _enter(part, instance, float(stop))
        except SimulationError:
            raise refused from None
        warn(
            f"{part.name} ({part.fmu.path.name}) refuses its experiment without a stop "
            f"time: it was handed the stop, {float(stop):.9g} s; write experiment = "
            f"{{ stop = true }} to hand it over at once"
        )
    instance.bind(vector, part.inputs, part.first_input, part.read, part.raw)
    store(vector, part.first_input, part.inputs, instance.read(part.inputs))


def _enter(part: Part, instance: Instance, stop: float | None) -> None:
    """Bring a new instance into initialisation."""
    start = part.component.offset if part.kind == "sampled" else 0
    instance.set_up(float(start), stop, part.component.experiment.tolerance)
    variables = [variable for variable, _ in part.start]
    instance.write(variables, [v for _, values in part.start for v in values])
    instance.enter_initialization()


def places_opened(wiring: Wiring, opened: Sequence[Edge]) -> dict[int, Copy]:
    """Return the copies that carry the opened edges, by their place of arrival."""
    pairs = {(e.source, e.sink) for e in opened}
    return {
        copy.sink: copy
        for source, sink in pairs
        for copy in wiring.parts[source].copies
        if _owns(wiring.parts[sink], copy.sink)
    }


def _owns(part: Part, place: int) -> bool:
    return part.first_input <= place < part.first_input + part.input_size


def _exchange(
    part: Part, instance: Instance, vector: Vector, copies: Sequence[Copy]
) -> None:
    instance.pull()
    raw = vector[part.raw : part.raw + part.read_size]
    vector[part.published : part.published + part.read_size] = raw
    seen = views(vector)
    for copy in copies:
        carry(copy, seen, 0.0)


def _sweep(
    wiring: Wiring,
    instances: Mapping[str, Instance],
    vector: Vector,
    order: Sequence[str],
    without: set[int],
) -> None:
    """Evaluate all components once, not copying to the places left out."""
    for name in order:
        part = wiring.parts[name]
        instances[name].push()
        copies = [c for c in part.copies if c.sink not in without]
        _exchange(part, instances[name], vector, copies)
        publish(wiring, instances, name)


def _solve(
    wiring: Wiring,
    instances: Mapping[str, Instance],
    vector: Vector,
    order: Sequence[str],
    unknown: Mapping[int, Copy],
    opened: Sequence[Edge],
) -> None:
    places, copies = list(unknown), list(unknown.values())
    start = vector[places].copy()
    real = all(is_real(wiring, place) for place in places)
    try:
        if _substitute(wiring, instances, vector, order, places, copies):
            return
    except SimulationError:  # far from a solution an FMU may refuse anything
        if not real:
            raise
    vector[places] = start
    if real and _newton(wiring, instances, vector, order, places, copies):
        return
    listed = ", ".join(f"{e.source}.{e.output} -> {e.sink}.{e.input}" for e in opened)
    raise SimulationError(
        f"initialisation: the circle through {listed} has no solution that "
        f"substitution or Newton's method finds; set start values near one, or open "
        f"the circle"
    )


def _substitute(
    wiring: Wiring,
    instances: Mapping[str, Instance],
    vector: Vector,
    order: Sequence[str],
    places: list[int],
    copies: list[Copy],
) -> bool:
    """Go round a circle until nothing moves; tell whether that was reached.

    Raises:
        SimulationError: an FMU refuses what it is given on the way.
    """
    seen = views(vector)
    for _ in range(SUBSTITUTIONS):
        before = vector[places].copy()
        _sweep(wiring, instances, vector, order, set(places))
        for copy in copies:
            carry(copy, seen, 0.0)
        if _settled(before, vector[places]):
            return True
        doubles = [copy.sink for copy in copies if copy.to == "float64"]
        if not np.all(np.isfinite(vector[doubles])):
            return False
    return False


def is_real(wiring: Wiring, place: int) -> bool:
    """Tell whether the input at a place is a real number: others have no slope."""
    part = next(p for p in wiring.parts.values() if _owns(p, place))
    owners = [v for v in part.inputs for _ in range(v.size)]
    return owners[place - part.first_input].sort == "real"


def _newton(
    wiring: Wiring,
    instances: Mapping[str, Instance],
    vector: Vector,
    order: Sequence[str],
    places: list[int],
    copies: list[Copy],
) -> bool:
    """Seek the inputs of a circle; tell whether they were found, else leave them.

    Raises:
        SimulationError: an FMU refuses what it is given.
    """
    seen = views(vector)

    def around(z: Sequence[float]) -> Sequence[float]:
        vector[places] = z
        try:
            _sweep(wiring, instances, vector, order, set(places))
        except SimulationError as error:
            raise Refused from error
        values = [fitted(seen[c.from_][c.source], c.affine, c.to) for c in copies]
        if not np.all(np.isfinite(values)):
            raise Refused
        return values

    start = vector[places].tolist()
    try:
        found = newton(around, start)
    except Refused as refused:
        if refused.__cause__ is not None:
            raise refused.__cause__ from None
        found = None
    if found is None:
        vector[places] = start
    return found is not None


def _settled(before: Vector, after: Vector) -> bool:
    """Tell whether numbers are the same, doubles up to the tolerance."""
    close = np.abs(after - before) <= TOLERANCE * np.maximum(1.0, np.abs(before))
    return bool(np.all(close | (before.view(np.int64) == after.view(np.int64))))
