"""Groups of components that are iterated, checked; and what only Python carries out.

Members step together, so they have one kind, period and offset, no latency, and are
split alike; their states can be got and set.  What passes between them is real, and
nothing acts on it: no fault, no injection.
"""

from collections.abc import Iterator, Mapping, Sequence

from orchestrator.errors import SimulationError, WiringError, did_you_mean
from orchestrator.fmu.whole import Listed
from orchestrator.master.layout import Faulty, Group, Injected, Part, Wiring
from orchestrator.master.places import Copy
from orchestrator.system import Iterated, System


def groups_of(
    system: System,
    parts: Mapping[str, Part],
    faulty: Sequence[Faulty],
    injected: Sequence[Injected],
) -> Iterator[Group]:
    """Yield the groups of a system.

    Raises:
        WiringError: one cannot be iterated; the message says why.
    """
    taken: dict[str, str] = {}
    for name, asked in system.groups.items():
        where = f"groups.{name}"
        for member in asked.components:
            if member not in parts:
                raise WiringError(
                    f"{where}: no component {member!r}; {did_you_mean(member, parts)}"
                )
            if member in taken:
                raise WiringError(
                    f"{where}: {member} is in groups.{taken[member]} already; a "
                    f"component is iterated in one group"
                )
            taken[member] = name
        members = [part for n, part in parts.items() if n in asked.components]
        _refuse_apart(where, members)
        inner = tuple(_inner(where, members))
        places = {copy.sink for copy in inner}
        acting = {*(f.place for f in faulty), *(i.place for i in injected)}
        if acting & places:
            raise WiringError(
                f"{where}: a fault or an injection acts on a connection between its "
                f"members, which have to agree; leave the group or that out"
            )
        yield _group(name, asked, members, inner)


def _group(
    name: str, asked: Iterated, members: Sequence[Part], inner: tuple[Copy, ...]
) -> Group:
    return Group(name, tuple(p.name for p in members), inner, asked.tolerance)


def _refuse_apart(where: str, members: Sequence[Part]) -> None:
    for part in members:
        if part.component.latency:
            raise WiringError(
                f"{where}: {part.name} has a latency, which cuts the loop; remove it, "
                f"or take {part.name} out of the group"
            )
        if not part.fmu.co_simulation or part.component.interface == "model_exchange":
            raise WiringError(
                f"{where}: {part.name} is for model exchange, and its integrator "
                f"cannot be taken back; use its co-simulation"
            )
        if not part.fmu.gets_state:
            raise WiringError(
                f"{where}: {part.name} ({part.fmu.path.name}) has no state to come "
                f"back to (canGetAndSetFMUState is false), so that its steps cannot be "
                f"repeated; ask its supplier for it, or take it out of the group"
            )
    first = members[0]
    for part in members[1:]:
        one, other = part.component, first.component
        for what, mine, theirs in (
            ("kind", part.kind, first.kind),
            ("step", f"{one.period} s", f"{other.period} s"),
            ("offset", f"{one.offset} s", f"{other.offset} s"),
            ("split", part.splits, first.splits),
        ):
            if mine != theirs:
                raise WiringError(
                    f"{where}: {part.name} and {first.name} differ in {what} ({mine}, "
                    f"{theirs}); members of a group step together"
                )


def _inner(where: str, members: Sequence[Part]) -> Iterator[Copy]:
    """Yield what the members copy to one another."""
    owners = {
        place: part.name
        for part in members
        for place in range(part.first_input, part.first_input + part.input_size)
    }
    found = [c for part in members for c in part.copies if c.sink in owners]
    if not found:
        raise WiringError(
            f"{where}: no connection leads from one of its members to one of them; "
            f"there is nothing to iterate"
        )
    sorts = {
        part.first_input + i: v.sort
        for part in members
        for i, v in enumerate(v for v in part.inputs for _ in range(v.size))
    }
    for copy in found:
        if not copy.is_of_doubles or sorts[copy.sink] != "real":
            raise WiringError(
                f"{where}: {copy.ends} is no connection of real numbers; only these "
                f"are iterated"
            )
        yield copy


def refuse_unless_python(wiring: Wiring, who: str) -> None:
    """Refuse what only the Python executor carries out, for any other.

    Raises:
        SimulationError: it says what that is.
    """
    if why := only_python(wiring):
        raise SimulationError(f"{who}: {why}, which the executor python alone does")


def only_python(wiring: Wiring) -> str:
    """Return what of a system only the Python executor carries out, "" if nothing."""
    if wiring.groups:
        return f"groups.{wiring.groups[0].name} is iterated"
    if wiring.texts:
        return f"{wiring.texts[0].ends} carries a text"
    for part in wiring.parts.values():
        for copy in part.copies:
            if isinstance(copy.whole, Listed):
                return f"{copy.ends} is looked up in a table"
    return ""
