"""What a page keeps between drags says what carries its runs out."""

from pathlib import Path

import pytest

from orchestrator.page.kept import Kept

SCENARIO = """
stop = "1/100"
[components]
one = { fmu = "controllers.filters.linear_prefilter", step = 1e-3, start = { x_r = 1 } }
two = { fmu = "controllers.filters.linear_prefilter", step = 1e-3 }
[connections]
"two.x_r" = "one.x_f"
[record]
"two.x_f" = true
[metrics]
moved = { kind = "peak", of = "two.x_f", unit = "m" }
"""
GROUP = '[groups.both]\ncomponents = ["one", "two"]\niterate = true\n'


@pytest.mark.parametrize(("more", "executor"), [("", "fused"), (GROUP, "python")])
def test_the_executor_is_the_one_that_runs(
    more: str, executor: str, tmp_path: Path
) -> None:
    (tmp_path / "both.toml").write_text(SCENARIO + more)
    kept = Kept(tmp_path / "both.toml")
    assert kept.executor == executor
    assert kept.run({}).metrics["moved.peak"].value > 0
    assert kept.too_long is None
