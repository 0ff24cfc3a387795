"""Options and fixtures shared by all tests."""

import os
from collections.abc import Iterator
from pathlib import Path

import hypothesis
import pytest

hypothesis.settings.register_profile("untimed", deadline=None)
hypothesis.settings.load_profile("untimed")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--every-form",
        action="store_true",
        help="test every FMU form (Python, model exchange, platforms) of every model",
    )


@pytest.fixture(scope="session", autouse=True)
def fmu_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """One fresh cache of built FMUs for the session, shared by all workers."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    cache = shared / "feeddrive-cache"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FEEDDRIVE_CACHE", str(cache))
        yield cache
