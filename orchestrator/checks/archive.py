"""An FMU archive as the static items see it, read once."""

import re
import zipfile
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from fmpy import read_model_description
from fmpy.validation import validate_model_description
from lxml import etree

from orchestrator.checks.item import CannotRun
from orchestrator.errors import FmuError
from orchestrator.fmu.archive import checked_members, read_member
from orchestrator.fmu.description import FmuDescription, read_fmu

P = ParamSpec("P")
T = TypeVar("T")

DESCRIPTION = "modelDescription.xml"
# Which item a message of fmpy belongs to; what fits none is of the description.
TOPICS = (
    (3, r"not unique|variable name|illegal|same value reference|independent variable"),
    (4, r"must have variability|start value|combination causality"),
    (5, r"ModelStructure|dependenciesKind|state derivative"),
    (7, r"[uU]nit"),
)


class Archive:
    """One FMU file.  Whatever cannot be read raises ``CannotRun``."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @cached_property
    def members(self) -> list[zipfile.ZipInfo]:
        return self._read(checked_members, self.path)

    @cached_property
    def names(self) -> list[str]:
        return [m.filename for m in self.members if not m.is_dir()]

    @cached_property
    def xml(self) -> bytes:
        return self.content(DESCRIPTION)

    def content(self, name: str) -> bytes:
        return self._read(read_member, self.path, name)

    @cached_property
    def root(self) -> Any:
        """The root element of the model description."""
        return self._read(self.parsed, DESCRIPTION)

    def parsed(self, name: str) -> Any:
        parser = etree.XMLParser(resolve_entities=False, no_network=True)
        return etree.fromstring(self.content(name), parser)

    @cached_property
    def description(self) -> FmuDescription:
        return self._read(read_fmu, self.path)

    @cached_property
    def major(self) -> int:
        """2 or 3."""
        version = str(self.root.get("fmiVersion"))
        if version[:2] not in ("2.", "3."):
            raise CannotRun(f"fmiVersion = {version}; FMI 2.0 and 3.0 are known here")
        return int(version[0])

    @cached_property
    def model(self) -> Any:
        """The model description as fmpy reads it."""
        _ = self.xml  # refused where it is too large
        return self._read(read_model_description, str(self.path), False)

    @cached_property
    def problems(self) -> dict[int, list[str]]:
        """What fmpy finds in the description, by item number (2: the rest)."""
        try:
            found = validate_model_description(self.model, True, True)
        except (AttributeError, KeyError, TypeError) as error:
            found = [f"fmpy cannot go through it: {error!r}"]
        by_item: dict[int, list[str]] = {}
        for problem in found:
            number = next((n for n, topic in TOPICS if re.search(topic, problem)), 2)
            by_item.setdefault(number, []).append(problem.partition("\n")[0])
        return by_item

    def interfaces(self) -> list[Any]:
        """Return the elements ModelExchange, CoSimulation, ScheduledExecution."""
        kinds = ("ModelExchange", "CoSimulation", "ScheduledExecution")
        return [e for e in self.root if e.tag in kinds]

    def _read(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        try:
            return function(*args, **kwargs)
        except FmuError as error:
            raise CannotRun(str(error)) from None
        except Exception as error:  # lxml and fmpy raise many kinds for bad documents
            raise CannotRun(f"{self.path}: cannot be read ({error})") from None
