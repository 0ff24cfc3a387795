"""A composition as a system structure package, the same bytes every time.

``SystemStructure.ssd``        components, connectors, connections, units, stop time
``resources/<component>.fmu``  as it runs here
``resources/<component>.ssv``  what is set on it, designed gains included; ``.ssm``
                               beside it where a map renames or scales
``resources/feeddrive.toml``   what SSP has no words for: record, metrics,
                               expectations, faults, our own names

A connection that converts carries its transformation and suppresses conversion by
units, so that every tool computes the same number.  Steps, offsets and latencies
stand exactly in one annotation (``docs/ssp.md``); where every step is a whole number
of nanoseconds, also in those of OSP.
"""

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from importlib.metadata import version as version_of
from itertools import groupby
from math import gcd, lcm
from pathlib import Path
from typing import Any, cast, get_args

from fmus.archive import write_archive
from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.beside import kept
from orchestrator.exchange.ssp.looked import words_of
from orchestrator.exchange.ssp.platforms import fmu_for
from orchestrator.exchange.ssp.values import (
    connector_type,
    entries,
    enumerations,
    parameter_mapping,
    parameter_set,
    unit_definitions,
)
from orchestrator.exchange.ssp.xml import (
    DEFAULT,
    FMU_TYPE,
    OSP,
    OURS,
    Version,
    add,
    document,
    root,
)
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.ports import Port, ports
from orchestrator.fmu.whole import Listed, Whole
from orchestrator.master.layout import Link
from orchestrator.master.wiring import links_of
from orchestrator.quantities.quantity import time_text
from orchestrator.quantities.unit import Unit
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.lock import locked
from orchestrator.system import Component, System, split_name

REST = "resources/feeddrive.toml"
_IN_SSD = (
    *("fmu", "step", "offset", "latency", "kind", "split", "interface"),
    *("parameters", "start"),
)
_OF_REST = ("title", "description", "faults", "record", "metrics", "expect")
_NANO = Fraction(1, 10**9)


