"""Names of ours for components whose own may be any text, on any level."""

import re

from orchestrator.exchange.ssp.flat import Path
from orchestrator.scenario.schema import RESERVED


def names_of(paths: list[Path]) -> dict[Path, str]:
    """Return a name of ours for every component: its own where that is one."""
    found: dict[Path, str] = {}
    last = [path[-1] for path in paths]
    for path in paths:
        written = path[-1] if last.count(path[-1]) == 1 else "_".join(path)
        name = re.sub(r"\W", "_", written)
        if not re.match(r"[A-Za-z_]", name):
            name = f"_{name}"
        if name in RESERVED:
            name += "_"
        taken, number = set(found.values()), 2
        plain = name
        while name in taken:
            name, number = f"{plain}_{number}", number + 1
        found[path] = name
    return found
