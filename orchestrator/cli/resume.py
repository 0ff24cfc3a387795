"""The verb ``resume``: going on with a run that was killed or interrupted."""

from typing import Annotated

import typer

from orchestrator.cli.origin import folder_of
from orchestrator.cli.output import executing, print_json, set_up_logs, waiting
from orchestrator.cli.run import Json, Verbose, conclude, print_run


@executing
def resume(
    run: Annotated[
        str,
        typer.Argument(metavar="RUN", help="its folder, its name or number in runs/"),
    ],
    json: Json = False,
    verbose: Verbose = False,
) -> None:
    """Go on with a run from its latest checkpoint, which `run --checkpoint` wrote."""
    from orchestrator.session import resume as go_on

    set_up_logs(verbose)
    folder = folder_of(run)
    with waiting(f"resuming {folder}"):
        done, begun = go_on(folder)
    if json:
        print_json(done.summary())
    else:
        print_run(done)
    conclude(done, changed=bool(begun.changed))
