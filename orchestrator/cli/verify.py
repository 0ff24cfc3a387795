"""The verb ``verify``: whether an FMU of ours is what its sources make."""

from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.output import command, echo, print_json, print_table, waiting


@command
def verify(
    fmu: Annotated[Path, typer.Argument(metavar="FMU", help="an .fmu file of ours")],
    json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Build an FMU of ours anew from its sources and compare it bit for bit."""
    from orchestrator.checks.rebuilt import OTHER, compared

    with waiting(f"building {fmu.name} anew"):
        files = compared(fmu)
    verdicts = Counter(file.verdict for file in files)
    if json:
        print_json({"files": [asdict(file) for file in files], **verdicts})
    else:
        rows = [[file.file, file.verdict, file.origin] for file in files]
        print_table(["file", "verdict", "compared with what comes from"], rows)
        told = ", ".join(f"{n} {verdict}" for verdict, n in verdicts.items())
        echo(f"{fmu.name}: {told}")
    if verdicts[OTHER]:
        raise typer.Exit(1)
