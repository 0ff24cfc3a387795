"""A map proposed for a foreign FMU whose names differ: never applied by itself.

Our names that a composition uses, our other inputs and our parameters are matched
with the foreign variables of the same causality and type so that unit, description,
range and name agree best in sum (an assignment problem).  Signs, and gains that
units do not give, are those that a pulse on both FMUs measured; what is doubtful is
said in the line's comment.
"""

import json
import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher

import numpy as np

from fmus.units import UnitError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.quantities.unit import conversion
from orchestrator.scenario.pulse import Measured, Subject, measure, signs
from orchestrator.system import Component, System, split_name

LEAST = 1.0  # points below which two variables have nothing in common
BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True)
class Proposed:
    """One of our names and the foreign variable it may be; None if there is none.

    ``doubts`` say what has to be looked at before the line is used; ``gain`` and
    ``measured`` come of a pulse on both FMUs.
    """

    ours: FmuVariable
    theirs: FmuVariable | None
    doubts: tuple[str, ...] = ()
    gain: float | None = None
    measured: tuple[str, ...] = ()

    @property
    def is_plain(self) -> bool:
        """Whether name and sign are the same and the units convert by themselves."""
        theirs = self.theirs
        same = theirs is not None and theirs.name == self.ours.name
        fits = theirs is None or _gain(self.ours, theirs) is not None
        return same and self.gain in (None, 1.0) and (fits or self.ours.unit is None)

    def to_toml(self) -> str:
        """Return the line of a map, with what speaks for and against it."""
        ours = self.ours
        if self.theirs is None:
            return f"# {ours.name}: nothing fits ({_about(ours)})"
        key = ours.name if BARE_KEY.fullmatch(ours.name) else json.dumps(ours.name)
        name = json.dumps(self.theirs.name)
        gain = 1.0 if self.gain is None else self.gain
        value = name if gain == 1 else f"{{ name = {name}, gain = {gain:.9g} }}"
        if _gain(ours, self.theirs) is None and ours.unit:
            unit = json.dumps(ours.unit)
            value = f"{{ name = {name}, gain = {gain:.9g}, unit = {unit} }}"
        told = "".join(f"; measured: {text}" for text in self.measured)
        told += "".join(f"; CHECK: {doubt}" for doubt in self.doubts)
        return f"{key} = {value}  # {_about(ours)} = {_about(self.theirs)}{told}"


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


def lacking(system: System, component: str, theirs: FmuDescription) -> list[str]:
    """Return the names that a system connects or records and another FMU has not."""
    return missing_names(used_names(system, component), theirs)


def propose(
    names: Sequence[str],
    ours: FmuDescription,
    theirs: FmuDescription,
    taken: Collection[str] = (),
) -> list[Proposed]:
    """Match our variables of these names with those of another FMU that are free."""
    from scipy.optimize import linear_sum_assignment

    wanted = [v for name in names for v in _members(ours, name)]
    free = (v for v in theirs.variables.values() if v.name not in taken)
    offered = [v for v in free if v.variability != "constant"]
    points = np.zeros((len(wanted), len(offered)))
    places = _places(ours), _places(theirs)
    for i, mine in enumerate(wanted):
        for j, other in enumerate(offered):
            apart = abs(places[0][mine.name] - places[1][other.name])
            points[i, j] = _points(mine, other) - 0.2 * apart
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


def proposal(
    original: System, component: str, ours: FmuDescription, theirs: FmuDescription
) -> str:
    """Return the map that is proposed, as TOML.

    First the names in use, then what is set, our other inputs and parameters.  Both
    FMUs are run alone for as long as a pulse takes; a name that both have is listed
    where its sign or unit differs.
    """
    part = original.components[component]
    used = used_names(original, component)
    known = [n for n, v in ours.variables.items() if v.causality == "parameter"]
    helpful = [*part.parameters, *part.start, *ours.inputs, *known]
    both = [n for n in dict.fromkeys((*used, *helpful)) if n in ours.variables]
    found = [Proposed(ours[n], theirs[n]) for n in both if n in theirs.variables]
    for names in (used, [n for n in dict.fromkeys(helpful) if n not in used]):
        taken = {line.theirs.name for line in found if line.theirs}
        found += propose(missing_names(names, theirs), ours, theirs, taken)
    found = with_measured(found, _measured(part, ours, theirs, found))
    told = [line for line in found if line.theirs or line.ours.name in used]
    return to_toml(told, theirs)


def _measured(
    part: Component,
    ours: FmuDescription,
    theirs: FmuDescription,
    proposed: Sequence[Proposed],
) -> list[Measured]:
    subjects = (
        Subject(ours, part.period, {**part.parameters, **part.start}),
        Subject(theirs, part.period, {}),
    )
    pairs = [
        (line.ours, line.theirs)
        for line in proposed
        if line.theirs and line.ours.size == 1 and line.ours.sort == "real"
    ]
    inputs = [
        (mine, other, 1 / (_gain(mine, other) or 1.0))
        for mine, other in pairs
        if mine.causality == "input"
    ]
    outputs = [pair for pair in pairs if pair[0].causality == "output"]
    return measure(*subjects, inputs, outputs)


