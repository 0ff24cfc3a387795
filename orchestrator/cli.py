"""The command ``feeddrive``: verbs only, each a few lines on the Python API.

Figures go to stdout (with ``--json`` one JSON object and nothing else), progress
and logs to stderr.  Exit code 0 done, 1 a run or an expectation failed, 2 wrong
usage or input, 130 interrupted; never a traceback.
"""

import typer

from orchestrator import cli_check, cli_fmus, cli_run, cli_second_opinion, cli_study

app = typer.Typer(
    name="feeddrive",
    help="Co-simulate feed drives and controllers from FMUs at exact mixed rates.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
)
for verb in (
    cli_study.demo,
    cli_fmus.models,
    cli_fmus.build,
    cli_fmus.info,
    cli_check.check,
    cli_run.schedule,
    cli_run.run,
    cli_study.reproduce,
    cli_second_opinion.second_opinion,
):
    app.command()(verb)


def main() -> None:
    """Run the command line."""
    app()
