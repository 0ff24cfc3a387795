"""What the study of contouring must show."""

from pathlib import Path

import pytest

from orchestrator.reproduction.reproduce import reproduce


@pytest.mark.parametrize("only", ["table_8*", "rose.[lp]*", "space.*"])
def test_figures_are_within_the_tolerances_of_the_study(
    only: str, tmp_path: Path
) -> None:
    figures = reproduce("contouring_lpv", only, processes=1, folder=tmp_path).figures
    assert [f.spec.id for f in figures if f.regression == "FAILED"] == []
    assert figures
