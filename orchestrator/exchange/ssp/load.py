"""A package as a scenario: read, everything that cannot be run named at once."""

import atexit
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.exchange.ssp.bindings import parse
from orchestrator.exchange.ssp.package import description, inside, unpack
from orchestrator.exchange.ssp.read import read_structure
from orchestrator.exchange.ssp.scenario import Tables
from orchestrator.exchange.ssp.xml import NAMESPACES, against_schema
from orchestrator.folders.temporary import temporary_folder
from orchestrator.scenario.reading import Scenario, Swaps, read_toml, scenario_from
from orchestrator.warned import warn

_NUMBERS = count()


def read_package(
    path: str | Path,
    variant: str | None = None,
    folder: Path | None = None,
    ssv: Sequence[str] = (),
) -> Tables:
    """Return the scenario's tables of a package, and what is to be said of it.

    An archive is unpacked into ``folder`` (default: one that ends with the process).
    ``ssv`` names parameter sets that are bound to the whole system: files, or those of
    the package.

    Raises:
        ScenarioError: it is no package, or its description is none.
    """
    path = Path(path)
    place = folder or _workspace() / str(next(_NUMBERS))
    place.mkdir(parents=True, exist_ok=True)
    root = unpack(path, place)
    file = description(path, root, variant)
    sets = [_parameter_set(name, root) for name in ssv]
    structure = read_structure(file, root, _workspace() / str(next(_NUMBERS)), sets)
    rest: Mapping[str, Any] = {}
    if structure.timing is not None:
        rest = read_toml(inside(root, file.parent, structure.timing.scenario))
    return Tables(structure, rest)


def _parameter_set(name: str, root: Path) -> Path:
    """Return a parameter set by its path, or by its name in the package."""
    if (file := Path(name)).is_file():
        return file
    known = {f.name: f for f in sorted(root.rglob("*.ssv"))}
    for inside_package in (name, f"{name}.ssv"):
        if inside_package in known:
            return known[inside_package]
    raise ScenarioError(
        f"--ssv {name}: there is no such file, and none in the package; "
        f"{did_you_mean(name, known)}"
    )


def load_package(
    path: str | Path,
    overrides: Sequence[str] = (),
    swaps: Swaps | None = None,
    variant: str | None = None,
    ssv: Sequence[str] = (),
) -> Scenario:
    """Return the scenario of a package, which can be run as any other.

    Raises:
        ScenarioError: something of it cannot be run, or a time is said by nobody.
    """
    tables = read_package(path, variant, ssv=ssv)
    raw = checked(tables, Path(path), overrides)
    file = Path(path).resolve().parent / f"{Path(path).stem}.toml"
    return scenario_from(raw, file, overrides, swaps)


def checked(
    tables: Tables, path: Path, overrides: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the tables of a scenario without faults, its notes warned of.

    Raises:
        ScenarioError: all that cannot be run, or the one line that is to be added.
    """
    if tables.faults:
        count = len(tables.faults)
        things = "one thing" if count == 1 else f"{count} things"
        raise ScenarioError(
            f"{path}: {things} cannot be run:\n  " + "\n  ".join(tables.faults)
        )
    said = {text.partition("=")[0].strip() for text in overrides}
    asked = []
    for key, proposal in tables.lacking.items():
        if key not in said:
            what = "step" if key == "rates.step" else "stop time"
            asked.append(
                f"nobody says a {what}; add --set {key}=..."
                + (f", for instance {proposal}" if proposal else "")
            )
    if asked:
        raise ScenarioError(f"{path}: " + "; ".join(asked))
    for note in tables.notes:
        warn(f"{path.name}: {note}")
    for place, name in tables.names.items():
        if place[-1] != name:
            warn(f"{path.name}: {'/'.join(place)} is called {name} here")
    raw = tables.tables()
    if "rates" in raw:
        raw["rates"] = {"step": None}
    return raw


def schema_faults(path: str | Path, variant: str | None = None) -> list[str]:
    """Return where the documents of a package do not follow their schemas.

    Raises:
        ScenarioError: it is no package.
    """
    path = Path(path)
    place = _workspace() / str(next(_NUMBERS))
    place.mkdir(parents=True)
    root = unpack(path, place)
    file = description(path, root, variant)
    found = []
    documents = [file]
    if path.suffix.lower() != ".ssd":
        documents += sorted(f for f in root.rglob("*") if f.suffix in (".ssv", ".ssm"))
    for one in documents:
        document = parse(one)
        inner = document.iter(
            f"{{{NAMESPACES['ssv']}}}ParameterSet",
            f"{{{NAMESPACES['ssm']}}}ParameterMapping",
        )
        for part in (document, *(e for e in inner if e is not document)):
            found += [f"{one.name}: {fault}" for fault in against_schema(part)]
    return found


@cache
def _workspace() -> Path:
    kept = ExitStack()
    atexit.register(kept.close)
    return kept.enter_context(temporary_folder())
