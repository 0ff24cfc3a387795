"""What a swapped component takes over from the one whose place it takes.

Its variables are ours by name or by map: they keep the unit they had, and the
scenario's values of them hold (scenario < map < ``--set``).  Where the map says another
unit, numbers that were written in ours are converted; those of the map are in its own.
What the other FMU has not is left, and said.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from fmus.units import UnitError
from orchestrator.errors import ScenarioError, WiringError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.ports import Affine, Port, is_inward, ports
from orchestrator.quantities.unit import Unit, conversion, unit_of
from orchestrator.scenario.component import ComponentSpec
from orchestrator.scenario.maps import MapSpec
from orchestrator.scenario.rewritten import Units, rewritten
from orchestrator.system import Component, Value, split_name
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
    ``used`` the names that the scenario connects, records or sets; ``own`` those of
    the values that came with the other FMU, in the unit its map says.  Without a
    ``map`` for it, by ``--set``, a variable that cannot be had in our unit has its own.
    """

    old: Component
    old_fmu: FmuDescription
    new_fmu: FmuDescription
    carried: Mapping[str, Collection[str]]
    used: Collection[str]
    own: Collection[str] = ()
    mapped: bool = True

    def take_over(
        self, spec: ComponentSpec
    ) -> tuple[ComponentSpec, list[NotTakenOver]]:
        """Return the new component's table with units of ours, and what is left.

        Raises:
            ScenarioError: a mapped variable cannot be had in our unit, or a value in
                that of the map.
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
        for table, values in kept.items():
            where = f"components.{self.old.name}.{table}."
            kept[table] = self.rewritten(spec, where, values)
        return spec.model_copy(update=kept), left

    def rewritten(
        self, spec: ComponentSpec, where: str, values: Mapping[str, Value]
    ) -> dict[str, Value]:
        """Return values by name, written in our units, in those of the new component.

        ``spec`` is its table; ``where`` and a name are the place of a value.

        Raises:
            ScenarioError: one cannot be converted.
        """
        found = dict(values)
        for name, value in values.items():
            before, now = self._units(name), self._units_now(spec, name)
            if before and now and name not in self.own:
                found[name] = rewritten(f"{where}{name}", value, before, now)
        return found

    def refuse_faults(self, spec: ComponentSpec, faults: Collection[str]) -> None:
        """Refuse faults with a number for an input that has another unit now.

        Raises:
            ScenarioError: there is one.
        """
        for full in faults:
            owner, name = split_name(full)
            if owner != self.old.name:
                continue
            where = f'faults."{full}"'
            if self.rewritten(spec, where, {name: 1.0})[name] != 1.0:
                raise ScenarioError(
                    f"{where}: its value is in {self._unit(name)}, and the map gives "
                    f"{name} another unit; leave the unit out of the map, and it keeps "
                    f"ours"
                )

    def _map(self, spec: ComponentSpec) -> Iterator[tuple[str, MapSpec]]:
        """Yield the map with the unit that every variable had by our name.

        An array, or a record, is one variable where all its numbers have one unit.
        """
        said = {*spec.map, *self.used, *spec.parameters, *spec.start}
        ours = (*spec.map, *self.old.map, *self.old_fmu.variables, *sorted(said))
        for name in dict.fromkeys(ours):
            if name not in said and not self._has(name):
                continue
            mapped = spec.map.get(name, MapSpec(name=name))
            if name in spec.map and not self.mapped:
                yield name, mapped
                continue
            theirs = _alike(self._theirs(mapped.name))
            unit = self._unit(name)
            if theirs is not None and unit is not None and mapped.unit is None:
                try:
                    found = self._in_unit(name, mapped, theirs, unit)
                    if found != MapSpec(name=name):
                        yield name, found
                except UnitError as error:
                    if self.mapped and (name in spec.map or name in self.used):
                        raise ScenarioError(
                            f"components.{self.old.name}.map: {name}: {error}; say "
                            f'by a gain what it is, with unit = "{unit}"'
                        ) from None
            elif name in spec.map:
                yield name, mapped

    def _theirs(self, name: str) -> list[Port]:
        """Return the numbers of the other FMU by its own name; none if it has not."""
        there = Component(self.old.name, self.new_fmu.path, self.old.period)
        return _known(there, name, self.new_fmu)

    def _has(self, name: str) -> bool:
        """Tell whether the other FMU has a variable, or its array, of a name."""
        known = self.new_fmu.variables
        return name in known or name.rpartition("[")[0] in known

    def _units(self, name: str) -> Units:
        """Return the units of our numbers of a name; none where it is not ours."""
        return [port.unit for port in _known(self.old, name, self.old_fmu)]

    def _units_now(self, spec: ComponentSpec, name: str) -> Units:
        """Return the units of the numbers of a name beside the other FMU."""
        mapped = spec.map.get(name)
        if mapped is not None and isinstance(mapped.gain, str):  # worked out later
            return [unit_of(mapped.unit) if mapped.unit else None]
        return [port.unit for port in _known(self._there(spec), name, self.new_fmu)]

    def _there(self, spec: ComponentSpec) -> Component:
        maps = {name: one.mapped() for name, one in spec.map.items()}
        return Component(self.old.name, self.new_fmu.path, self.old.period, map=maps)

    def _unit(self, name: str) -> Unit | None:
        units = self._units(name)
        return units[0] if len(set(units)) == 1 else None

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
        try:
            found = ports(self._there(spec), self.new_fmu, name)
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


def _known(component: Component, name: str, fmu: FmuDescription) -> list[Port]:
    """Return the numbers of a name, none where the component has no such variable."""
    try:
        return ports(component, fmu, name)
    except WiringError:
        return []


def _alike(found: list[Port]) -> FmuVariable | None:
    """Return the variable of numbers, or one of several of one unit and direction."""
    kinds = {(port.variable.unit, is_inward(port.variable)) for port in found}
    return found[0].variable if len(kinds) == 1 else None
