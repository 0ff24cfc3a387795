"""Options and fixtures shared by all tests.

Matrices are small here: a thread of BLAS per core costs a loaded machine three times
the CPU of one.  Workers take the setting over before they import NumPy.
"""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy
import hypothesis
import pytest
from callbacks import collecting
from effort import EFFORT
from fmpy import read_model_description
from fmpy.fmi2 import FMU2Slave
from tools import needed

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
hypothesis.settings.register_profile("untimed", deadline=None)
hypothesis.settings.load_profile("untimed")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--every-form",
        action="store_true",
        help="test every FMU form (Python, model exchange, platforms) of every model",
    )
    parser.addoption(
        "--hostile",
        action="store_true",
        help="run all of tests/hostile, with draws that change with the commit",
    )
    parser.addoption(
        "--every-failure",
        action="store_true",
        help="with --hostile: let every call to the system fail, not those drawn",
    )
    parser.addoption(
        "--fuzz-seconds",
        type=float,
        default=60.0,
        metavar="S",
        help="with --hostile: how long every reader is fuzzed (60)",
    )
    parser.addoption(
        "--minutes",
        type=float,
        metavar="N",
        help="with --hostile: in an order that changes with the commit; what would"
        " begin later than this is left out and counted",
    )


def pytest_configure(config: pytest.Config) -> None:
    EFFORT.every = config.getoption("--every-form")


@pytest.fixture(scope="session", autouse=True)
def fmu_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """One fresh cache of built FMUs for the session, shared by all workers."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    cache = shared / "feeddrive-cache"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FEEDDRIVE_CACHE", str(cache))
        yield cache


@pytest.fixture(scope="session")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Headless Chromium, started once for all tests of a worker."""
    from browsed import chromium

    needed("chromium", "chromedriver")
    with chromium(tmp_path_factory.mktemp("chromium")) as started:
        yield started


@pytest.fixture
def slave(tmp_path):
    """Instantiate FMUs in this process; free them at the end."""
    opened = []

    def open_fmu(fmu, name="instance"):
        folder = tmp_path / f"unpacked {len(opened)}"
        fmpy.extract(str(fmu), str(folder))
        description = read_model_description(str(folder))
        instance = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        instance.messages = messages = []
        instance.instantiate(callbacks=collecting(messages), loggingOn=True)
        instance.references = {
            v.name: v.valueReference for v in description.modelVariables
        }
        opened.append(instance)
        return instance

    yield open_fmu
    for instance in opened:
        instance.freeInstance()
