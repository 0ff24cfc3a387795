"""What a scenario file says, validated; nothing is built or run here.

A scenario is TOML: ``stop``, ``rates``, ``components``, ``connections``,
``faults``, ``design``, ``record``, ``metrics``, ``expect``.  The order of precedence is

    start value of the FMU < design step < scenario file < --set

``base = "other.toml"`` inherits from a scenario of the same folder, or a published
``<study>/<scenario>``, table by table, ``base = ["one.toml", "two.toml"]`` from
several, the later before the earlier; an inherited entry is removed by the value
``false``.  Every complaint names the file and the key path.  ``nominal`` is the
scenario without what the command line changed on components: what design steps are
told.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import ValidationError

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.evaluation.rates import RateContext
from orchestrator.quantities.quantity import DecimalFloat
from orchestrator.scenario.complaints import complaints
from orchestrator.scenario.homes import homed, scenario_beside
from orchestrator.scenario.inherit import inherit
from orchestrator.scenario.override import apply_override
from orchestrator.scenario.schema import Specification
from orchestrator.scenario.takeover import TABLES
from orchestrator.scenario.toml import read_toml_text, toml
from orchestrator.shown import Shown

STUDIES = Path(__file__).parents[1] / "studies"
Swaps: TypeAlias = Mapping[str, Mapping[str, Any]]
_KEPT = ("step", "offset", "latency", "kind", "split")  # by a component that is swapped
HEIRS = 50  # files in a row, each the base of the next
_NOT_SCENARIOS = ("reference.toml", "figures.toml", "bands.toml", "closed.toml")


@dataclass(frozen=True)
class Scenario(Shown):
    """A validated scenario: its name, its file, what it says after overrides.

    ``swapped`` are its swaps, written ``component=fmu``; ``carried`` the values, by
    component and table, that a swapped one is to take over (none of one whose FMU
    ``--set`` replaced); ``of_swap`` the names, by component, of values that came with
    the other FMU.
    """

    name: str
    file: Path
    spec: Specification
    nominal: Specification
    overrides: tuple[str, ...] = ()
    swapped: tuple[str, ...] = ()
    carried: Mapping[str, Mapping[str, tuple[str, ...]]] = field(default_factory=dict)
    of_swap: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    PAGE = "orchestrator.report.notebook:write_scenario"

    def beside(self, name: str) -> str:
        """Return the full name or path of a scenario named from within this one."""
        return scenario_beside(self.file.parent, name)


def load_scenario(
    name: str | Path, overrides: Sequence[str] = (), swaps: Swaps | None = None
) -> Scenario:
    """Return the scenario of a file or of a name ``<study>/<scenario>``.

    ``overrides`` are texts ``component.parameter=value`` as given to ``--set``;
    ``swaps`` put another FMU, with its own ``fmu``, ``map`` and the like, in the
    place of a component before the overrides are applied.

    Raises:
        ScenarioError: no such scenario, malformed TOML, a wrong key or value.
    """
    file = find_scenario(name)
    return scenario_from(read_scenario(file), file, overrides, swaps)


def scenario_from(
    raw: Mapping[str, Any],
    file: Path,
    overrides: Sequence[str] = (),
    swaps: Swaps | None = None,
) -> Scenario:
    """Return the scenario that parsed TOML describes; ``file`` names it in messages.

    Raises:
        ScenarioError: a wrong key, value or override.
    """
    plain = _copy(raw)
    changed = _copy(raw)
    for component, swap in (swaps or {}).items():
        _swap(changed, component, swap)
    for tables in (plain, changed):
        _set_by_map(tables)
    with_swap = _copy(changed)
    for text in overrides:
        on_component = apply_override(changed, text)
        if not on_component:
            apply_override(plain, text)
    nominal = _validate(plain, file)
    spec = _validate(changed, file) if changed != plain else nominal
    swapped = tuple(f"{name}={swap['fmu']}" for name, swap in (swaps or {}).items())
    carried: dict[str, dict[str, tuple[str, ...]]] = {
        **{name: {} for name in _set_anew(spec, nominal)},
        **{name: _carried(changed, plain, name) for name in swaps or {}},
    }
    of_swap = {name: _of_swap(with_swap, plain, changed, name) for name in swaps or {}}
    name = scenario_name(file)
    return Scenario(
        name, file, spec, nominal, tuple(overrides), swapped, carried, of_swap
    )


def find_scenario(name: str | Path) -> Path:
    """Return the file of a scenario given by name or path.

    Raises:
        ScenarioError: there is none; the message lists the nearest.
    """
    path = Path(name)
    if path.suffix == ".toml":
        if not path.is_file():
            raise ScenarioError(f"{path}: no such scenario file")
        return path
    study, _, scenario = str(name).partition("/")
    if study not in {folder.name for folder in studies()}:
        _refuse_path(path)
    folder = find_study(study)
    if scenario in (known := scenarios(folder)):
        return known[scenario]
    listed = f"`feeddrive scenarios {study}` lists all with their titles"
    if not scenario:
        raise ScenarioError(f"{study} is a study; name one of its scenarios: {listed}")
    remedy = did_you_mean(scenario, known)
    raise ScenarioError(
        f"study {study!r} has no scenario {scenario!r}; {remedy} {listed}."
    )


def _refuse_path(path: Path) -> None:
    """Refuse a path that is no scenario file; anything else may name a scenario."""
    if path.is_dir():
        beside, what = path, "is a folder"
    elif path.is_file():
        beside, what = path.parent, "is no scenario: that is a .toml file"
    elif path.suffix or path.is_absolute():
        beside, what = path.parent, "no such scenario file"
    else:
        return
    known = [str(file) for file in scenarios(beside).values()]
    raise ScenarioError(
        f"{path}: {what}; {did_you_mean(str(path), known)}"
        if known
        else f"{path}: {what}; `feeddrive scenarios` lists those of the studies"
    )


def studies() -> list[Path]:
    """Return the folders of the studies there are."""
    return [f for f in sorted(STUDIES.glob("*/")) if any(f.glob("*.toml"))]


def find_study(study: str) -> Path:
    """Return the folder of a study.

    Raises:
        ScenarioError: there is none of that name.
    """
    known = {folder.name: folder for folder in studies()}
    if study not in known:
        remedy = did_you_mean(study, known)
        raise ScenarioError(
            f"there is no study {study!r}; {remedy} A scenario is named "
            f"<study>/<scenario>, or by the path of its .toml file; `feeddrive "
            f"scenarios` lists them."
        )
    return known[study]


def scenarios(folder: Path) -> dict[str, Path]:
    """Return the scenarios of a folder by name; ``_name.toml`` is only a base."""
    files = sorted(folder.glob("*.toml"))
    return {
        f.stem: f
        for f in files
        if f.name not in _NOT_SCENARIOS and not f.name.startswith("_")
    }


def scenario_name(file: Path) -> str:
    """Return ``<study>/<scenario>`` for a study's file, the stem for any other."""
    if file.resolve().parent.parent == STUDIES.resolve():
        return f"{file.resolve().parent.name}/{file.stem}"
    return file.stem


