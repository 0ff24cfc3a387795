"""What of the hostile suite runs: all with ``--hostile``, else what is a sample."""

import os
import subprocess
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from draws import drawn, seed
from forker import Forker
from tools import needed

HERE = Path(__file__).parent
BEGUN = "FEEDDRIVE_HOSTILE_BEGUN"  # s; workers take it over
OVER = "the time of the hostile suite is over"


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "sample: part of the plain suite as well")
    os.environ.setdefault(BEGUN, str(time.time()))


def pytest_collection_modifyitems(
    config: pytest.Config, items: list[pytest.Item]
) -> None:
    if config.getoption("--hostile"):
        if config.getoption("--minutes"):
            drawn("order").shuffle(items)
        return
    left_out = {
        item
        for item in items
        if HERE in item.path.parents and item.get_closest_marker("sample") is None
    }
    config.hook.pytest_deselected(items=list(left_out))
    items[:] = [item for item in items if item not in left_out]


def pytest_runtest_setup(item: pytest.Item) -> None:
    minutes = item.config.getoption("--minutes")
    begun = float(os.environ[BEGUN])
    if minutes and HERE in item.path.parents and time.time() > begun + 60 * minutes:
        pytest.skip(OVER)


def pytest_report_header(config: pytest.Config) -> str:
    return f"hostile draws from: {seed()}" if config.getoption("--hostile") else ""


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print what tests have told, such as what came of every call that failed."""
    counted = Counter[str]()
    late = sum(
        OVER in str(r.longrepr) for r in terminalreporter.stats.get("skipped", ())
    )
    if late:
        terminalreporter.write_line(f"{OVER}: {late} tests were left out")
    for reports in terminalreporter.stats.values():
        for report in reports:
            for name, value in getattr(report, "user_properties", ()):
                if name == "told" and report.when == "call":
                    counted[str(value)] += 1
    for told, times in sorted(counted.items()):
        terminalreporter.write_line(told + (f": {times} times" if times > 1 else ""))


@pytest.fixture(scope="session")
def forker(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forker]:
    """What forks commands, whose calls can be made to fail."""
    needed("gcc")
    library = tmp_path_factory.mktemp("failing") / "failing.so"
    command = ["gcc", "-O1", "-shared", "-fPIC", str(HERE / "failing.c"), "-ldl", "-o"]
    subprocess.run([*command, str(library)], check=True)
    with closing(Forker(library)) as started:
        yield started
