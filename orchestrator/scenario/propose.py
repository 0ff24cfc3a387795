"""A map proposed for a foreign FMU whose names differ: never applied by itself.

Our names that a composition uses are matched with the foreign variables of the
same causality and type so that unit, description, range and name agree best in
sum (an assignment problem); what is doubtful is said in the line's comment.
"""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

import numpy as np

from fmus.units import UnitError, conversion
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.system import System, split_name

LEAST = 1.0  # points below which two variables have nothing in common
BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True)
class Proposed:
    """One of our names and the foreign variable it may be; None if there is none.

    ``doubts`` say what has to be looked at before the line is used.
    """

    ours: FmuVariable
    theirs: FmuVariable | None
    doubts: tuple[str, ...] = ()

    def to_toml(self) -> str:
        """Return the line of a map, with what speaks for and against it."""
        ours = self.ours
        if self.theirs is None:
            return f"# {ours.name}: nothing fits ({_about(ours)})"
        key = ours.name if BARE_KEY.fullmatch(ours.name) else json.dumps(ours.name)
        name = json.dumps(self.theirs.name)
        value = name
        if _gain(ours, self.theirs) is None and ours.unit:
            value = f"{{ name = {name}, gain = 1.0, unit = {json.dumps(ours.unit)} }}"
        doubts = "".join(f"; CHECK: {doubt}" for doubt in self.doubts)
        return f"{key} = {value}  # {_about(ours)} = {_about(self.theirs)}{doubts}"


def used_names(system: System, component: str) -> list[str]:
    """Return the variables of a component that a system connects or records."""
    ends = [*system.connections, *system.connections.values(), *system.record]
    found = (split_name(end) for end in ends)
    return list(dict.fromkeys(name for owner, name in found if owner == component))


def missing_names(names: Sequence[str], theirs: FmuDescription) -> list[str]:
    """Return the names that an FMU has neither as a variable nor as a record."""
    prefixes = {part for name in theirs.variables for part in _prefixes(name)}
    return [name for name in names if name not in prefixes]


def _prefixes(name: str) -> list[str]:
    ends = [m.start() for m in re.finditer(r"[.\[]", name)]
    return [name, *(name[:end] for end in ends)]


def propose(
    names: Sequence[str], ours: FmuDescription, theirs: FmuDescription
) -> list[Proposed]:
    """Match our variables of these names with those of another FMU."""
    from scipy.optimize import linear_sum_assignment

    wanted = [v for name in names for v in _members(ours, name)]
    offered = [v for v in theirs.variables.values() if v.variability != "constant"]
    points = np.zeros((len(wanted), len(offered)))
    for i, mine in enumerate(wanted):
        for j, other in enumerate(offered):
            places = _place(ours, mine), _place(theirs, other)
            points[i, j] = _points(mine, other) - 0.2 * abs(places[0] - places[1])
    rows, columns = linear_sum_assignment(points, maximize=True)
    chosen = dict(zip(rows.tolist(), columns.tolist(), strict=True))
    found = []
    for i, mine in enumerate(wanted):
        j = chosen.get(i, 0)
        if i not in chosen or points[i, j] < LEAST:
            found.append(Proposed(mine, None))
            continue
        near = np.flatnonzero(points[i] > points[i, j] - 0.3).tolist()
        others = [offered[k].name for k in near if k != j]
        doubts = _doubts(mine, offered[j], others)
        found.append(Proposed(mine, offered[j], tuple(doubts)))
    return found


def to_toml(proposed: Sequence[Proposed]) -> str:
    """Return the proposal as the text of a map file."""
    return "\n".join(line.to_toml() for line in proposed) + "\n"


def _members(fmu: FmuDescription, name: str) -> list[FmuVariable]:
    return [v for n, v in fmu.variables.items() if name in _prefixes(n)]


def _place(fmu: FmuDescription, variable: FmuVariable) -> int:
    alike = [v for v in fmu.variables.values() if v.causality == variable.causality]
    return alike.index(variable)


def _points(ours: FmuVariable, theirs: FmuVariable) -> float:
    """Return how well two variables fit, from 0; unlike roles never do."""
    inputs = ours.causality == "input", theirs.causality == "input"
    if inputs[0] != inputs[1] or ours.sort != theirs.sort or ours.size != theirs.size:
        return 0.0
    points = 6.0 if ours.causality == theirs.causality else 0.0  # before all else
    if ours.base_unit is None or theirs.base_unit is None:
        points += 0.5
    elif _gain(ours, theirs) is not None:
        points += 3.0
    points += 2.0 * _common(ours.description, theirs.description)
    points += SequenceMatcher(None, ours.name.lower(), theirs.name.lower()).ratio()
    return points + (1.0 if _same_range(ours, theirs) else 0.0)


def _gain(ours: FmuVariable, theirs: FmuVariable) -> float | None:
    """Return how many of our unit one of theirs is; None if that is unknown."""
    if ours.base_unit is None or theirs.base_unit is None:
        return None
    try:
        return conversion(theirs.base_unit, ours.base_unit).gain
    except UnitError:
        return None


def _common(one: str, other: str) -> float:
    words = [set(re.findall(r"[a-z]{2,}", text.lower())) for text in (one, other)]
    either = words[0] | words[1]
    return len(words[0] & words[1]) / len(either) if either else 0.0


def _same_range(ours: FmuVariable, theirs: FmuVariable) -> bool:
    bounds = [(ours.min, theirs.min), (ours.max, theirs.max)]
    pairs = [(float(a), float(b)) for a, b in bounds if a and b]
    gain = _gain(ours, theirs)
    if not pairs or gain is None:
        return False
    return all(bool(np.isclose(a, gain * b)) for a, b in pairs)


def _doubts(ours: FmuVariable, theirs: FmuVariable, near: Sequence[str]) -> list[str]:
    doubts = []
    if theirs.unit is None and ours.unit not in (None, "1"):
        doubts.append(f"it has no unit; is it in {ours.unit}?")
    elif _gain(ours, theirs) is None:
        doubts.append(f"set the gain from {theirs.unit} to {ours.unit} and the sign")
    if near:
        doubts.append(f"or {', '.join(near[:3])}?")
    return doubts


def _about(variable: FmuVariable) -> str:
    text = " ".join(variable.description.split())
    unit = variable.unit or "no unit"
    return f"{variable.name} [{unit}] {text}".rstrip()
