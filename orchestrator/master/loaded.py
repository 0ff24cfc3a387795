"""FMUs that stay loaded from one run to the next, of the same system or a like one.

Each is instantiated again for every run, in the library and the process that it
has.  Of what the next system does not need some libraries stay for the one after it;
processes are freed when its first run begins.
"""

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

from orchestrator.instances.instance import LocalInstance
from orchestrator.instances.protocol import Instance
from orchestrator.master.apart import let_in
from orchestrator.master.layout import Part
from orchestrator.master.simulate import open_instance
from orchestrator.master.timetable import Timetable
from orchestrator.system import Isolation

IDLE = 16  # FMU files in this process that stay loaded and are not needed

Numbers: TypeAlias = tuple[tuple[str, int], ...]  # names of variables, with sizes
Key: TypeAlias = tuple[str, Isolation, Numbers, Numbers]


@dataclass(frozen=True)
class _Shelf:
    """One FMU file, unpacked, with its instances."""

    stack: ExitStack = field(default_factory=ExitStack)
    folders: dict[Path, Path] = field(default_factory=dict)
    instances: dict[Key, Instance] = field(default_factory=dict)

    @property
    def is_here(self) -> bool:
        """Tell whether no instance has a process of its own."""
        return all(isinstance(i, LocalInstance) for i in self.instances.values())


class Loaded:
    """The FMUs that one thread keeps loaded; ``drop`` frees them all."""

    def __init__(self) -> None:
        self._shelves: dict[Path, _Shelf] = {}

    def instances(self, timetable: Timetable) -> dict[str, Instance]:
        """Return an instance of every component, loaded now or before.

        Raises:
            FmuError: a library cannot be loaded here.
        """
        strangers = let_in(timetable)  # a series has no child of its own for them
        parts = timetable.wiring.parts
        keys = {n: _key(part, apart=n in strangers) for n, part in parts.items()}
        self._free_others(parts, keys)
        return {name: self._one(part, keys[name]) for name, part in parts.items()}

    def drop(self) -> None:
        """Free all instances and delete what was unpacked."""
        for path in list(self._shelves):
            self._shelves.pop(path).stack.close()

    def _free_others(self, parts: Mapping[str, Part], keys: Mapping[str, Key]) -> None:
        idle = []
        for path, shelf in list(self._shelves.items()):
            wanted = {keys[n] for n, part in parts.items() if part.fmu.path == path}
            if not wanted and shelf.is_here:
                idle.append(path)
            elif not wanted or not wanted <= shelf.instances.keys():
                self._shelves.pop(path).stack.close()
        for path in idle[:-IDLE]:
            self._shelves.pop(path).stack.close()

    def _one(self, part: Part, key: Key) -> Instance:
        shelf = self._shelves.setdefault(part.fmu.path, _Shelf())
        if key not in shelf.instances:
            isolation = key[1]
            shelf.instances[key] = open_instance(
                part.name, part.fmu, shelf.stack, isolation, shelf.folders
            )
        return shelf.instances[key]


def _key(part: Part, *, apart: bool) -> Key:
    isolation = part.component.isolation
    if apart:
        isolation = replace(isolation, process=True)
    inputs, read = (
        tuple((v.name, v.size) for v in variables)
        for variables in (part.inputs, part.read)
    )
    return part.name, isolation, inputs, read