def read_toml(file: Path) -> dict[str, Any]:
    """Return the content of a TOML file, numbers with their decimal text.

    Raises:
        ScenarioError: the file cannot be read or is no TOML.
    """
    try:
        return toml(read_toml_text(file), DecimalFloat)
    except OSError as error:
        raise ScenarioError(f"{file}: cannot be read ({error.strerror})") from None
    except ValueError as error:
        raise ScenarioError(f"{file}: not valid TOML: {error}") from None


def read_scenario(file: Path) -> dict[str, Any]:
    """Return a scenario's tables with everything it inherits from its bases.

    Raises:
        ScenarioError: a base is missing, malformed or inherits from itself.
    """
    layers: dict[Path, dict[str, Any]] = {}
    _gather(file.resolve(), (), layers)
    merged: dict[str, Any] = {}
    for layer in layers.values():
        merged = inherit(merged, layer)
    return merged


def _gather(
    file: Path, heirs: tuple[Path, ...], layers: dict[Path, dict[str, Any]]
) -> None:
    """Add the tables of a file behind those of its bases, each file once."""
    if len(heirs) > HEIRS:
        raise ScenarioError(f"{file}: base: more than {HEIRS} files inherit in a row")
    raw = read_toml(file)
    bases = raw.pop("base", [])
    for base in bases if isinstance(bases, list) else [bases]:
        parent = (file.parent / str(base)).resolve()
        if not parent.is_file() and "/" in str(base) and not parent.suffix:
            parent = find_scenario(str(base)).resolve()
        if not parent.is_file():
            known = [f.name for f in file.parent.glob("*.toml")]
            raise ScenarioError(
                f"{file}: base: no file {str(base)!r} beside it; "
                f"{did_you_mean(str(base), known)}"
            )
        if parent in (*heirs, file):
            raise ScenarioError(f"{file}: base: {base} inherits from itself")
        if parent not in layers:
            _gather(parent, (*heirs, file), layers)
    from_elsewhere = bool(heirs) and file.parent != heirs[0].parent
    layers[file] = homed(raw, file.parent) if from_elsewhere else raw


