"""A system structure as a scenario's tables.

Components get names of ours; a transformation on the way to an input becomes the map
of that input, so that the one connection there carries it exactly.  Of packages that
we have written the annotation gives times, names and what SSP has no words for; it is
compared with the description, which anybody may have edited since.
"""

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path as File
from typing import Any

from orchestrator.errors import FeedDriveError, ScenarioError
from orchestrator.exchange.ssp.flat import Edge, Flat, Node, Path, flatten, unfed
from orchestrator.exchange.ssp.looked import table_of
from orchestrator.exchange.ssp.names import names_of
from orchestrator.exchange.ssp.passage import passed
from orchestrator.exchange.ssp.records import Looked, Structure
from orchestrator.exchange.ssp.setting import Settings, regrouped
from orchestrator.fmu.description import FmuDescription, read_fmu
from orchestrator.fmu.ports import Affine, connection, ports
from orchestrator.fmu.start_values import declared
from orchestrator.quantities.quantity import exact
from orchestrator.system import Component, Mapped, Value

_KEPT = ("answer_within", "memory_limit", "experiment")  # of what SSP has no words for
EDITED = (
    "was edited since it was exported, and its numbers are no more those of our "
    "annotation; remove the annotation org.feeddrive.timing, or the edit"
)
CLOSE = 1e-12  # by which two ways to convert may differ, relative


