"""From a model to the contents of its FMU archive.

The token is a fingerprint of everything the binary and the description are made
from; FMI 2 and FMI 3 share it, as they share the binary.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from uuid import UUID

from lxml import etree

from fmus.archive import EXTRA
from fmus.audit import refuse_hidden_files, watched
from fmus.checks import check_model, check_traced
from fmus.closure import data_files, is_file, module_name
from fmus.compile import (
    PLATFORMS,
    CompileError,
    compile_library,
    universal_binary,
)
from fmus.description import describe, extra
from fmus.documentation import index_html, license_text
from fmus.evidence import reference_files, response
from fmus.layout import layout
from fmus.load import BuildError, blame, load_model, load_module, sources
from fmus.native_source import ALL, adapter_sources, native_sources
from fmus.own import OWN_PACKAGES
from fmus.preset import Preset, preset
from fmus.python_fmu import (
    external_dependencies,
    gate_sources,
    python_binaries,
    python_resources,
)
from fmus.subject import Fmi, Subject
from fmus.terminals import terminal_files
from fmus.trace import trace
from fmus.units import UnitError

OWN_COPYRIGHT = "the feeddrive authors"
AS_IT_IS = Preset()


def subject_of(module: str, wanted: Preset = AS_IT_IS, clock: bool = True) -> Subject:
    """Load and trace a module's model; collect what its FMU will tell of it.

    Raises:
        BuildError: no such module or model, the preset does not fit it, or it
            cannot be traced.
    """
    name, files = module_name(module), sources(module)
    data = data_files(files)
    refuse_hidden_files(module, files)
    model, loaded = load_model(module), load_module(module)
    model = preset(model, wanted)
    check_model(model)
    try:
        with watched(files, "traced"):
            traced = trace(model)
        places = layout(model, traced.output_like)
    except BuildError:
        raise
    except Exception as error:
        what = f"{model.name} cannot be traced"
        raise BuildError(blame(error, files, what)) from error
    check_traced(model, traced, places)
    ours = not is_file(module) and name.partition(".")[0] in OWN_PACKAGES
    return Subject(
        model,
        traced,
        places,
        name,
        (loaded.__doc__ or "") + wanted.origin,
        data={place: file.read_bytes() for place, file in data.items()},
        author=getattr(loaded, "__author__", OWN_COPYRIGHT if ours else None),
        copyright=getattr(
            loaded, "__copyright__", f"© {OWN_COPYRIGHT}" if ours else None
        ),
        license=getattr(loaded, "__license__", "MIT" if ours else None),
        clock=clock,
    )


def native_contents(
    subject: Subject, fmi: Fmi, platforms: Sequence[str], cache: Path
) -> dict[str, bytes]:
    """Return the files of a native FMU by archive name.

    Raises:
        BuildError: a value or unit of the model is refused, or C does not compile.
    """
    model, traced, places = subject.model, subject.traced, subject.layout
    adapters = adapter_sources()
    parts = (model, traced, places, model.name)
    written = (subject.clock, subject.equations)
    untold = native_sources(*parts, "", *written) | adapters
    subject = replace(subject, sources=(ALL,))
    described = [_described(subject, version, "") for version in (2, 3)]
    resources = dict(subject.resources)
    files = {n: text.encode() for n, text in untold.items()} | resources
    token = _token(described, files)
    generated = native_sources(*parts, token, *written)
    contents = _common(subject, fmi, token) | resources
    for name, text in (generated | adapters).items():
        contents[f"sources/{name}"] = text.encode()
    contents |= {f"sources/{place}": file for place, file in subject.data.items()}
    if fmi == 3:
        contents["sources/buildDescription.xml"] = _build_description(subject)
    return contents | binaries(model.name, generated, fmi, platforms, cache)


def python_contents(
    subject: Subject, module: str, platforms: Sequence[str], cache: Path
) -> dict[str, bytes]:
    """Return the files of a Python FMU (FMI 2) by archive name.

    Raises:
        BuildError: a value or unit of the model is refused, or C does not compile.
    """
    resources = python_resources(module, subject.model)
    gate = {name: text.encode() for name, text in gate_sources().items()}
    token = _token([_described(subject, 2, "")], resources | gate)
    contents = _common(subject, 2, token) | resources
    try:
        contents |= python_binaries(subject.model.name, token, platforms, cache)
    except CompileError as error:
        raise BuildError(str(error)) from error
    contents["documentation/externalDependencies.txt"] = external_dependencies()
    return contents


def _described(subject: Subject, fmi: Fmi, token: str) -> bytes:
    try:
        return describe(subject, fmi, token)
    except UnitError as error:
        raise BuildError(f"{subject.model.name}: {error}") from error
    except ValueError as error:
        raise BuildError(str(error)) from error


def _token(described: Sequence[bytes], files: Mapping[str, bytes]) -> str:
    whole = sha256(b"".join(described))
    for name, content in sorted(files.items()):
        whole.update(f"{name}\0{len(content)}\0".encode() + content)
    return f"{{{UUID(bytes=whole.digest()[:16])}}}"


def _common(subject: Subject, fmi: Fmi, token: str) -> dict[str, bytes]:
    license_file = "license.txt" if fmi == 2 else "licenses/license.txt"
    found = response(subject)
    files = terminal_files(subject, fmi) | (reference_files(found) if found else {})
    return files | {
        "modelDescription.xml": _described(subject, fmi, token),
        EXTRA: extra(subject),
        "documentation/index.html": index_html(subject, found),
        f"documentation/{license_file}": license_text(),
    }


def binaries(
    identifier: str,
    generated: Mapping[str, str],
    fmi: Fmi,
    platforms: Sequence[str],
    cache: Path,
    adapters: Mapping[str, str] | None = None,
    libraries: Sequence[str] = (),
) -> dict[str, bytes]:
    """Compile for every platform; FMI 2 has one folder for both kinds of Mac.

    ``adapters`` are ours of today by default; ``libraries`` are of the system.

    Raises:
        BuildError: C does not compile.
    """
    slices: dict[str, dict[str, bytes]] = {}
    for name in platforms:
        platform = PLATFORMS[name]
        try:
            library = compile_library(
                identifier, generated, name, cache, adapters, libraries
            )
        except CompileError as error:
            raise BuildError(str(error)) from error
        folder = platform.fmi2_folder if fmi == 2 else platform.fmi3_folder
        place = f"binaries/{folder}/{identifier}{platform.suffix}"
        slices.setdefault(place, {})[name] = library.read_bytes()
    return {
        place: universal_binary(parts) if len(parts) > 1 else next(iter(parts.values()))
        for place, parts in slices.items()
    }


def _build_description(subject: Subject) -> bytes:
    root = etree.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = etree.SubElement(
        root, "BuildConfiguration", modelIdentifier=subject.model.name
    )
    files = etree.SubElement(configuration, "SourceFileSet", language="C99")
    for name in subject.sources:
        etree.SubElement(files, "SourceFile", name=name)
    document: bytes = etree.tostring(
        root, xml_declaration=True, encoding="UTF-8", pretty_print=True
    )
    return document