def _copy(raw: Mapping[str, Any]) -> dict[str, Any]:
    return {k: _copy(v) if isinstance(v, dict) else v for k, v in raw.items()}


def _swap(raw: dict[str, Any], component: str, swap: Mapping[str, Any]) -> None:
    components = raw.get("components", {})
    if component not in components:
        raise ScenarioError(
            f"--swap {component}: no such component; "
            f"{did_you_mean(component, components)}"
        )
    old = components[component]
    kept = {key: old[key] for key in (*_KEPT, *TABLES) if key in old}
    beside = swap.get("beside")
    if beside is not None:  # an adapter, which is sampled, before the FMU
        kept = {key: kept[key] for key in kept if key not in ("kind", "split")}
        for name, part in beside["components"].items():
            if name in components:
                raise ScenarioError(f"--socket: there is a component {name!r} already")
            step = {"step": old["step"]} if "step" in old else {}
            components[name] = {**step, **_copy(part)}
        raw.setdefault("connections", {}).update(beside["connections"])
    own = {key: value for key, value in swap.items() if key != "beside"}
    components[component] = _copy({**kept, **own})


def _set_by_map(raw: dict[str, Any]) -> None:
    """Make parameters of the values in maps, which go before the scenario's."""
    components = raw.get("components", {})
    for component in components.values() if isinstance(components, dict) else ():
        maps = component.get("map") if isinstance(component, dict) else None
        for name, entry in maps.items() if isinstance(maps, dict) else ():
            if isinstance(entry, dict) and "value" in entry:
                component.setdefault("parameters", {})[name] = entry.pop("value")


def _set_anew(spec: Specification, nominal: Specification) -> list[str]:
    """Return the components of which the FMU is another than the scenario's."""
    before = nominal.components
    return [
        n for n, c in spec.components.items() if n in before and c.fmu != before[n].fmu
    ]


def _carried(
    raw: Mapping[str, Any], plain: Mapping[str, Any], component: str
) -> dict[str, tuple[str, ...]]:
    """Return the values of a swapped component that are still the scenario's own."""
    before, now = (r["components"][component] for r in (plain, raw))
    return {
        table: tuple(
            key
            for key, value in before.get(table, {}).items()
            if now.get(table, {}).get(key) is value
        )
        for table in TABLES
    }


def _of_swap(
    with_swap: Mapping[str, Any],
    plain: Mapping[str, Any],
    changed: Mapping[str, Any],
    component: str,
) -> tuple[str, ...]:
    """Return the names of the values that a swap brought and no override replaced."""
    brought, ours, now = (
        {
            k: v
            for table in TABLES
            for k, v in one["components"][component].get(table, {}).items()
        }
        for one in (with_swap, plain, changed)
    )
    return tuple(
        name
        for name, value in brought.items()
        if ours.get(name) is not value and now.get(name) is value
    )


def _validate(raw: Mapping[str, Any], file: Path) -> Specification:
    try:
        return Specification.model_validate(raw, context=RateContext())
    except ValidationError as error:
        raise ScenarioError(f"{file}: " + "; ".join(complaints(error))) from None
