"""Parameters of a package, found their variables and made the FMUs' own numbers.

Bindings of an outer system go before those inside it, a later one before an earlier
one.  A name that fits nothing sets nothing, as SSP has it; it is noted.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from orchestrator.errors import FeedDriveError, ScenarioError
from orchestrator.exchange.ssp.flat import Edge, Flat, Node, Path
from orchestrator.exchange.ssp.looked import looked_up
from orchestrator.exchange.ssp.passage import Hop, passed
from orchestrator.exchange.ssp.records import Binding, Given, Looked, Mapped
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.ports import Affine, ports
from orchestrator.quantities.unit import Unit
from orchestrator.system import Component, Scalar, Value


@dataclass(frozen=True)
class Setting:
    """A value of a variable, as the FMU gets it, and the parameter it was."""

    value: Value
    given: Given
    mapped: Mapped | None


@dataclass
class Settings:
    """What is set on every component, by the names of its FMU."""

    flat: Flat
    fmus: Mapping[Path, FmuDescription]
    faults: list[str]
    notes: list[str]
    found: dict[Path, dict[str, Setting]] = field(default_factory=dict)

    def collect(self) -> None:
        """Apply all bindings, from the innermost out."""
        for path in sorted(self.flat.parts, key=len, reverse=True):
            for binding in self.flat.parts[path].bindings:
                self._apply(path, binding)
        for path in sorted(self.flat.systems, key=len, reverse=True):
            for binding in self.flat.systems[path].bindings:
                self._apply(path, binding)

    def _apply(self, path: Path, binding: Binding) -> None:
        unused = []
        for given, mapped in _mapped(binding):
            target = mapped.target if mapped else given.name
            try:
                if not self._set(path, target, given, mapped):
                    unused.append(target)
            except FeedDriveError as error:
                self.faults.append(f"{binding.where}: {given.name}: {error}")
        if unused:
            shown = ", ".join(unused[:3]) + (", ..." if len(unused) > 3 else "")
            self.notes.append(
                f"{binding.where}: {len(unused)} parameters fit no variable and set "
                f"nothing: {shown}"
            )

    def _set(self, path: Path, name: str, given: Given, mapped: Mapped | None) -> bool:
        """Set what a name of an element stands for; tell whether there is any."""
        if path in self.flat.parts:
            return self._set_variable(path, name, given, mapped, [])
        if name in self.flat.systems[path].connectors:
            ways = list(self.flat.ends((path, name)))
            for way in ways:
                owner, variable = way[-1].sink
                self._set_variable(owner, variable, given, mapped, way)
            return bool(ways)
        elements = self.flat.systems[path].elements
        fitting = [e for e in elements if name.startswith(f"{e}.")]
        return any(
            self._set((*path, one), name[len(one) + 1 :], given, mapped)
            for one in sorted(fitting, key=len, reverse=True)
        )

    def _set_variable(
        self,
        path: Path,
        name: str,
        given: Given,
        mapped: Mapped | None,
        way: list[Edge],
    ) -> bool:
        fmu = self.fmus.get(path)
        if fmu is None or name not in fmu.variables:
            return fmu is None  # of what is refused anyway nothing more is said
        variable = fmu.variables[name]
        first = way[0].source if way else (path, name)
        at_border = self.flat.connector(first)
        unit = at_border.unit if way and at_border else self.unit((path, name))
        hops = []
        if mapped:
            where = f"{mapped.source} -> {mapped.target}"
            how = mapped.how
            if isinstance(how, Looked):
                given, how = looked_up(given, how), None
            hops = [Hop(unit, how, mapped.suppress, where)]
        elif given.unit is not None:
            hops = [Hop(unit, None, False, given.name)]
        hops += list(self.hops(way))
        start = unit if given.unit is None and mapped is None else given.unit
        affine, _ = passed(start, hops)
        if given.unit is not None and not (mapped and mapped.suppress):
            self._note_unknown(".".join((*path, name)), given.unit, unit)
        value = _value(given, variable, affine)
        self.found.setdefault(path, {})[name] = Setting(value, given, mapped)
        return True

    def _note_unknown(self, where: str, given: Unit, unit: Unit | None) -> None:
        if str(given) == str(unit) or (unit and unit.base and given.base):
            return
        own = f"in {unit} there" if unit else "without a unit there"
        unknown = ", and not both are defined" if unit else ""
        self.notes.append(
            f"{where}: given in {given}, {own}{unknown}: the number is taken as it is"
        )

    def hops(self, way: list[Edge]) -> Iterator[Hop]:
        """Yield what the edges of a way do with numbers."""
        for edge in way:
            written = edge.written
            yield Hop(
                self.unit(edge.sink), written.how, written.suppress, written.where
            )

    def unit(self, node: tuple[Path, str]) -> Unit | None:
        """Return the unit at a connector: that of the FMU's variable, if it says one.

        Raises:
            ScenarioError: the connector says another.
        """
        path, name = node
        connector = self.flat.connector(node)
        declared = connector.unit if connector else None
        fmu = self.fmus.get(path)
        if fmu is None or name not in fmu.variables:
            return declared
        own = fmu.variables[name].unit
        if own is None or own.base is None:
            return declared or own
        if declared is not None and declared.base not in (None, own.base):
            raise ScenarioError(
                f"{'.'.join((*path, name))}: the connector says {declared}, the FMU "
                f"{own}; correct the connector"
            )
        return own

    def through(self, value_of: Callable[[Path, str], Value | None]) -> None:
        """Hand values of parameters on to the parameters they are connected to."""
        done: set[Node] = set()
        for sink in self.flat.fed:
            self._hand_on(sink, value_of, done)

    def _hand_on(
        self, sink: Node, value_of: Callable[[Path, str], Value | None], done: set[Node]
    ) -> None:
        path, name = sink
        fmu = self.fmus.get(path)
        if sink in done or fmu is None or name not in fmu.variables:
            return
        done.add(sink)
        way = self.flat.way(sink)
        owner, source = way[0].source
        theirs = self.fmus.get(owner)
        if theirs is None or source not in theirs.variables:
            return
        variable = theirs.variables[source]
        if variable.causality != "parameter":
            return
        if way[0].source in self.flat.fed:
            self._hand_on(way[0].source, value_of, done)
        where = way[-1].written.where
        value = value_of(owner, source)
        if value is None:
            self.faults.append(f"{where}: {source} has no value to hand on")
            return
        words = tuple(map(_word, value if isinstance(value, tuple) else (value,)))
        given = Given(source, variable.fmi_type, words)
        try:
            affine, _ = passed(self.unit(way[0].source), self.hops(way))
            own = _value(given, fmu.variables[name], affine)
        except FeedDriveError as error:
            self.faults.append(f"{where}: {error}")
            return
        self.found.setdefault(path, {})[name] = Setting(own, given, None)


def _word(value: Scalar) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _mapped(binding: Binding) -> Iterator[tuple[Given, Mapped | None]]:
    if binding.mapping is None:
        for given in binding.given:
            yield given, None
        return
    by_name = {given.name: given for given in binding.given}
    for entry in binding.mapping:
        if entry.source in by_name:
            yield by_name[entry.source], entry


def _value(given: Given, variable: FmuVariable, affine: Affine) -> Value:
    """Return a parameter's words as a variable's value.

    Raises:
        ScenarioError: they are none, or not as many as it has.
    """
    if len(given.words) not in (1, variable.size) or not given.words:
        raise ScenarioError(
            f"{len(given.words)} values for {variable.name}, which has {variable.size}"
        )
    values = tuple(_scalar(word, given, variable, affine) for word in given.words)
    if len(values) == 1 and variable.size > 1:
        values *= variable.size
    return values if variable.shape else values[0]


def _scalar(word: str, given: Given, variable: FmuVariable, affine: Affine) -> Scalar:
    wrong = f"{given.type} {word!r} for {variable.name}, which is {variable.kind}"
    sort = variable.sort
    if affine.converts and (sort not in ("real", "integer") or variable.declared.items):
        raise ScenarioError(f"{wrong}, and no number that can be transformed")
    if variable.is_text:
        if (given.type == "Binary") != (sort == "binary"):
            raise ScenarioError(wrong)
        return word
    if variable.declared.items:
        names = [item.name for item in variable.declared.items]
        if given.type == "Enumeration" and word in names:
            return word
        return int(word) if word.lstrip("-").isdecimal() else word
    truth = {"true": True, "1": True, "false": False, "0": False}
    if sort == "boolean" or given.type == "Boolean":
        if word.lower() not in truth or sort != "boolean":
            raise ScenarioError(wrong)
        return truth[word.lower()]
    try:
        number: float = int(word) if word.lstrip("+-").isdecimal() else float(word)
    except ValueError:
        raise ScenarioError(wrong) from None
    if affine.converts:
        number = affine.gain * float(number) + affine.offset
    if sort == "integer":
        if number != number // 1:
            raise ScenarioError(f"{wrong}: {number} is no whole number")
        return int(number)
    return float(number)


def regrouped(
    part: Component, fmu: FmuDescription, ours: str, settings: dict[str, Setting]
) -> Value | None:
    """Take the value of one of our names out of settings by the FMU's names."""
    try:
        found = ports(part, fmu, ours)
    except FeedDriveError:
        return None
    names = [port.variable.name for port in found]
    if any(name not in settings for name in names):
        return None
    first = settings[names[0]]
    if len(found) == 1 and first.mapped and first.mapped.source == ours:
        del settings[names[0]]
        return float(first.given.words[0])
    if any(port.to_theirs.converts for port in found):
        return None
    values: list[Any] = []
    for port in found:
        value = settings[port.variable.name].value
        values.append(value[port.element] if isinstance(value, tuple) else value)
    for name in dict.fromkeys(names):
        del settings[name]
    return tuple(values) if len(values) > 1 else values[0]
