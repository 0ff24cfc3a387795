"""A package as a folder: our scenario beside the FMUs it runs."""

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.load import checked, read_package
from orchestrator.scenario.override import apply_override
from orchestrator.scenario.reading import scenario_from

FMUS = "fmus"


def write_beside(
    path: Path, folder: Path, variant: str | None = None, overrides: Sequence[str] = ()
) -> Path:
    """Write a package's scenario and FMUs into a folder; return the scenario's file.

    Raises:
        ScenarioError: something of it cannot be run, or the file is there already.
    """
    import tomli_w

    tables = read_package(path, variant)
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
    scenario_from(raw, file)  # what cannot be read back is not written
    file.write_bytes(tomli_w.dumps(_plain(raw)).encode())
    return file


def _plain(value: Any) -> Any:
    """Return tables as TOML can hold them."""
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return float(value) if isinstance(value, float) else value
