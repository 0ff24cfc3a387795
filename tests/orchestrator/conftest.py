"""Running a system in a temporary folder."""

from collections.abc import Callable
from pathlib import Path

import pytest

from orchestrator.master.simulate import simulate
from orchestrator.result import Result
from orchestrator.system import System


@pytest.fixture
def run(tmp_path: Path) -> Callable[[System], Result]:
    """Run a system into a folder of this test."""
    return lambda given: simulate(given, tmp_path)
