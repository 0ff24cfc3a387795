"""The verb ``import``, and what ``check`` prints of a package."""

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.output import echo, executing, print_json
from orchestrator.cli.run import Sets, Ssv, Variant


@executing
def import_(
    system: Annotated[
        Path, typer.Argument(metavar="SYSTEM", help="an .ssp, an .ssd or a folder")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FOLDER", help="what is made")
    ],
    variant: Variant = None,
    ssv: Ssv = [],  # noqa: B006 - Typer copies it
    sets: Sets = [],  # noqa: B006 - Typer copies it
    json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Make a scenario of a system structure (SSP), beside its FMUs."""
    from fmus.allowed import trusts_all
    from orchestrator.exchange.ssp.beside import write_beside
    from orchestrator.exchange.ssp.package import sources_anywhere

    with sources_anywhere(trusts_all()):
        file = write_beside(system, output, variant, sets, ssv)
    if json:
        print_json({"file": str(file)})
    else:
        echo(f"written to {file}; run it with: feeddrive run {file}")


def check_package(system: Path, variant: str | None, *, json: bool) -> None:
    """Print what is wrong with a package: schemas, and what they cannot say."""
    from fmus.allowed import trusts_all
    from orchestrator.exchange.ssp.load import read_package, schema_faults
    from orchestrator.exchange.ssp.package import sources_anywhere

    with sources_anywhere(trusts_all()):
        tables = read_package(system, variant)
    of_schema = schema_faults(system, variant)
    if json:
        print_json(
            {
                "file": str(system),
                "version": tables.structure.version,
                "schema": of_schema,
                "faults": tables.faults,
                "notes": tables.notes,
                "lacking": dict(tables.lacking),
                "names": {"/".join(p): name for p, name in tables.names.items()},
            }
        )
    else:
        echo(
            f"{system}: SSP {tables.structure.version}, "
            f"{len(tables.flat.parts)} components, {len(tables.flat.fed)} connections"
        )
        for label, found in (
            ("schema", of_schema),
            ("cannot be run", tables.faults),
            ("note", tables.notes),
        ):
            for one in found:
                echo(f"{label}: {one}")
        for key, proposal in tables.lacking.items():
            echo(f"nobody says {key}{': ' if proposal else ''}{proposal}")
    if of_schema or tables.faults:
        raise typer.Exit(1)
