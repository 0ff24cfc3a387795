"""The verb ``new``: a project with a plant, a controller, a scenario and a test."""

import shutil
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.output import command, echo, print_json

IGNORED = shutil.ignore_patterns("__pycache__", ".pytest_cache", "runs")


@command
def new(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="is made; may be there and empty")
    ],
    json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Start a project of your own: plant, controller, scenario and tests that run."""
    from orchestrator.errors import ScenarioError
    from orchestrator.supplied import PROJECT

    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ScenarioError(f"{folder}: is there and not empty; name another folder")
    shutil.copytree(PROJECT, folder, ignore=IGNORED, dirs_exist_ok=True)
    (folder / ".gitignore").write_text("runs/\n__pycache__/\n", encoding="utf-8")
    made = sorted(str(f.relative_to(folder)) for f in folder.rglob("*") if f.is_file())
    if json:
        print_json({"folder": str(folder), "files": made})
        return
    echo(f"made {folder}: {', '.join(made)}")
    echo(f"next: cd {folder} && feeddrive run tests/speed_step.toml && pytest")
