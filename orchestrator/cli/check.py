"""The verb ``check``: what is wrong with an FMU."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.output import command, print_json, print_table, waiting

if TYPE_CHECKING:
    from orchestrator.checks import Report


@command
def check(
    fmu: Annotated[str, typer.Argument(metavar="FMU", help="an .fmu file or a module")],
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
    json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Check an FMU against the standard; each trial runs in its own process."""
    import fmus.build
    from orchestrator.checks import check_fmu

    path = Path(fmu) if fmu.endswith(".fmu") else fmus.build.build(fmu)
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


def print_report(report: "Report") -> None:
    """Print a line per item, then every finding with its clause and remedy."""
    rows = [
        [
            f"{o.item.number} {o.item.part}",
            o.item.title,
            o.verdict,
            o.reason if o.verdict != "finding" else f"{len(o.findings)}, see below",
        ]
        if not o.seen or o.reason or o.findings
        else [f"{o.item.number} {o.item.part}", o.item.title, o.verdict, o.seen[-1]]
        for o in report.outcomes
    ]
    print_table(["item", "what", "verdict", "seen"], rows, str(report.fmu))
    for outcome in report.outcomes:
        for finding in outcome.findings:
            label = f"{outcome.item.number} {outcome.item.part}, {finding.severity}"
            typer.echo(f"{label}: {finding.text}")
            typer.echo(f"    {outcome.item.clause}")
            typer.echo(f"    remedy: {finding.mend or outcome.item.mend}")
    counts = (f"{n} {verdict}" for verdict, n in report.counts.items() if n)
    typer.echo(f"{report.fmu.name}: {', '.join(counts)}")
