"""FMUs that packages of the tests hold."""

from pathlib import Path

import pytest
from small_packages import PLAIN
from stub import library, stub


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return library(tmp_path_factory.mktemp("stub"))


@pytest.fixture(scope="module")
def plain(compiled: Path) -> Path:
    """An FMU with y = u + k, of no units, that proposes a step of 2 ms."""
    return stub(compiled, compiled.parent / "plain.fmu", PLAIN, step="0.002")