def with_measured(
    proposed: Sequence[Proposed], measured: Sequence[Measured]
) -> list[Proposed]:
    """Return the proposal with the signs and ratios that a pulse has measured."""
    sign = signs(measured)
    return [_with_measured(line, measured, sign) for line in proposed]


def _with_measured(
    line: Proposed, measured: Sequence[Measured], sign: Mapping[str, float]
) -> Proposed:
    name = line.ours.name
    answers = [one for one in measured if name in (one.input, one.output)]
    if line.theirs is None or not answers:
        return line
    if name not in sign:
        doubt = "its answers to pulses contradict one another in sign"
        return replace(line, doubts=(*line.doubts, doubt))
    if line.ours.causality == "input":
        told = "reversed" if sign[name] < 0 else "the same sense"
        return replace(line, gain=sign[name], measured=(told,))
    best = max(answers, key=lambda one: one.likeness)
    gain, doubts = sign[name], list(line.doubts)
    units = f"{line.theirs.unit or 1} for {line.ours.unit or 1}"
    if _gain(line.ours, line.theirs) is None:
        gain /= abs(best.ratio)
        doubts = [doubt for doubt in doubts if doubt != _unset(line.ours, line.theirs)]
    if not best.is_exact:
        doubts.append(f"the answers are alike to {100 * best.likeness:.3g} % only")
    moves = ", ".join(f"{one.input} {one.ratio:+.5g}" for one in answers)
    return replace(
        line, gain=gain, doubts=tuple(doubts), measured=(f"{units} by {moves}",)
    )


def to_toml(proposed: Sequence[Proposed], theirs: FmuDescription | None = None) -> str:
    """Return the proposal as the text of a map file.

    With the foreign FMU also its inputs that are none of ours, to be given a value.
    """
    lines = [line.to_toml() for line in proposed if not line.is_plain]
    taken = {line.theirs.name for line in proposed if line.theirs}
    for v in theirs.variables.values() if theirs else ():
        if v.causality == "input" and v.name not in taken and v.sort != "string":
            key = v.name if BARE_KEY.fullmatch(v.name) else json.dumps(v.name)
            entry = f"{{ name = {json.dumps(v.name)}, value = {v.start or 0} }}"
            lines.append(f"# {key} = {entry}  # nothing drives {_about(v)}")
    return "\n".join(lines) + "\n"


def _members(fmu: FmuDescription, name: str) -> list[FmuVariable]:
    return [v for n, v in fmu.variables.items() if name in _prefixes(n)]


def _places(fmu: FmuDescription) -> dict[str, int]:
    """Return the number of every variable among those of its causality."""
    counts: Counter[str] = Counter()
    found = {}
    for name, variable in fmu.variables.items():
        found[name] = counts[variable.causality]
        counts[variable.causality] += 1
    return found


def _points(ours: FmuVariable, theirs: FmuVariable) -> float:
    """Return how well two variables fit, from 0; unlike roles never do."""
    inputs = ours.causality == "input", theirs.causality == "input"
    if inputs[0] != inputs[1] or ours.sort != theirs.sort or ours.size != theirs.size:
        return 0.0
    points = 6.0 if ours.causality == theirs.causality else 0.0  # before all else
    parameter = "parameter" in (ours.causality, theirs.causality)
    if parameter and not _may_be_one(ours, theirs):
        return 0.0
    if ours.base_unit is None or theirs.base_unit is None:
        points += 0.5
    elif _gain(ours, theirs) is not None:
        points += 3.0
    elif ours.base_unit.s == theirs.base_unit.s:  # a position, not a speed
        points += 1.0
    points += 2.0 * _common(ours.description, theirs.description)
    points += SequenceMatcher(None, ours.name.lower(), theirs.name.lower()).ratio()
    return points + (1.0 if _same_range(ours, theirs) else 0.0)


def _may_be_one(ours: FmuVariable, theirs: FmuVariable) -> bool:
    """Tell whether two parameters have more in common than being parameters."""
    if ours.causality != theirs.causality:
        return False
    if _gain(ours, theirs) is None and (ours.unit or theirs.unit):
        return False
    alike = SequenceMatcher(None, ours.name.lower(), theirs.name.lower()).ratio()
    return max(alike, _common(ours.description, theirs.description)) > 0.3


def _gain(ours: FmuVariable, theirs: FmuVariable) -> float | None:
    """Return how many of our unit one of theirs is; None if that is unknown."""
    if ours.unit is None or theirs.unit is None:
        return None
    try:
        return conversion(theirs.unit, ours.unit).gain
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
        doubts.append(_unset(ours, theirs))
    if near:
        doubts.append(f"or {', '.join(near[:3])}?")
    return doubts


def _unset(ours: FmuVariable, theirs: FmuVariable) -> str:
    return f"set the gain from {theirs.unit} to {ours.unit} and the sign"


def _about(variable: FmuVariable) -> str:
    text = " ".join(variable.description.split())
    unit = variable.unit or "no unit"
    return f"{variable.name} [{unit}] {text}".rstrip()
