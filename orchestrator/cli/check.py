"""The verb ``check``: what is wrong with an FMU."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated
from zipfile import ZipFile, is_zipfile

import typer

from orchestrator.cli.importing import check_package
from orchestrator.cli.output import echo, executing, print_json, print_table, waiting
from orchestrator.cli.run import Variant

if TYPE_CHECKING:
    from orchestrator.checks import Report


@executing
def check(
    fmu: Annotated[
        str,
        typer.Argument(
            metavar="FMU", help="an .fmu file, a module, or a package (SSP)"
        ),
    ],
    only: Annotated[
        list[int] | None,
        typer.Option(
            "--only", metavar="NUMBER", help="carry out this item (repeatable)"
        ),
    ] = None,
    static: Annotated[
        bool, typer.Option("--static", help="read the archive only, run nothing of it")
    ] = False,
    junit: Annotated[
        Path | None, typer.Option("--junit", metavar="FILE", help="write JUnit XML")
    ] = None,
    variant: Variant = None,
    json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Check an FMU against the standard; each trial runs in its own process.

    Of a package (.ssp, .ssd, folder): schemas, and what cannot be run.
    """
    import fmus.build
    from orchestrator.checks import check_fmu
    from orchestrator.exchange.ssp.package import is_package

    if is_package(fmu):
        check_package(Path(fmu), variant, json=json)
        return

    is_path = fmu.endswith(".fmu") or (Path(fmu).is_file() and not fmu.endswith(".py"))
    path = Path(fmu) if is_path else fmus.build.build(fmu)
    _refuse_numbers(only or ())
    _refuse_no_fmu(path)
    with waiting(f"checking {path.name}"):
        report = check_fmu(path, only=only or (), dynamic=not static)
    if junit is not None:
        junit.write_bytes(report.to_junit())
    if json:
        print_json(report.to_json())
    else:
        print_report(report)
    if not report.clean:
        raise typer.Exit(1)


def _refuse_numbers(only: Iterable[int]) -> None:
    from orchestrator.checks.catalogue import catalogue
    from orchestrator.errors import ScenarioError

    numbers = {item.number for item in catalogue()}
    if unknown := sorted(set(only) - numbers):
        raise ScenarioError(
            f"--only {unknown[0]}: there is no such item; there are "
            f"{min(numbers)} to {max(numbers)}"
        )


def _refuse_no_fmu(path: Path) -> None:
    """Refuse a file that is nothing an item could say anything sensible of."""
    from orchestrator.checks.archive import Archive
    from orchestrator.checks.item import CannotRun
    from orchestrator.errors import FmuError
    from orchestrator.fmu.archive import DAMAGE
    from orchestrator.fmu.declared import refuse_other_fmi

    if not path.is_file():
        return  # told when it is opened
    if not is_zipfile(path):
        raise FmuError(f"{path}: is no FMU, which is a zip archive, but {_what(path)}")
    try:
        with ZipFile(path) as archive:
            names = archive.namelist()
    except DAMAGE:
        return  # a finding
    if not any(name.endswith("modelDescription.xml") for name in names):
        held = ", ".join(names[:3]) or "nothing"
        raise FmuError(
            f"{path}: is no FMU but a zip archive without modelDescription.xml; it "
            f"holds {held}{', ...' if len(names) > 3 else ''}"
        )
    try:
        root = Archive(path).root
    except CannotRun:
        return  # a finding
    if root.get("fmiVersion"):
        refuse_other_fmi(path, root)


def _what(path: Path) -> str:
    with path.open("rb") as file:
        head = file.read(40)
    if not head:
        return "an empty file"
    if head.startswith(b"PK"):
        return "the beginning of one: copy or export it again"
    if head.startswith((b"\x7fELF", b"MZ")):
        return "a program or library"
    text = head.decode("utf-8", errors="replace")
    if all(c.isprintable() or c.isspace() for c in text.rstrip("\ufffd")):
        return f"a text that begins with {text.split(chr(10))[0].strip()!r}"
    return f"a binary file that begins with the bytes {head[:4].hex(' ')}"


def print_report(report: "Report") -> None:
    """Print a line per item, then every finding with its clause and remedy."""
    rows = [
        [
            f"{o.item.number} {o.item.part}",
            o.item.title,
            o.verdict,
            "; ".join(
                [f"{len(o.findings)}, see below"] * bool(o.findings)
                + [o.reason] * bool(o.reason)
            ),
        ]
        if not o.seen or o.reason or o.findings
        else [f"{o.item.number} {o.item.part}", o.item.title, o.verdict, o.seen[-1]]
        for o in report.outcomes
    ]
    print_table(["item", "what", "verdict", "seen"], rows, str(report.fmu))
    for outcome in report.outcomes:
        for finding in outcome.findings:
            label = f"{outcome.item.number} {outcome.item.part}, {finding.severity}"
            echo(f"{label}: {finding.text}")
            echo(f"    {report.clause(outcome.item)}")
            echo(f"    remedy: {finding.mend or outcome.item.mend}")
    for note in report.notes:
        echo(f"note: {note}")
    counts = (
        f"{n} findings" if verdict == "finding" and n > 1 else f"{n} {verdict}"
        for verdict, n in report.counts.items()
        if n
    )
    echo(f"{report.fmu.name}: {', '.join(counts)}")
