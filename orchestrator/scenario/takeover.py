"""What a swapped component takes over from the one whose place it takes.

Its variables are ours by name or by map: they keep the unit they had, and the
scenario's values of them hold (scenario < map < ``--set``).  What the other FMU has
not is left, and said.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from fmus.units import UnitError
from orchestrator.errors import ScenarioError, WiringError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.ports import Affine, is_inward, ports
from orchestrator.quantities.unit import Unit, conversion
from orchestrator.scenario.component import ComponentSpec
from orchestrator.scenario.maps import MapSpec
from orchestrator.system import Component, Value
from orchestrator.warned import warn

TABLES = ("parameters", "start")


@dataclass(frozen=True)
class NotTakenOver:
    """A value of the scenario, in our unit, that the other FMU does not take."""

    name: str
    value: Value | str
    unit: str
    why: str

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.name} = {self.value}{unit} is not taken over: {self.why}"


@dataclass(frozen=True)
class Swap:
    """A component's place taken by another FMU.

    ``carried`` are the scenario's own values, by table, that nothing replaced;
    ``used`` the names that the scenario connects, records or sets.
    """

    old: Component
    old_fmu: FmuDescription
    new_fmu: FmuDescription
    carried: Mapping[str, Collection[str]]
    used: Collection[str]

    def take_over(
        self, spec: ComponentSpec
    ) -> tuple[ComponentSpec, list[NotTakenOver]]:
        """Return the new component's table with units of ours, and what is left.

        Raises:
            ScenarioError: a mapped variable cannot be had in our unit.
        """
        spec = spec.model_copy(update={"map": dict(self._map(spec))})
        left = [
            self._left(spec, table, key, why)
            for table in TABLES
            for key in self.carried.get(table, ())
            if (why := self._refusal(spec, key))
        ]
        gone = {one.name.partition(".")[2] for one in left}
        kept = {
            table: {k: v for k, v in getattr(spec, table).items() if k not in gone}
            for table in TABLES
        }
        return spec.model_copy(update=kept), left

    def _map(self, spec: ComponentSpec) -> Iterator[tuple[str, MapSpec]]:
        """Yield the map with the unit that every variable had by our name."""
        ours = dict.fromkeys((*spec.map, *self.old.map, *self.old_fmu.variables))
        for name in ours:
            mapped = spec.map.get(name, MapSpec(name=name))
            theirs = self.new_fmu.variables.get(mapped.name)
            unit = self._unit(name)
            if theirs is not None and unit is not None and mapped.unit is None:
                try:
                    found = self._in_unit(name, mapped, theirs, unit)
                    if found != MapSpec(name=name):
                        yield name, found
                except UnitError as error:
                    if name in spec.map or name in self.used:
                        raise ScenarioError(
                            f"components.{self.old.name}.map: {name}: {error}; say "
                            f'by a gain what it is, with unit = "{unit}"'
                        ) from None
            elif name in spec.map:
                yield name, mapped

    def _unit(self, name: str) -> Unit | None:
        try:
            return ports(self.old, self.old_fmu, name)[0].unit
        except WiringError:  # a variable of the other FMU alone
            return None

    def _in_unit(
        self, name: str, mapped: MapSpec, theirs: FmuVariable, unit: Unit
    ) -> MapSpec:
        if isinstance(mapped.gain, str):  # worked out later, into this unit
            return mapped.model_copy(update={"unit": unit})
        given = Affine(mapped.gain or 1.0, mapped.offset or 0.0)
        doubts: tuple[str, ...] = ()
        if theirs.unit is None:
            if name in self.used and unit != "1":
                warn(
                    f"{self.old.name}.{name}: {theirs.name} of "
                    f"{self.new_fmu.path.name} has no unit; its numbers are taken "
                    f"as {unit}"
                )
            whole = given
        elif is_inward(theirs):
            gain, offset, doubts = conversion(unit, theirs.unit)
            whole = Affine(gain, offset).then(given)
        else:
            gain, offset, doubts = conversion(theirs.unit, unit)
            whole = given.then(Affine(gain, offset))
        if whole == Affine() and (theirs.unit, mapped.name) == (unit, name):
            return mapped
        if mapped.gain is None and mapped.offset is None and theirs.unit is not None:
            return mapped.model_copy(update={"unit": unit})
        for doubt in doubts:
            warn(f"components.{self.old.name}.map: {name}: {doubt}")
        found = {"gain": whole.gain, "offset": whole.offset, "unit": unit}
        return mapped.model_copy(update=found)

    def _refusal(self, spec: ComponentSpec, name: str) -> str | None:
        """Return why a value cannot be written to the other FMU; None if it can."""
        maps = {name: one.mapped() for name, one in spec.map.items()}
        there = Component(self.old.name, self.new_fmu.path, self.old.period, map=maps)
        try:
            found = ports(there, self.new_fmu, name)
        except WiringError:
            theirs = self.new_fmu.path.name
            return f"{theirs} has no variable {name!r}; name it in the map"
        before = ports(self.old, self.old_fmu, name)
        if len(found) != len(before):
            return f"there it has {len(found)} numbers, not {len(before)}"
        for port in found:
            v = port.variable
            settable = is_inward(v) or v.initial in ("exact", "approx")
            if not settable or v.variability == "constant":
                return f"{v.name} is a {v.variability} {v.causality} there"
        return None

    def _left(
        self, spec: ComponentSpec, table: str, name: str, why: str
    ) -> NotTakenOver:
        unit = self._unit(name) or "1"
        value = getattr(spec, table)[name]
        return NotTakenOver(f"{self.old.name}.{name}", value, str(unit), why)
