"""The verb ``figure``: a figure of a study's source, drawn by its number."""

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.completion import study_names
from orchestrator.cli.output import (
    command,
    echo,
    print_json,
    print_table,
    set_up_logs,
    waiting,
)
from orchestrator.cli.run import Json, Verbose

STUDY = typer.Argument(metavar="STUDY", help="e.g. gantry", autocompletion=study_names)


@command
def figure(
    study: Annotated[str, STUDY],
    number: Annotated[
        str | None,
        typer.Argument(
            metavar="[FIGURE]", help="e.g. fig_3_11; without it they are listed"
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="picture, .png, .svg or .html [FIGURE.png]",
        ),
    ] = None,
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Draw a figure of a study's source as it is laid out there, from our own data."""
    from orchestrator.drawings.registry import read_registry
    from orchestrator.scenario.reading import find_study

    set_up_logs(verbose)
    registry = read_registry(find_study(study))
    if number is None:
        if json:
            print_json(
                {
                    "study": study,
                    "drawn": {n: f.title for n, f in registry.figures.items()},
                    "not_drawn": dict(registry.not_drawn),
                }
            )
            return
        rows = [[n, f.obtained, f.title] for n, f in registry.figures.items()]
        rows += [[n, "", f"not drawn: {why}"] for n, why in registry.not_drawn.items()]
        print_table(["figure", "there", "title"], rows)
        return
    from orchestrator.drawings.page import write_figure

    drawn = registry.figure(number)
    with waiting(f"drawing {number}"):
        file = write_figure(registry, number, output or Path(f"{number}.png"))
    if json:
        told = {"figure": number, "title": drawn.title, "file": str(file)}
        print_json({**told, "why": drawn.why})
        return
    echo(f"{number}: {drawn.title}")
    if drawn.why:
        echo(drawn.why)
    echo(f"picture: {file}")
