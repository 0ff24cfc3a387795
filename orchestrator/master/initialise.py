"""Bringing all FMUs to their initial state together.

1. instantiate each, write parameters and start values, enter initialisation;
2. in dependency order: write inputs, read outputs, copy;
3. where outputs depend on each other in a circle, solve for the inputs at
   which the circle was opened: Newton (SciPy's hybrid method), else repeated
   substitution; refused with the circle's edges when neither converges;
4. write all inputs, exit initialisation, read and copy once more.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.instances.instance import Instance
from orchestrator.master.layout import Copy, Edge, Part, Wiring
from orchestrator.master.order import initial_order

TOLERANCE = 1e-12
SUBSTITUTIONS = 200

Vector = NDArray[np.float64]


def initialise(
    wiring: Wiring, instances: Mapping[str, Instance], vector: Vector
) -> None:
    """Initialise all instances and fill the vector with the values at t = 0.

    Raises:
        SimulationError: an FMU refuses, or a circle has no solution that is found.
    """
    for name, part in wiring.parts.items():
        _begin(part, instances[name], vector)
    order, opened = initial_order(wiring)
    unknown = _places(wiring, opened)
    if unknown:
        _solve(wiring, instances, vector, order, unknown, opened)
    else:
        _sweep(wiring, instances, vector, order, set())
    for name in wiring.parts:
        instances[name].push()
        instances[name].exit_initialization()
    for name, part in wiring.parts.items():
        _exchange(part, instances[name], vector, part.copies)


def _begin(part: Part, instance: Instance, vector: Vector) -> None:
    instance.instantiate()
    variables = [variable for variable, _ in part.start]
    instance.write(variables, [v for _, values in part.start for v in values])
    start = part.component.offset if part.kind == "sampled" else 0
    instance.enter_initialization(float(start))
    instance.bind(vector, part.inputs, part.first_input, part.read, part.raw)
    last = part.first_input + part.input_size
    vector[part.first_input : last] = instance.read(part.inputs)


def _places(wiring: Wiring, opened: Sequence[Edge]) -> dict[int, Copy]:
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
    for copy in copies:
        affine = copy.affine
        vector[copy.sink] = affine.gain * vector[copy.source] + affine.offset


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


def _solve(
    wiring: Wiring,
    instances: Mapping[str, Instance],
    vector: Vector,
    order: Sequence[str],
    unknown: Mapping[int, Copy],
    opened: Sequence[Edge],
) -> None:
    from scipy.optimize import root

    places, copies = list(unknown), list(unknown.values())

    def around(z: Vector) -> Vector:
        vector[places] = z
        _sweep(wiring, instances, vector, order, set(places))
        values = [c.affine.gain * vector[c.source] + c.affine.offset for c in copies]
        return np.array(values)

    def settled(z: Vector) -> bool:
        difference = np.abs(around(z) - z)
        return bool(np.all(difference <= TOLERANCE * np.maximum(1.0, np.abs(z))))

    start = vector[places].copy()
    newton = root(lambda z: around(z) - z, start, tol=TOLERANCE)
    if newton.success and settled(newton.x):
        return
    z = start
    for _ in range(SUBSTITUTIONS):
        z = around(z)
        if not np.all(np.isfinite(z)):
            break
        if settled(z):
            return
    listed = ", ".join(f"{e.source}.{e.output} -> {e.sink}.{e.input}" for e in opened)
    raise SimulationError(
        f"initialisation: the circle through {listed} has no solution that Newton's "
        f"method or substitution finds; set start values near one, or open the circle"
    )
