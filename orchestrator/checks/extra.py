"""Static item about extra/: layered standards, and files that one of them names."""

import hashlib
import re
from collections.abc import Iterator

from orchestrator.checks.archive import Archive
from orchestrator.checks.item import Finding, NotApplicable, Said, advice, static
from orchestrator.checks.references import (
    MANIFEST,
    ROLES,
    Related,
    experiment_files,
    related_files,
)

SPACE = "{http://fmi-standard.org/fmi-ls-manifest}"
DIGEST = "SHA3-256"


@static(
    33,
    "Extra files are labelled, and there",
    "FMI 3.0.2 section 2.5; FMI layered standards 1.0; FMI-LS-REF 1.0.0-alpha.1",
    "put files into extra/<reverse domain>/, name the standard in fmi-ls-manifest.xml, "
    "and write sources relative to the file that names them",
)
def extra_files(fmu: Archive) -> Iterator[Said]:
    inside = [n.split("/") for n in fmu.names if n.startswith("extra/")]
    if not inside:
        raise NotApplicable("it has no extra/")
    for folder in sorted({parts[1] for parts in inside}):
        if not re.fullmatch(r"[\w-]+(\.[\w-]+)+", folder):
            yield Finding(f"extra/{folder} is no reverse domain name")
        manifest = f"extra/{folder}/fmi-ls-manifest.xml"
        if manifest in fmu.names:
            yield from _manifest(fmu, manifest, folder)
        yield f"extra/{folder}"
    for related in related_files(fmu):
        yield from _related(fmu, related)
    for experiment, file in experiment_files(fmu):
        if file.name is not None and file.name not in fmu.names:
            yield Finding(f"experiment {experiment!r}: there is no {file.name}")


def _manifest(fmu: Archive, manifest: str, folder: str) -> Iterator[Said]:
    given = {str(name): text for name, text in fmu.parsed(manifest).attrib.items()}
    for key in ("fmi-ls-name", "fmi-ls-version"):
        if not any(name.endswith(key) for name in given):
            yield Finding(f"{manifest} has no {key}")
        elif SPACE + key not in given:
            yield advice(f"{manifest}: {key} is not in the namespace of manifests")
    if not any(name.endswith("fmi-ls-description") for name in given):
        yield advice(f"{manifest} has no fmi-ls-description")
    told = given.get(f"{SPACE}fmi-ls-name", folder)
    if told != folder:
        yield advice(f"{manifest} is of {told}, but lies in the folder of {folder}")


def _related(fmu: Archive, related: Related) -> Iterator[Said]:
    file, element = related.file, related.element
    if not file.source:
        yield Finding(f"{MANIFEST} line {element.sourceline}: there is no source")
        return
    if not ROLES.fullmatch(related.role):
        yield Finding(f"{file.source}: {related.role!r} is no role of a related file")
    if file.name is None:
        yield f"{file.source} lies elsewhere"
    elif file.name not in fmu.names:
        # The draft lets tools that know nothing of it remove files.
        yield advice(f"{MANIFEST} names {file.name}, which is not there")
    elif checksum := element.get("checksum"):
        kind = element.get("checksumType") or DIGEST
        digest = kind.lower().replace("sha-", "sha").replace("sha3-", "sha3_")
        if digest not in hashlib.algorithms_guaranteed:
            yield Finding(f"{file.source}: checksumType = {kind} is not known")
        elif hashlib.new(digest, fmu.content(file.name)).hexdigest() != (
            checksum.lower()
        ):
            yield Finding(f"{file.source}: it does not have the {kind} that is given")
