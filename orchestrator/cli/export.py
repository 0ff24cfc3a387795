"""The verb ``export``: a run in a file that other tools read."""

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.completion import run_names
from orchestrator.cli.output import command, print_json


@command
def export(
    run: Annotated[
        str,
        typer.Argument(
            metavar="RUN",
            help="a folder, or a name that `runs` lists",
            autocompletion=run_names,
        ),
    ],
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="FILE", help="x.csv, x.mat or x.h5"),
    ],
    at: Annotated[
        str | None,
        typer.Option("--at", metavar="RATE", help='only rows of one rate, "1 kHz"'),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Write the rows of a run as CSV, MAT (as Dymola does) or HDF5, by the suffix."""
    from orchestrator.errors import ScenarioError
    from orchestrator.exchange.tables import export as write
    from orchestrator.quantities.quantity import parse_period

    try:
        period = None if at is None else parse_period(at)
    except ValueError as error:
        raise ScenarioError(f"--at: {error}") from None
    written = write(_folder(run), output, period)
    if json:
        print_json({"file": str(written), "bytes": written.stat().st_size})
    else:
        typer.echo(f"written to {written}: {written.stat().st_size:,} bytes")


def _folder(name: str) -> Path:
    """Return the folder of a run given by path, or by its name in runs/."""
    from orchestrator.history.folder import RUNS
    from orchestrator.history.listing import entries, find

    folder = Path(name)
    if (folder / "result").is_dir():
        return folder
    known = entries(RUNS)
    inside = str(folder).removeprefix(f"{RUNS}/")
    return find(inside, known).folder
