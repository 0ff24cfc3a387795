"""The baseline of a scenario: signals that its later runs are to be like.

``expect_like = "baseline/"`` of ``drive.toml`` means ``baseline/drive/`` beside it, or
that folder itself where it is that of a run.  ``result/`` in it holds the tables of the
run that was right.
"""

import shutil
from pathlib import Path

import numpy as np

from fmus.units import UnitError
from orchestrator.errors import ScenarioError
from orchestrator.evaluation.likeness import differences
from orchestrator.evaluation.schema import Likeness
from orchestrator.history.folder import holds_run
from orchestrator.result import Result

TABLES = "result"


def folder_of(file: Path, spec: Likeness) -> Path:
    """Return where the baseline of a scenario's file lies."""
    whole = file.parent / spec.folder
    return whole if (whole / TABLES).is_dir() else whole / file.stem


def update(file: Path, spec: Likeness | None, done: Result) -> None:
    """Make the signals of a run the baseline, in place of another.

    Raises:
        ScenarioError: the baseline is the folder of a run, or a signal that is to be
            compared was not recorded or holds values that are no finite numbers.
    """
    if spec is None:
        return
    place = folder_of(file, spec)
    if holds_run(place):
        raise ScenarioError(
            f"expect_like: {place} is the folder of a run, whose rows are not "
            f"replaced; name a folder of its own for the baseline"
        )
    for name in spec.signals or done:
        if name not in done:
            raise ScenarioError(
                f"expect_like: {name} was not recorded; add it to [record]"
            )
        if not np.isfinite(done[name].values.astype(float)).all():
            raise ScenarioError(
                f"expect_like: {name} holds values that are no finite numbers; "
                f"such a run makes no baseline"
            )
    target = place / TABLES
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    for table in (done.folder / TABLES).glob("*.parquet"):
        shutil.copyfile(table, target / table.name)


def unlike(file: Path, spec: Likeness | None, done: Result) -> list[str]:
    """Return how a run differs from the baseline, a paragraph each."""
    if spec is None:
        return []
    place = folder_of(file, spec)
    if not (place / TABLES).is_dir():
        return [
            f"expect_like: there is no baseline {place}; if this run is right, "
            f"pytest --feeddrive-update makes it the baseline"
        ]
    try:
        found = differences(Result(place), done, spec)
        return [f"not like {place.name}: {difference}" for difference in found]
    except UnitError as error:
        return [f"expect_like: {error}; update the baseline"]
