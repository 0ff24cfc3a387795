"""What ``--set key=value`` changes in a scenario's tables.

    component.parameter   component.nested.parameter   component.state.x_1
    component.step  .offset  .latency  .fmu  .kind  .split   (of the component itself)
    component.data  .interpolation  .begin  .rate  .at_end   (of signals of a file)
    rates.name   stop   fmi
    faults.component.input.value  .samples  .window  .kind
    faults.component.input=false (leave it out)
    groups.name.iterate  .tolerance
    design.name.argument   design.name.from_run   design.name=false (leave it out)
    metrics.name.key   metrics.name={...} (a new one)   metrics.name=false
    record.component.variable   connections.component.input
        (false: leave it out; of a connection that is a switch its value)

``component.parameters.name`` and ``component.start.name`` reach a variable
whose name is one of the component's own keys; both are one table, in which the last
value of a name holds.  Whether a parameter exists is
known when the scenario is composed, from the FMU's variables.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.quantities.quantity import DecimalFloat
from orchestrator.scenario.last import put_last
from orchestrator.scenario.sockets import plugged
from orchestrator.scenario.toml import read_toml_text, toml
from orchestrator.scenario.written import parse_setting

_TABLES = (
    *("rates", "design", "faults", "groups"),
    *("metrics", "record", "connections"),
)
OF_COMPONENT = ("step", "offset", "latency", "fmu", "kind", "split")
_OF_DATA = ("data", "interpolation", "begin", "rate", "at_end")
_OF_DESIGN = ("from_run", "call")
_OF_GROUP = ("iterate", "tolerance")
_OF_FAULT = ("kind", "value", "samples", "window")


def apply_override(raw: dict[str, Any], text: str) -> bool:
    """Change a scenario's tables in place; tell whether a component was changed.

    Raises:
        ScenarioError: the text is no ``key=value``, or names nothing there is.
    """
    key, equals, written = text.partition("=")
    key = key.strip()
    if not equals or not key:
        raise ScenarioError(f"--set {text}: write component.parameter=value")
    value = parse_override_value(written)
    head, _, rest = key.partition(".")
    components = raw.get("components", {})
    if key in ("stop", "fmi"):
        raw[key] = value
    elif head == "rates" and rest:
        _known(text, "rate", rest, raw.get("rates", {}))
        raw["rates"][rest] = value
    elif head == "design" and rest:
        _set_design(raw, text, rest, value)
    elif head == "faults" and rest:
        _set_fault(raw, text, rest, value)
    elif head == "groups" and rest:
        _set_group(raw, text, rest, value)
    elif head == "metrics" and rest:
        _set_metric(raw, text, rest, value)
    elif head in ("record", "connections") and rest:
        _set_entry(raw, text, head, rest, value)
    elif head in components and rest:
        _set_component(components[head], text, rest, value)
        return True
    elif rest:
        _known(text, "component", head, [*components, *_TABLES])
    else:
        known = ("stop", "fmi", *(f"{name}.<parameter>" for name in components))
        raise ScenarioError(f"--set {text}: no {key!r}; {did_you_mean(key, known)}")
    return False


def settings_of(overrides: Iterable[str], component: str) -> list[tuple[bool, str]]:
    """Return the values of a component that overrides name, in their order: whether
    as a constant of a connection, and the variable."""
    found: dict[tuple[bool, str], None] = {}
    for text in overrides:
        head, _, rest = text.partition("=")[0].strip().partition(".")
        constant = head == "connections"
        if constant:
            head, _, rest = rest.partition(".")
        table, _, name = rest.partition(".")
        if not constant and table in ("parameters", "start") and name:
            rest = name
        elif not constant and rest in OF_COMPONENT:
            continue
        if head == component:
            found.pop((constant, rest), None)
            found[constant, rest] = None
    return list(found)


def lines_of(overrides: Iterable[str], table: str) -> list[str]:
    """Return the entries of a table, say record, that overrides write."""
    keys = (text.partition("=")[0].strip() for text in overrides)
    return [
        key.removeprefix(f"{table}.") for key in keys if key.startswith(f"{table}.")
    ]


def parse_override_value(written: str) -> Any:
    """Return the value of an override: a TOML value, or else the text itself."""
    try:
        return toml(f"v = {written}", DecimalFloat)["v"]
    except ValueError:
        text = written.strip()
    try:
        return DecimalFloat(text)
    except ValueError:
        return text


def parse_swaps(
    swaps: Sequence[str], maps: Sequence[str], sockets: Sequence[str] = ()
) -> dict[str, dict[str, Any]]:
    """Return what ``--swap component=their.fmu``, ``--map`` and ``--socket`` put in
    place.

    The n-th map, a TOML file or inline TOML, and the n-th socket belong to the n-th
    swap.

    Raises:
        ScenarioError: no ``component=file``, no such file, a map that is no TOML, a
            socket that does not fit.
    """
    for option, given in (("map", maps), ("socket", sockets)):
        if len(given) > len(swaps):
            raise ScenarioError(f"--{option}: there are more {option}s than swaps")
    found: dict[str, dict[str, Any]] = {}
    for number, text in enumerate(swaps):
        component, equals, fmu = text.partition("=")
        if not equals or not fmu:
            raise ScenarioError(f"--swap {text}: write component=their.fmu")
        is_file = fmu.endswith((".fmu", ".py"))
        if is_file and not Path(fmu).is_file():
            raise ScenarioError(f"--swap {text}: no such file: {fmu}")
        found[component] = {"fmu": str(Path(fmu).absolute()) if is_file else fmu}
        if number < len(maps):
            found[component]["map"] = parse_map(maps[number])
        if number < len(sockets):
            if not fmu.endswith(".fmu"):
                raise ScenarioError(f"--socket: {fmu} is no .fmu of a drive")
            put = found[component]
            found[component] = plugged(
                component, put["fmu"], put.get("map", {}), sockets[number]
            )
    return found


def parse_map(text: str) -> Any:
    """Return a map given as the path of a TOML file, as its lines, or inline.

    Raises:
        ScenarioError: it can be read as neither.
    """
    try:
        if text.endswith(".toml"):
            return toml(read_toml_text(Path(text)))
        if "\n" in text.strip():
            return toml(text)
        return toml(f"map = {{{text}}}")["map"]
    except OSError as error:
        raise ScenarioError(
            f"--map {text}: cannot be read ({error.strerror})"
        ) from None
    except ValueError as error:
        raise ScenarioError(
            f"--map {text}: not valid TOML ({error}); write a .toml file, or inline "
            f'\'u = {{name = "voltage", gain = -1}}, x_1 = "angle"\''
        ) from None


def _set_component(component: dict[str, Any], text: str, rest: str, value: Any) -> None:
    if rest in OF_COMPONENT or (rest in _OF_DATA and "data" in component):
        is_file = rest == "data" or (
            rest == "fmu" and str(value).endswith((".fmu", ".py"))
        )
        component[rest] = str(Path(value).absolute()) if is_file else value
        return
    table, _, name = rest.partition(".")
    if table not in ("parameters", "start") or not name:
        table, name = ("start" if table == "state" else "parameters"), rest
    try:
        parse_setting(value)
    except ValueError as error:
        raise ScenarioError(f"--set {text}: {error}") from None
    put_last(component, table, name, value)


def _set_design(raw: dict[str, Any], text: str, rest: str, value: Any) -> None:
    steps = raw.get("design", {})
    name, _, argument = rest.partition(".")
    _known(text, "design step", name, steps)
    if not argument:
        if value is not False:
            raise ScenarioError(
                f"--set {text}: write design.{name}.<argument>=value, or "
                f"design.{name}=false to leave the step out"
            )
        del steps[name]
    elif argument in _OF_DESIGN:
        steps[name][argument] = value
    else:
        steps[name].setdefault("arguments", {})[argument] = value


def _set_fault(raw: dict[str, Any], text: str, rest: str, value: Any) -> None:
    faults = raw.get("faults", {})
    if rest in faults and value is False:
        del faults[rest]
        return
    name, _, key = rest.rpartition(".")
    _known(text, "fault", name if key in _OF_FAULT else rest, faults)
    if not isinstance(faults.get(name), dict):
        raise ScenarioError(
            f"--set {text}: write faults.{name or rest}.value= where there is one "
            f"fault, or faults.{name or rest}=false to leave them out"
        )
    faults[name][key] = value


def _set_group(raw: dict[str, Any], text: str, rest: str, value: Any) -> None:
    groups = raw.get("groups", {})
    name, _, key = rest.partition(".")
    _known(text, "group", name, groups)
    _known(text, f"key of groups.{name}", key, _OF_GROUP)
    groups[name][key] = value


def _set_metric(raw: dict[str, Any], text: str, rest: str, value: Any) -> None:
    metrics = raw.setdefault("metrics", {})
    name, _, key = rest.partition(".")
    if isinstance(value, dict) and not key:
        metrics[name] = value
        return
    _known(text, "metric", name, metrics)
    if key:
        metrics[name][key] = value
    elif value is False:
        del metrics[name]
        expect = raw.get("expect", {})
        for figure in [f for f in expect if f.rpartition(".")[0] == name]:
            del expect[figure]
    else:
        raise ScenarioError(
            f"--set {text}: write metrics.{name}.<key>=value, metrics.{name}=false to "
            f"leave it out, or a table in braces for a new one"
        )


def _set_entry(
    raw: dict[str, Any], text: str, table: str, name: str, value: Any
) -> None:
    entries = raw.setdefault(table, {})
    switch = table == "connections" and isinstance(entries.get(name), bool)
    if value is not False or switch:
        entries[name] = value
        return
    _known(text, f"entry of [{table}]", name, entries)
    del entries[name]


def _known(text: str, noun: str, name: str, table: Iterable[str]) -> None:
    if name not in table:
        remedy = did_you_mean(name, table)
        raise ScenarioError(f"--set {text}: there is no {noun} {name!r}; {remedy}")
