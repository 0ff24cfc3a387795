"""The command ``feeddrive``: verbs only, each a few lines on the Python API.

Figures go to stdout (with ``--json`` one JSON object and nothing else, of an error
its text), progress and logs to stderr.  Exit code 0 done, 1 a run or an expectation
failed, 2 wrong usage or input, 130 interrupted; never a traceback.
"""

import typer

from orchestrator.cli import (
    check,
    design,
    fmus,
    run,
    runs,
    second_opinion,
    study,
    sweep,
)

app = typer.Typer(
    name="feeddrive",
    help="Co-simulate feed drives and controllers from FMUs at exact mixed rates.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
)
for verb in (
    study.demo,
    study.scenarios,
    fmus.models,
    fmus.build,
    fmus.info,
    check.check,
    run.schedule,
    run.run,
    runs.runs,
    sweep.sweep,
    study.reproduce,
    second_opinion.second_opinion,
    design.design,
):
    app.command()(verb)


def main() -> None:
    """Run the command line."""
    app()
