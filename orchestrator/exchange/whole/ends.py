"""The variables of a composition as one FMU: outputs, inputs, parameters, states."""

from collections.abc import Iterator, Sequence
from functools import cached_property

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.exchange.whole.foreign import WholeSource
from orchestrator.exchange.whole.tables import Outside, Starts
from orchestrator.fmu.description import FmuVariable
from orchestrator.fmu.ports import Affine, ports
from orchestrator.master.fused.own import Own
from orchestrator.master.layout import Part, kind_of
from orchestrator.system import split_name


class Ends:
    """Finds them; ``starts`` are the values of every component before initialisation.

    Raises:
        ScenarioError: there is no such input.
    """

    def __init__(
        self,
        source: WholeSource,
        starts: Starts,
        inputs: Sequence[str],
        *,
        clocked: bool,
    ) -> None:
        self._source, self._starts, self._inputs = source, starts, inputs
        self._late = "read an outer step late"
        if clocked:
            self._late += ", but at once by the clock of FMI 3"
        self._parts = source.wiring.parts

    def outside(self) -> list[Outside]:
        """Return all variables in the order of their references.

        A parameter, input or state that is recorded too is there once: what is set
        goes before what is shown, and that before states.

        Raises:
            ScenarioError: two different ones would have one name.
        """
        given = [
            *self._of_components("parameter"),
            *(p for one in self._source.foreign.values() for p in one.parameters()),
            *(self._input(name) for name in self._inputs),
        ]
        names = {one.name for one in given}
        shown = [one for one in self._outputs() if not self._again(one, names)]
        names |= {one.name for one in shown}
        states = self._of_components("local")
        return [*given, *shown, *(s for s in states if not self._again(s, names))]

    def _again(self, one: Outside, names: set[str]) -> bool:
        """Tell whether the variable of that name is there already."""
        if one.name not in names:
            return False
        component, name = split_name(one.name)
        part = self._parts[component]
        if name in part.component.map:
            raise ScenarioError(
                f"{one.name} is the name of two variables outside, as the map of "
                f"{component} calls one like another of its FMU; rename it in the map"
            )
        return True

    def _of_components(self, role: str) -> Iterator[Outside]:
        """Yield parameters, or states (local), of all components."""
        for name, own in self._source.own.items():
            for v in own.part.fmu.variables.values():
                if _is(v, own, role):
                    yield from self._elements(name, own, v, role)

    def _elements(
        self, name: str, own: Own, v: FmuVariable, role: str
    ) -> Iterator[Outside]:
        for i in range(v.size):
            place = v.reference + i
            index = f"[{i + 1}]" if v.shape else ""
            yield Outside(
                f"{name}.{v.name}{index}",
                "parameter" if role == "parameter" else "local",
                f"values_{own.index}[{place}]",
                Affine(),
                v.unit,
                v.sort == "boolean",
                float(self._starts[name][place]),
                v.description,
            )

    def _outputs(self) -> Iterator[Outside]:
        for columns in self._source.wiring.tables.values():
            for column in columns:
                component, name = split_name(column.name)
                part = self._parts[component]
                (port, *_) = ports(part.component, part.fmu, name)
                yield Outside(
                    column.name,
                    "output",
                    f"vector[{column.index}]",
                    column.affine,
                    column.unit,
                    port.variable.sort == "boolean",
                    None,
                    port.variable.description,
                    self._needed(component, port.variable),
                )

    def _input(self, full: str) -> Outside:
        component, name = split_name(full)
        if component not in self._parts or not name:
            remedy = did_you_mean(component, self._parts)
            raise ScenarioError(
                f"--inputs {full}: no component {component!r}; {remedy}"
            )
        part = self._parts[component]
        (port, *more) = ports(part.component, part.fmu, name)
        if port.variable.causality != "input" or more:
            raise ScenarioError(f"--inputs {full}: is no single input of {component}")
        late = kind_of(part.component, part.fmu) == "sampled"
        when = self._late if late else "acts from the step it is set"
        number = self._source.parts.index(component)
        if component in self._source.foreign:
            place = self._source.foreign[component].slot(port.variable.name)
        else:
            place = port.variable.reference + port.element
        return Outside(
            full,
            "input",
            f"values_{number}[{place}]",
            port.to_theirs,
            port.unit,
            port.variable.sort == "boolean",
            _outer(float(self._starts[component][place]), port.to_theirs),
            f"{port.variable.description} ({when})",
        )

    # what outputs depend on within an instant

    def _needed(self, component: str, variable: FmuVariable) -> frozenset[str]:
        part, name = self._parts[component], variable.name
        if variable.causality == "input":
            return self._of_input(component, name)
        if kind_of(part.component, part.fmu) != "sampled":
            return frozenset()
        if variable.causality != "output":  # a state is that after the tick
            return self._of_inputs(component, None)
        if part.component.latency:
            return frozenset()
        return self._of_inputs(component, part.fmu.dependencies.get(name))

    def _of_inputs(
        self, component: str, names: frozenset[str] | None
    ) -> frozenset[str]:
        inputs = self._parts[component].fmu.inputs if names is None else names
        found = (self._of_input(component, name) for name in inputs)
        return frozenset[str]().union(*found)

    def _of_input(self, component: str, name: str) -> frozenset[str]:
        part = self._parts[component]
        here = frozenset(
            full
            for full in self._inputs
            if split_name(full)[0] == component
            and _named(part, split_name(full)[1]) == name
        )
        sources = self._sources.get((component, name), ())
        needed = (self._needed(c, self._parts[c].fmu[v]) for c, v in sources)
        return here.union(*needed)

    @cached_property
    def _sources(self) -> dict[tuple[str, str], set[tuple[str, str]]]:
        found: dict[tuple[str, str], set[tuple[str, str]]] = {}
        for edge in self._source.wiring.edges:
            sources = found.setdefault((edge.sink, edge.input), set())
            sources.add((edge.source, edge.output))
        return found


def _named(part: Part, name: str) -> str:
    (port, *_) = ports(part.component, part.fmu, name)
    return port.variable.name


def _is(v: FmuVariable, own: Own, role: str) -> bool:
    if role == "parameter":
        return v.causality == "parameter" and v.variability != "constant"
    x = own.equations["x"]
    return x <= v.reference < x + own.equations["n_x"]


def _outer(inside: float, affine: Affine) -> float:
    return (inside - affine.offset) / affine.gain if affine.converts else inside