def export_ssp(
    composition: Composition,
    target: Path,
    version: str | None = None,
    platforms: Sequence[str] = (),
) -> Path:
    """Write a composition into an ``.ssp`` file, its FMUs for some platforms.

    Without a version one that was imported and is unchanged is written as it was,
    any other as 1.0.

    Raises:
        ScenarioError: SSP of that version cannot say what the composition is.
        WiringError: its parts do not fit together.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    same = kept(composition) if version is None and not platforms else None
    if same is not None:
        target.write_bytes(same.read_bytes())
        return target
    return write_archive(target, members(composition, version or "1.0", platforms))


def members(
    composition: Composition, version: str = "1.0", platforms: Sequence[str] = ()
) -> dict[str, bytes]:
    """Return the files of the package by name."""
    if version not in get_args(Version):
        raise ScenarioError(f"--ssp {version}: there are 1.0 and 2.0")
    return _Package(composition, cast(Version, version)).members(platforms)


class _Package:
    def __init__(self, composition: Composition, version: Version) -> None:
        self.composition, self.version = composition, version
        self.system: System = composition.system
        self.fmus: Mapping[str, FmuDescription] = composition.fmus
        for name, fmu in self.fmus.items():
            self._refuse_what_has_no_words(name, fmu)
        links, _, _ = links_of(self.system, self.fmus)
        self.links: Sequence[Link] = links

    def _refuse_what_has_no_words(self, name: str, fmu: FmuDescription) -> None:
        if fmu.fmi_major == 3 and self.version == "1.0":
            raise ScenarioError(
                f"{name}: SSP 1.0 knows FMI 2 only, and {fmu.path.name} is FMI 3; give "
                f"--ssp 2.0, or --fmi 2 where it is a model of ours"
            )

    def members(self, platforms: Sequence[str]) -> dict[str, bytes]:
        found = {DEFAULT: document(self._structure())}
        for name, component in self.system.components.items():
            file = fmu_for(self.composition, name, platforms)
            found[f"resources/{name}.fmu"] = file.read_bytes()
            values = entries(component, self.fmus[name])
            if not values:
                continue
            of_set = parameter_set(values, self.version)
            found[f"resources/{name}.ssv"] = document(of_set)
            mapping = parameter_mapping(values, self.version)
            if mapping is not None:
                found[f"resources/{name}.ssm"] = document(mapping)
        found[REST] = self._rest()
        return found

    def _rest(self) -> bytes:
        import tomli_w

        tables = locked(self.composition)
        rest: dict[str, Any] = {key: tables[key] for key in _OF_REST}
        if "groups" in tables:
            rest["groups"] = tables["groups"]
        rest["components"] = {}
        for name, table in tables["components"].items():
            kept = {k: v for k, v in table.items() if k not in _IN_SSD}
            for key in ("parameters", "start"):
                if table.get(key):
                    kept[key] = list(table[key])
            if kept:
                rest["components"][name] = kept
        return tomli_w.dumps(rest).encode()

    def _structure(self) -> Any:
        name = self.system.name.rpartition("/")[2]
        made = root(
            "ssd:SystemStructureDescription",
            *("ssd", "ssc", "osp", "fd"),  # libcosim takes them nowhere else
            version=self.version,
            name=name,
            generationTool=f"feeddrive {version_of('feeddrive-cosim')}",
        )
        system = add(made, "ssd:System", name=name)
        elements = add(system, "ssd:Elements")
        shown = self._connectors()
        self.units = _agreed(v for some in shown.values() for v in some.values())
        for component in self.system.components.values():
            self._component(elements, component, shown[component.name])
        if self.links:
            connections = add(system, "ssd:Connections")
            for _, group in groupby(self.links, key=_variables):
                _connect(connections, list(group))
        variables = [v for some in shown.values() for v in some.values()]
        enumerations(made, variables)
        unit_definitions(made, "ssd:Units", self.units.values())
        self._experiment(made)
        return made

    def _connectors(self) -> dict[str, dict[str, FmuVariable]]:
        """Return what of each component is connected or recorded, in FMU's order."""
        shown: dict[str, set[str]] = {name: set() for name in self.system.components}
        for source, sink, _ in self.links:
            if isinstance(sink.whole, Whole):
                raise ScenarioError(
                    f"{source.full_name} -> {sink.full_name}: is rounded into a range, "
                    f"for which SSP has no words; let a component do it"
                )
            if _kind(source.variable) is None:
                raise ScenarioError(
                    f"{source.full_name} -> {sink.full_name}: SSP connects outputs and "
                    f"parameters, and this is a {source.variable.causality} variable"
                )
            shown[source.component].add(source.variable.name)
            shown[sink.component].add(sink.variable.name)
        for recorded in self.system.record:
            name, variable = split_name(recorded)
            for port in ports(self.system.components[name], self.fmus[name], variable):
                if _kind(port.variable) is not None:
                    shown[name].add(port.variable.name)
        return {
            name: {k: v for k, v in self.fmus[name].variables.items() if k in wanted}
            for name, wanted in shown.items()
        }

    def _component(
        self, elements: Any, component: Component, shown: Mapping[str, FmuVariable]
    ) -> None:
        name, fmu = component.name, self.fmus[component.name]
        made = add(
            elements,
            "ssd:Component",
            name=name,
            type=FMU_TYPE,
            source=f"resources/{name}.fmu",
            implementation="CoSimulation" if fmu.co_simulation else "ModelExchange",
        )
        if shown:
            connectors = add(made, "ssd:Connectors")
            for variable in shown.values():
                kind = _kind(variable)
                assert kind is not None
                one = add(connectors, "ssd:Connector", name=variable.name, kind=kind)
                unit = variable.unit
                connector_type(one, variable, self.units.get(str(unit)))
                for size in variable.shape:
                    add(one, "ssc:Dimension", size=str(size))
        if values := entries(component, fmu):
            bindings = add(made, "ssd:ParameterBindings")
            source = f"resources/{name}.ssv"
            binding = add(bindings, "ssd:ParameterBinding", source=source)
            if any(entry.port is not None for entry in values):
                of_map = f"resources/{name}.ssm"
                add(binding, "ssd:ParameterMapping", source=of_map)
        if self._in_nanoseconds():
            annotations = add(made, "ssd:Annotations")
            one = add(annotations, "ssc:Annotation", type=OSP)
            add(one, "osp:StepSizeHint", value=repr(float(component.period)))

    def _in_nanoseconds(self) -> bool:
        periods = [c.period for c in self.system.components.values()]
        return all(period % _NANO == 0 for period in periods)

    def _experiment(self, made: Any) -> None:
        stop = self.system.stop
        experiment = add(
            made, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(float(stop))
        )
        annotations = add(experiment, "ssd:Annotations")
        if self._in_nanoseconds():
            step = _common(c.period for c in self.system.components.values())
            one = add(annotations, "ssc:Annotation", type=OSP)
            of_osp = add(one, "osp:Algorithm")
            add(of_osp, "osp:FixedStepAlgorithm", baseStepSize=repr(float(step)))
        one = add(annotations, "ssc:Annotation", type=OURS)
        timing = add(one, "fd:Timing", stop=time_text(stop), scenario=REST)
        for component in self.system.components.values():
            told = add(
                timing,
                "fd:Component",
                name=component.name,
                step=time_text(component.period),
                offset=time_text(component.offset),
                latency=str(component.latency),
            )
            if component.kind is not None:
                told.set("kind", component.kind)
            if component.split is not None:
                told.set("split", str(component.split).lower())


