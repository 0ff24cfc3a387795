"""Sockets: which adapter stands before a drive's FMU, and what its objects are called.

``--swap drive=their.fmu --socket csp`` puts the adapter in the component's place, in
SI units and under our names, and the FMU beside it as ``drive_fmu``.  An object of the
drive is found by the names it usually has, letters and digits alone compared, or by
its index; a line of the map names it where that does not suffice.
"""

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.fmu.description import FmuDescription, read_fmu

HERE = Path(__file__).parent


@cache
def sockets() -> Mapping[str, Mapping[str, Any]]:
    """Return all sockets by name."""
    return {
        file.stem: tomllib.loads(file.read_text(encoding="utf-8"))
        for file in sorted(HERE.glob("*.toml"))
    }


def plugged(
    component: str, file: str, map_: Mapping[str, Any], name: str
) -> dict[str, Any]:
    """Return the tables of a component behind a socket, its drive beside it.

    Raises:
        ScenarioError: no such socket, or an object of the drive is not found.
    """
    known = sockets()
    if name not in known:
        raise ScenarioError(f"--socket {name}: {did_you_mean(name, known)}")
    socket = known[name]
    fmu = read_fmu(file)
    drive, wires = f"{component}_fmu", {}
    maps: dict[str, Any] = {}
    missing = []
    objects = {**socket["to_drive"], **socket["from_drive"]}
    for one, about in objects.items():
        inward = one in socket["to_drive"]
        found = _found(fmu, one, about, map_, inward=inward)
        if found is None:
            missing += [] if about.get("optional") else [one]
            continue
        entry = {"name": found}
        if inward and fmu.variables[found].sort == "integer":
            entry["range"] = about["range"]
        maps[one] = entry
        ends = (drive, component) if inward else (component, drive)
        wires[f"{ends[0]}.{one}"] = f"{ends[1]}.{one}"
    if missing:
        lines = ", ".join(f'{one} = "..."' for one in missing)
        raise ScenarioError(
            f"--socket {name}: {fmu.path.name} has nothing that is called "
            f"{' or '.join(missing)}; name it there: --map '{lines}'. Inputs are "
            f"{', '.join(fmu.inputs) or 'none'}; outputs are "
            f"{', '.join(fmu.outputs) or 'none'}"
        )
    return {
        "fmu": socket["adapter"],
        "map": {k: v for k, v in map_.items() if k not in objects},
        "beside": {
            "components": {drive: {"fmu": file, "map": maps}},
            "connections": wires,
        },
    }


def _found(
    fmu: FmuDescription,
    one: str,
    about: Mapping[str, Any],
    map_: Mapping[str, Any],
    *,
    inward: bool,
) -> str | None:
    """Return the drive's name of an object, None if it has none.

    Raises:
        ScenarioError: several may be meant, or the map names none of its variables.
    """
    there = fmu.inputs if inward else fmu.outputs
    if one in map_:
        named = str(map_[one])
        if named not in there:
            what = "input" if inward else "output"
            raise ScenarioError(
                f"--map: {one} = {named!r}: {fmu.path.name} has no such {what}; "
                f"{did_you_mean(named, there)}"
            )
        return named
    wanted = {_plain(name) for name in about["names"]}
    indices = {name for name in wanted if re.fullmatch(r"6[0-9a-f]{3}", name)}
    exact = [n for n in there if _plain(n.rpartition(".")[2]) in wanted]
    found = exact or [n for n in there if any(i in _plain(n) for i in indices)]
    if len(found) > 1:
        raise ScenarioError(
            f"--socket: {one} may be {' or '.join(found)} of {fmu.path.name}; name it "
            f"with --map '{one} = \"...\"'"
        )
    return found[0] if found else None


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())
