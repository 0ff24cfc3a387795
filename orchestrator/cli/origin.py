"""Runs as an option names them: a folder, a name or number, a checkpoint of one."""

from pathlib import Path
from typing import TYPE_CHECKING

from orchestrator.cli.rows import time
from orchestrator.errors import ScenarioError

if TYPE_CHECKING:
    from orchestrator.master.warm import Origin


def folder_of(run: str) -> Path:
    """Return the folder of a run: this one, or that of a name or number in ``runs/``.

    Raises:
        ScenarioError: there is none, or several.
    """
    from orchestrator.history.folder import BEGUN, RUNS
    from orchestrator.history.listing import entries, find

    folder = Path(run)
    if (folder / BEGUN).is_file():
        return folder
    return find(run, entries(RUNS)).folder


def origin_of(text: str) -> "Origin":
    """Return the checkpoint that ``--from RUN@S`` names.

    Raises:
        ScenarioError: there is no such run, or it has no checkpoint at that time.
    """
    from orchestrator.master.warm import origin

    run, at, seconds = text.rpartition("@")
    if not (run and at):
        raise ScenarioError(
            f"--from {text}: write RUN@S, a run and the time (s) of its checkpoint, "
            f"such as 3@0.5"
        )
    wanted, folder = time(seconds, "--from"), folder_of(run)
    assert wanted is not None
    return origin(str(folder), folder, wanted)
