"""A package as a folder: our scenario beside the FMUs it runs.

The package itself is kept there too.  As long as scenario and FMUs are what it said,
they are exported as its bytes, with everything in it that we do not know.
"""

import shutil
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any
from zipfile import is_zipfile

from fmus.cache import digest
from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.load import checked, read_package
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.override import apply_override
from orchestrator.scenario.reading import Scenario, scenario_from
from orchestrator.warned import warn

FMUS = "fmus"
KEPT = "imported.ssp"


def write_beside(
    path: Path,
    folder: Path,
    variant: str | None = None,
    overrides: Sequence[str] = (),
    ssv: Sequence[str] = (),
) -> Path:
    """Write a package's scenario and FMUs into a folder; return the scenario's file.

    Raises:
        ScenarioError: something of it cannot be run, or the file is there already.
    """
    import tomli_w

    tables = read_package(path, variant, ssv=ssv)
    raw = checked(tables, path, overrides)
    for text in overrides:
        apply_override(raw, text)
    file = folder / f"{tables.structure.name.replace('/', '_')}.toml"
    if file.exists():
        raise ScenarioError(f"{file}: is there already; give another folder with -o")
    (folder / FMUS).mkdir(parents=True, exist_ok=True)
    for name, component in raw["components"].items():
        source = Path(component["fmu"])
        target = folder / FMUS / f"{name}.fmu"
        shutil.copyfile(source, target)
        component["fmu"] = f"{FMUS}/{name}.fmu"
    scenario = scenario_from(raw, file)  # what cannot be read back is not written
    if is_zipfile(path) and not ssv:
        shutil.copyfile(path, folder / KEPT)
        told = {
            name: digest(folder / FMUS / f"{name}.fmu")
            for name in tables.names.values()
        }
        raw["lock"] = {"ssp": {"file": KEPT, "content": _content(scenario, told)}}
    file.write_bytes(tomli_w.dumps(_plain(raw)).encode())
    return file


def kept(composition: Composition) -> Path | None:
    """Return the package a composition was imported from and still is, if any.

    Raises:
        ScenarioError: it is no more beside the scenario.
    """
    scenario = composition.scenario
    told = scenario.spec.lock.get("ssp")
    if told is None:
        return None
    if told["content"] != _content(scenario, composition.digests):
        warn(
            f"{scenario.file.name} was changed since it was imported: the package is "
            f"written anew, without what feeddrive does not know in {told['file']}"
        )
        return None
    file = scenario.file.parent / str(told["file"])
    if not file.is_file():
        raise ScenarioError(
            f"{scenario.file}: lock.ssp: {file.name}, from which it was imported, "
            f"is not beside it; put it back, or remove the table lock.ssp"
        )
    return file


def _content(scenario: Scenario, digests: Mapping[str, str]) -> str:
    """Return a fingerprint of what a scenario says and of its FMUs."""
    said = scenario.nominal.model_copy(update={"lock": {}})
    changed = scenario.overrides, scenario.swapped
    whole = f"{said!r}{changed}{sorted(digests.items())}"
    return sha256(whole.encode()).hexdigest()


def _plain(value: Any) -> Any:
    """Return tables as TOML can hold them."""
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return float(value) if isinstance(value, float) else value
