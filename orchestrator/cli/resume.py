"""The verb ``resume``: going on with a run that was killed or interrupted."""

from pathlib import Path
from typing import Annotated

import typer

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
    from orchestrator.history.folder import BEGUN, RUNS
    from orchestrator.history.listing import entries, find
    from orchestrator.session import resume as go_on

    set_up_logs(verbose)
    folder = Path(run)
    if not (folder / BEGUN).is_file():
        folder = find(run, entries(RUNS)).folder
    with waiting(f"resuming {folder}"):
        done, begun = go_on(folder)
    if json:
        print_json(done.summary())
    else:
        print_run(done)
    conclude(done, changed=bool(begun.changed))
