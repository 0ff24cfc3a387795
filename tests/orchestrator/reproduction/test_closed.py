"""What the second edition closed: pairs of rows, each with one published figure."""

from pathlib import Path

import pytest

from orchestrator.errors import ScenarioError
from orchestrator.reproduction.closed import closed, read_closed, rows_of
from orchestrator.reproduction.reproduce import reproduce
from orchestrator.scenario.reading import find_study, studies

ROWS = """
[[figure]]
id = "before"
where = "3"
published = 2.0
unit = "s"
class = "derived"
why = "crude"
formula = "3.0"

[[figure]]
id = "after"
where = "3"
published = 2.0
unit = "s"
class = "calibrated"
formula = "2.25"

[[figure]]
id = "other"
where = "3"
published = 5.0
unit = "m"
class = "calibrated"
why = "crude"
formula = "2.25"
"""
CLOSED = """
[[difference]]
what = "the time"
first = ["before"]
second = ["after"]
free = "one"
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    (tmp_path / "reference.toml").write_text(ROWS)
    (tmp_path / "closed.toml").write_text(CLOSED)
    return tmp_path


def test_a_difference_shows_the_published_figure_and_both_editions(study: Path) -> None:
    differences = read_closed(study)
    assert rows_of(differences) == ("before", "after")
    done = reproduce(study, rows_of(differences), folder=study / "run")
    assert [figure.spec.id for figure in done.figures] == ["before", "after"]
    (found,) = closed(differences, {f.spec.id: f for f in done.figures})
    assert (found.published, found.first, found.second) == ("2", "3", "2.25")
    assert (found.unit, found.free) == ("s", "one")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('["after"]', '["aftr"]'), "no row 'aftr'"),
        (('["after"]', '["other"]'), "not the same published figure"),
        (('["after"]', '["after", "other"]'), "as many rows"),
        (("free", "fre"), "fre"),
    ],
)
def test_what_is_written_wrongly_is_named(
    study: Path, change: tuple[str, str], said: str
) -> None:
    (study / "closed.toml").write_text(CLOSED.replace(*change))
    with pytest.raises(ScenarioError, match=said):
        read_closed(study)


def test_the_differences_of_the_studies_name_rows_that_are_there() -> None:
    assert not read_closed(find_study("serial_lpv"))
    assert any(read_closed(study) for study in studies())