class Tables:
    """The tables of one structure, and what is to be said of it.

    ``faults`` are what cannot be run, ``notes`` what is good to know, ``lacking`` the
    times that nobody says, with a proposal; ``names`` leads from paths to our names.
    """

    def __init__(self, structure: Structure, rest: Mapping[str, Any]) -> None:
        self.structure, self.rest = structure, rest
        self.flat: Flat = flatten(structure.system)
        self.faults = [*structure.faults, *self.flat.faults]
        self.notes = [*structure.notes, *unfed(self.flat)]
        self.lacking: dict[str, str] = {}
        self.fmus: dict[Path, FmuDescription] = {}
        for path, part in self.flat.parts.items():
            if part.fmu is not None:
                self._read(path, part.fmu, part.implementation)
        self.names = names_of(list(self.flat.parts))
        self.settings = Settings(self.flat, self.fmus, self.faults, self.notes)
        self.settings.collect()
        self.settings.through(self._value)
        self.maps: dict[Path, dict[str, dict[str, Any]]] = {}
        self.connections = self._connections()
        self.components = {
            self.names[path]: self._component(path) for path in self.flat.parts
        }
        self.stop = self._stop()

    def tables(self) -> dict[str, Any]:
        """Return the tables of the scenario; only without faults they can be run."""
        made: dict[str, Any] = {
            "title": self.rest.get("title", self.structure.name),
            "description": self.rest.get(
                "description", self.structure.system.description
            ),
        }
        if self.stop is not None:
            made["stop"] = self.stop
        if "rates.step" in self.lacking:
            made["rates"] = {}
        made["components"] = self.components
        made["connections"] = self.connections
        outputs = {
            f"{self.names[path]}.*": True
            for path, fmu in self.fmus.items()
            if any(not fmu.variables[name].is_text for name in fmu.outputs)
        }
        made["record"] = self.rest.get("record", outputs)
        for key in ("faults", "groups", "metrics", "expect"):
            if self.rest.get(key):
                made[key] = self.rest[key]
        return made

    def _read(self, path: Path, file: File, wanted: str) -> None:
        where = "/".join(path)
        try:
            fmu = read_fmu(file)
        except FeedDriveError as error:
            told = str(error).replace(str(file), file.name)
            self.faults.append(f"{where}: {told}")
            return
        self.fmus[path] = fmu
        there = [
            kind
            for kind, has in (
                ("CoSimulation", fmu.co_simulation),
                ("ModelExchange", fmu.model_exchange),
            )
            if has
        ]
        if wanted not in ("any", "", *there) or not there:
            has = " and ".join(there) or "neither co-simulation nor model exchange"
            self.faults.append(
                f"{where}: is to be run by {wanted}, and {file.name} has {has}"
            )
        part = self.flat.parts[path]
        for name, connector in part.connectors.items():
            if name not in fmu.variables and connector.kind != "inout":
                told = f"{where}: connector {name!r} is no variable of {file.name}"
                is_used = (path, name) in self.flat.fed or self.flat.feeds.get(
                    (path, name)
                )
                (self.faults if is_used else self.notes).append(told)

    def _value(self, path: Path, name: str) -> Value | None:
        """Return the value of a parameter: what is set, or what the FMU declares."""
        if (setting := self.settings.found.get(path, {}).get(name)) is not None:
            return setting.value
        variable = self.fmus[path].variables[name]
        found = tuple(v for v in declared(variable) if v is not None)
        if not found or any(isinstance(v, bytes) for v in found):
            return None
        values = tuple(v if not isinstance(v, bytes) else v.hex() for v in found)
        return values if variable.shape else values[0]

    def _connections(self) -> dict[str, str]:
        made: dict[str, str] = {}
        for sink in self.flat.fed:
            path, name = sink
            if path not in self.fmus or name not in self.fmus[path].variables:
                continue
            way = self.flat.way(sink)
            if way[0].source == sink:
                self.faults.append(f"{way[0].written.where}: goes round in a circle")
                continue
            owner, source = way[0].source
            theirs = self.fmus.get(owner)
            if theirs is None or source not in theirs.variables:
                continue  # from the border, where nothing is connected, or refused
            if theirs.variables[source].causality == "parameter":
                continue  # its value is handed on
            try:
                self._connect(sink, way)
            except FeedDriveError as error:
                self.faults.append(f"{way[-1].written.where}: {error}")
                continue
            self.settings.found.get(path, {}).pop(name, None)
            ours, theirs_name = self._ours(path, name), self._ours(owner, source)
            made[f"{self.names[path]}.{ours}"] = f"{self.names[owner]}.{theirs_name}"
        return made

    def _ours(self, path: Path, name: str) -> str:
        """Return the name that our own map gives a variable."""
        for ours, mapped in self._own_map(path).items():
            if mapped.name == name:
                return ours
        return name

    def _own_map(self, path: Path) -> dict[str, Mapped]:
        of_part = self.rest.get("components", {}).get(self.names[path], {})
        return {
            ours: Mapped(
                entry["name"],
                entry.get("gain"),
                entry.get("offset"),
                entry.get("unit"),
                table=tuple((int(k), v) for k, v in entry.get("table", {}).items())
                or None,
            )
            for ours, entry in of_part.get("map", {}).items()
        }

    def _connect(self, sink: Node, way: list[Edge]) -> None:
        """Find the map of an input by which its one connection passes exactly."""
        source = way[0].source
        hows = [e.written.how for e in way if e.written.how is not None]
        if len(hows) == 1 and isinstance(hows[0], Looked):
            self._look_up(source, sink, hows[0])
            return
        unit = self.settings.unit(source)
        wanted, plain = passed(unit, self.settings.hops(way))
        maps = {one[0]: self._own_map(one[0]) for one in (sink, source)}
        has_maps = any(maps.values())
        try:
            if _same(wanted, self._affine(source, sink, maps)):
                return
        except FeedDriveError:
            if plain or has_maps:
                raise
        if has_maps:
            raise ScenarioError(EDITED)
        entry: dict[str, Any] = {
            "name": sink[1],
            "gain": wanted.gain,
            "offset": wanted.offset,
        }
        theirs = self.fmus[source[0]].variables[source[1]].unit
        if theirs is not None and theirs.is_defined:
            entry["unit"] = str(theirs)
        trial = {sink[0]: {sink[1]: Mapped(**entry)}}
        if self._affine(source, sink, trial) != wanted:
            raise ScenarioError(
                f"its units {theirs} and "
                f"{self.fmus[sink[0]].variables[sink[1]].unit} cannot be passed with "
                f"the transformation that is written"
            )
        self.maps.setdefault(sink[0], {})[sink[1]] = entry

    def _look_up(self, source: Node, sink: Node, how: Looked) -> None:
        """Give an input the table that the one transformation on its way is."""
        there, here = (self.fmus[path].variables[name] for path, name in (source, sink))
        pairs = table_of(how, there, here)
        for mapped in self._own_map(sink[0]).values():
            if mapped.name == sink[1]:
                if mapped.table != pairs:
                    raise ScenarioError(EDITED)
                return
        entry = {"name": sink[1], "table": {str(one): other for one, other in pairs}}
        trial = Mapped(sink[1], table=pairs)
        self._affine(source, sink, {sink[0]: {sink[1]: trial}})
        self.maps.setdefault(sink[0], {})[sink[1]] = entry

    def _affine(
        self, source: Node, sink: Node, maps: Mapping[Path, Mapping[str, Mapped]]
    ) -> Affine:
        """Return what our master would make of a connection."""
        found = []
        for path, name in (source, sink):
            of_part = maps.get(path, {})
            ours = next((k for k, m in of_part.items() if m.name == name), name)
            fmu = self.fmus[path]
            part = Component(self.names[path], fmu.path, Fraction(1), map=of_part)
            found.append(ports(part, fmu, ours)[0])
        return connection(*found).affine

    def _component(self, path: Path) -> dict[str, Any]:
        part, name = self.flat.parts[path], self.names[path]
        timing = self.structure.timing
        told = timing.components.get(name, {}) if timing else {}
        made: dict[str, Any] = {"fmu": str(part.fmu)}
        own = self.fmus[path].period if path in self.fmus else None
        step = told.get("step") or (str(own) if own else None) or part.step
        if step is None:
            step = "step"
            self.lacking.setdefault("rates.step", self._proposal())
        made["step"] = step
        of_fmu = self.fmus.get(path)
        if part.implementation == "ModelExchange" and of_fmu and of_fmu.co_simulation:
            made["interface"] = "model_exchange"
        for key in ("offset", "kind"):
            if told.get(key, "0") != "0":
                made[key] = told[key]
        if told.get("latency", "0") != "0":
            made["latency"] = int(told["latency"])
        if "split" in told:
            made["split"] = told["split"] == "true"
        rest = self.rest.get("components", {}).get(name, {})
        order = {key: rest.get(key, ()) for key in ("parameters", "start")}
        made |= {key: rest[key] for key in _KEPT if key in rest}
        if rest.get("isolation") == "process":
            made["isolation"] = "process"
        if maps := {**rest.get("map", {}), **self.maps.get(path, {})}:
            made["map"] = maps
        if path in self.fmus:
            made |= self._values(path, order)
        return made

    def _values(self, path: Path, order: Mapping[str, Any]) -> dict[str, Any]:
        """Return the tables of values, by the names and in the order we once had."""
        fmu, settings = self.fmus[path], dict(self.settings.found.get(path, {}))
        own = self._own_map(path)
        part = Component(self.names[path], fmu.path, Fraction(1), map=own)
        made: dict[str, dict[str, Any]] = {"parameters": {}, "start": {}}
        for table, names in order.items():
            for ours in names:
                if (value := regrouped(part, fmu, ours, settings)) is not None:
                    made[table][ours] = value
        for variable, setting in settings.items():
            is_parameter = fmu.variables[variable].causality in (
                "parameter",
                "structuralParameter",
            )
            made["parameters" if is_parameter else "start"][variable] = setting.value
        return {
            table: {k: list(v) if isinstance(v, tuple) else v for k, v in found.items()}
            for table, found in made.items()
            if found
        }

    def _stop(self) -> str | None:
        told, timing = self.structure.stop, self.structure.timing
        start = self.structure.start
        try:
            if start is not None and exact(start) != 0:
                self.faults.append(
                    f"DefaultExperiment: starts at {start} s; a run starts at 0: set "
                    f"startTime to 0"
                )
            if told is None:
                self.lacking["stop"] = ""
                return None
            if timing is not None and float(Fraction(timing.stop)) == float(told):
                return timing.stop
            stop = exact(told)
        except (ValueError, ZeroDivisionError):
            self.faults.append(
                f"DefaultExperiment: startTime {start!r} and stopTime {told!r} are "
                f"no times"
            )
            return None
        if stop <= 0:
            self.faults.append(f"DefaultExperiment: stops at {told} s, before it began")
            return None
        return str(stop)

    def _proposal(self) -> str:
        """Return the step that the FMUs propose for themselves, "" if none does."""
        found = {
            fmu.path.name: fmu.default_step or float(fmu.internal_step or 0)
            for fmu in self.fmus.values()
        }
        steps = {name: step for name, step in found.items() if step}
        if not steps:
            return ""
        name = min(steps, key=lambda one: steps[one])
        return f"{Fraction(repr(steps[name]))} s, which {name} proposes for itself"


def _same(one: Affine, other: Affine) -> bool:
    scale = max(abs(one.offset), abs(other.offset))
    return (
        abs(one.gain - other.gain) <= CLOSE * abs(one.gain)
        and abs(one.offset - other.offset) <= CLOSE * scale
    )
