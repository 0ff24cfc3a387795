"""One step of a group of components, repeated until what passes between them agrees.

1. the state of every member is kept;
2. all inner inputs are set to z, the rest to what it was given; all members step; z'
   is what their outputs then give the inner inputs;
3. until |z' - z| <= tolerance * max(1, |z|): back to the kept states, and again with
   z' (substitution, ``SWEEPS`` times), then by Newton's method from where the two
   were nearest.

The states in the end are those of the step with z.  A continuous member thus holds,
over its step, what its neighbours give at the end of it; a sampled one reads what they
compute at the same instant.
"""

from collections.abc import Mapping, Sequence
from math import inf, isfinite
from typing import Any

from numpy.typing import NDArray

from orchestrator.errors import SimulationError
from orchestrator.instances.protocol import Instance
from orchestrator.instances.saving import Kept
from orchestrator.master.layout import Group, Part
from orchestrator.master.newton import Refused, newton, settled
from orchestrator.master.places import fitted

SWEEPS = 8

Vector = NDArray[Any]


class Iteration:
    """Steps a group; ``wrote`` is told when a member was given its inputs."""

    def __init__(
        self,
        group: Group,
        parts: Mapping[str, Part],
        instances: Mapping[str, Instance],
        vector: Vector,
    ) -> None:
        self._group, self._vector = group, vector
        self._members = [(parts[n], instances[n]) for n in group.members]
        self._places = [copy.sink for copy in group.inner]
        self._sampled = self._members[0][0].kind == "sampled"
        self._given = {part.name: self._inputs(part) for part, _ in self._members}

    def wrote(self, part: Part) -> None:
        """Remember what a member is given from now on."""
        self._given[part.name] = self._inputs(part)

    def run(self, t: float, h: float) -> None:
        """Step all members from t to t + h; their outputs are in the vector then.

        Raises:
            SimulationError: there is no agreement that is found, or an FMU failed.
        """
        vector, start = self._vector, self._vector[self._places].tolist()
        waiting = {part.name: self._inputs(part) for part, _ in self._members}
        if not self._sampled:  # what is published inside a step waits for its end
            for part, _ in self._members:
                vector[_span(part)] = self._given[part.name]
        kept = [Kept(instance) for _, instance in self._members]
        self._repeated = False

        def around(z: Sequence[float]) -> list[float]:
            if self._repeated:
                for state in kept:
                    state.back()
            self._repeated = True
            vector[self._places] = z
            for _, instance in self._members:
                instance.push()
            for _, instance in self._members:
                instance.step(t, h)
            for _, instance in self._members:
                instance.pull()
            return [fitted(float(vector[c.source]), c.affine, "float64") for c in inner]

        inner = self._group.inner
        if not self._agreed(around, start):
            raise self._refusal(t + h if not self._sampled else t)
        for state in kept:
            state.drop()
        for part, _ in self._members:
            vector[_span(part)] = waiting[part.name]

    def _agreed(self, around: Any, start: list[float]) -> bool:
        """Tell whether inner inputs were found that their outputs agree with."""
        z, tolerance = start, self._group.tolerance
        nearest, least = start, inf
        for _ in range(SWEEPS):
            after = around(z)
            if settled(z, after, tolerance):
                return True
            if not all(map(isfinite, after)):
                break
            off = max(abs(g - one) for g, one in zip(after, z, strict=True))
            if off < least:
                nearest, least = z, off
            z = after

        def finite(z: Sequence[float]) -> list[float]:
            after: list[float] = around(z)
            if not all(map(isfinite, after)):
                raise Refused
            return after

        try:
            return newton(finite, nearest, tolerance) is not None
        except Refused:
            return False

    def _inputs(self, part: Part) -> Vector:
        return self._vector[_span(part)].copy()

    def _refusal(self, t: float) -> SimulationError:
        listed = ", ".join(copy.ends for copy in self._group.inner)
        return SimulationError(
            f"groups.{self._group.name} at t = {t:.9g} s: the loop of {listed} has no "
            f"solution that substitution or Newton's method finds to "
            f"{self._group.tolerance:g}; take smaller steps or a wider tolerance, or "
            f"leave the group out (and give one of its sampled members latency = 1)"
        )


def _span(part: Part) -> slice:
    return slice(part.first_input, part.first_input + part.input_size)
