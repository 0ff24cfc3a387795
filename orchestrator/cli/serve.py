"""The verb ``serve``: the page, for this machine's user alone."""

import os
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.fmus import model_modules
from orchestrator.cli.output import echo, executing, set_up_logs
from orchestrator.cli.run import Verbose


@executing
def serve(
    folder: Annotated[
        Path, typer.Argument(metavar="[FOLDER]", help="the project [the folder here]")
    ] = Path(),
    port: Annotated[
        int, typer.Option(min=0, max=65535, metavar="N", help="[any that is free]")
    ] = 0,
    browser: Annotated[bool, typer.Option(help="open the page in the browser")] = True,
    verbose: Verbose = False,
) -> None:
    """Show a project as a page: compose, run, compare; loopback only, with a token."""
    from orchestrator.errors import ScenarioError

    set_up_logs(verbose)
    try:
        from orchestrator.page.server import serve as go_on
    except ModuleNotFoundError as error:
        missing = str(error.name).partition(".")[0]
        raise ScenarioError(
            f"serve: the page needs {missing}, which is not installed; "
            f"pip install 'feeddrive-cosim[page]'"
        ) from None

    def told(address: str) -> None:
        echo(address)
        if browser:
            webbrowser.open(address)

    if folder.is_dir():
        os.chdir(folder)  # runs are kept there, and its Python is the project's
        folder = Path.cwd()
    go_on(folder, port, told, model_modules())