def _agreed(variables: Iterable[FmuVariable]) -> dict[str, Unit]:
    """Return the units that all who name them define alike."""
    found: dict[str, Unit] = {}
    differ = set()
    for unit in [v.unit for v in variables if v.sort == "real" and v.unit is not None]:
        if found.setdefault(str(unit), unit).base != unit.base or unit.base is None:
            differ.add(str(unit))
    return {name: unit for name, unit in found.items() if name not in differ}


def _common(periods: Iterable[Fraction]) -> Fraction:
    """Return the longest time of which all periods are whole multiples."""
    listed = list(periods)
    whole = lcm(*(p.denominator for p in listed))
    return Fraction(gcd(*(int(p * whole) for p in listed)), whole)


def _kind(variable: FmuVariable) -> str | None:
    """Return a variable's kind of connector, None if it may have none."""
    known = ("input", "output", "parameter", "calculatedParameter")
    return variable.causality if variable.causality in known else None


def _variables(link: Link) -> tuple[str, str, str, str]:
    source, sink, _ = link
    ends = source.component, source.variable.name, sink.component, sink.variable.name
    return ends


def _connect(connections: Any, group: Sequence[Link]) -> None:
    """Append the connections of one variable to another, whole arrays as one."""
    source, sink, affine = group[0]
    is_whole = (
        source.variable.shape == sink.variable.shape
        and [s.element for s, _, _ in group] == list(range(source.variable.size))
        and [t.element for _, t, _ in group] == list(range(sink.variable.size))
        and all(a == affine for _, _, a in group)
    )
    for one in group[:1] if is_whole else group:
        source, sink, affine = one
        ends = {
            "startElement": source.component,
            "startConnector": source.variable.name,
            "endElement": sink.component,
            "endConnector": sink.variable.name,
        }
        if not is_whole and (source.variable.shape or sink.variable.shape):
            raise ScenarioError(
                f"{source.full_name} -> {sink.full_name}: SSP does not say from which "
                f"number it counts the elements of an array; connect arrays as a "
                f"whole, or build the models as FMI 2 (--fmi 2)"
            )
        made = add(connections, "ssd:Connection", **ends)
        if affine.converts or _renamed_unit(source, sink):
            made.set("suppressUnitConversion", "true")
        if isinstance(sink.whole, Listed):
            _mapping(made, source, sink, sink.whole)
        if affine.converts:
            factor, offset = repr(affine.gain), repr(affine.offset)
            add(made, "ssc:LinearTransformation", factor=factor, offset=offset)


def _mapping(connection: Any, source: Port, sink: Port, listed: Listed) -> None:
    try:
        how = words_of(source.variable, sink.variable, listed.pairs)
    except ScenarioError as error:
        raise ScenarioError(
            f"{source.full_name} -> {sink.full_name}: {error}"
        ) from None
    made = add(connection, f"ssc:{how.type}MappingTransformation")
    for one, other in how.pairs:
        add(made, "ssc:MapEntry", source=one, target=other)


def _renamed_unit(source: Port, sink: Port) -> bool:
    """Tell whether another tool might convert what passes here as it is."""
    return str(source.variable.unit) != str(sink.variable.unit)
