"""The command ``feeddrive``: verbs only, each a few lines on the Python API.

Figures go to stdout (with ``--json`` one JSON object and nothing else, of an error
its text), progress and logs to stderr.  Exit code 0 done, 1 a run or an expectation
failed, 2 wrong usage or input, 130 interrupted; never a traceback.
"""

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli import (
    build,
    check,
    compare,
    design,
    doctor,
    export,
    figure,
    fit,
    fmus,
    importing,
    new,
    response,
    resume,
    run,
    runs,
    second_opinion,
    serve,
    shown,
    study,
    sweep,
    tune,
    verify,
)

app = typer.Typer(
    name="feeddrive",
    no_args_is_help=True,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"feeddrive {version('feeddrive-cosim')}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_version, is_eager=True, help="print the version"
        ),
    ] = False,
) -> None:
    """Co-simulate feed drives and controllers from FMUs at exact mixed rates."""


for verb in (
    study.demo,
    new.new,
    study.scenarios,
    fmus.models,
    build.build,
    fmus.info,
    check.check,
    verify.verify,
    shown.wiring,
    shown.schedule,
    run.run,
    resume.resume,
    runs.runs,
    compare.compare,
    compare.plot,
    sweep.sweep,
    response.response,
    tune.tune,
    fit.fit,
    export.export,
    study.reproduce,
    figure.figure,
    second_opinion.second_opinion,
    serve.serve,
    design.design,
    doctor.doctor,
):
    app.command()(verb)
app.command("import")(importing.import_)


def main() -> None:
    """Run the command line.

    NumPy's matrices are small here: threads for each cost more than they give, and
    processes share the cores already.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    _open_what_is_closed()
    app(prog_name="feeddrive")


def _open_what_is_closed() -> None:
    """Give standard streams that the caller has closed a place to go to."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest that is free
    if sys.stdout is None:
        sys.stdout = Path(os.devnull).open("w")  # noqa: SIM115 - until the end
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w")  # noqa: SIM115
