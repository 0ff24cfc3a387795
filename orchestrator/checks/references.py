"""What the layered standard FMI-LS-REF says of files in an FMU.

Drafts read: fmi-ls-ref 1.0.0-alpha.1 in its repository's main branch (2025; no
release is normative yet), with related files and their roles; the experiments
format ma-hs-experiments it refers to (2026, beta), both with the times at
``Experiment`` as its text has them and at ``TransientSimulation`` as its schema;
and the first draft of 2023, with ``Experiment`` in the manifest itself.  The
Reference FMUs use role ``result`` for the results of the default experiment.
"""

import posixpath
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote

from orchestrator.checks.archive import Archive

NAME = "org.fmi-standard.fmi-ls-ref"
MANIFEST = f"extra/{NAME}/fmi-ls-manifest.xml"
CSV = "text/csv"
ROLES = re.compile(
    r"document|requirement|specification|model|parameter|system|testcase"
    r"|experiment(/(smoke-test|validation|uncertainty-analysis))?|result|method"
    r"|rationale|report|request|delivery|configuration|signature"
    r"|serialized-state(/.*)?|meta-data|other"
)
FILES = ("Parameters", "Stimuli", "References")


@dataclass(frozen=True)
class File:
    """A file that is referred to; ``name`` is its place in the archive.

    It is None for a URI that leads elsewhere.
    """

    name: str | None
    source: str
    type: str


@dataclass(frozen=True)
class Related:
    """A related file with its role and the element that names it."""

    file: File
    role: str
    element: Any


@dataclass(frozen=True)
class Experiment:
    """An experiment with the results it should have; times in s, None: not given.

    ``promised`` is false where it is not said which experiment had the results.
    """

    name: str
    settings: Any
    parameters: File | None
    stimuli: File | None
    references: File
    promised: bool = True

    def number(self, key: str) -> float | None:
        """Return startTime, stopTime, stepSize or tolerance."""
        if self.settings is None:
            return None
        inner = self.settings.find("TransientSimulation")
        for element in (self.settings, inner):
            if element is not None and element.get(key) is not None:
                return float(element.get(key))
        return None


def related_files(fmu: Archive) -> list[Related]:
    """Return the related files of the manifest, none where there is none."""
    if MANIFEST not in fmu.names:
        return []
    return [
        Related(_file(e, MANIFEST, ""), e.get("role") or "", e)
        for e in fmu.parsed(MANIFEST).iter("Related")
    ]


def experiment_files(fmu: Archive) -> list[tuple[str, File]]:
    """Return what the experiments need, each with the name of its experiment."""
    return [
        (experiment.get("name") or "", _file(experiment.find(tag), place, CSV))
        for place, experiment in _elements(fmu)
        for tag in FILES
        if experiment.find(tag) is not None
    ]


def experiments(fmu: Archive) -> list[Experiment]:
    """Return the transient experiments that come with results."""
    found = [
        Experiment(experiment.get("name") or "", experiment, *files)
        for place, experiment in _elements(fmu)
        for files in [_files(experiment, place)]
        if files[2] is not None and _is_transient(experiment)
    ]
    known = {experiment.references.name for experiment in found}
    for related in related_files(fmu):
        file = related.file
        if related.role == "result" and file.type == CSV and file.name not in known:
            name = f"default experiment ({file.source})"
            found.append(Experiment(name, None, None, None, file, promised=False))
    return found


def _elements(fmu: Archive) -> Iterator[tuple[str, Any]]:
    """Give every element Experiment with the place of its document."""
    places = [MANIFEST] if MANIFEST in fmu.names else []
    places += [
        related.file.name
        for related in related_files(fmu)
        if related.role.split("/")[0] == "experiment"
        and related.file.name in fmu.names
        and re.search(r"\.(exp|xml)$", related.file.name or "")
    ]
    for place in places:
        for experiment in fmu.parsed(place).iter("Experiment"):
            yield place, experiment


def _files(experiment: Any, place: str) -> tuple[Any, Any, Any]:
    elements = (experiment.find(tag) for tag in FILES)
    found = [None if e is None else _file(e, place, CSV) for e in elements]
    return found[0], found[1], found[2]


def _is_transient(experiment: Any) -> bool:
    """Tell whether there is no other analysis before the files."""
    known = (*FILES, "TransientSimulation", "Annotations")
    return all(child.tag in known for child in experiment if isinstance(child.tag, str))


def _file(element: Any, place: str, usual: str) -> File:
    source = element.get("source") or ""
    name = None
    if source and not re.match(r"/|[A-Za-z][\w+.-]*:", source):
        folder = posixpath.dirname(place)
        name = posixpath.normpath(posixpath.join(folder, unquote(source)))
    return File(name, source, element.get("type") or usual)
