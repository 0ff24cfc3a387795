"""The n-th call to the system fails: no wrong result with 0, and the next run is clean.

60 failures are drawn by the commit; ``--every-failure`` makes every n fail.
"""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from draws import drawn

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or shutil.which("gcc") is None,
    reason="what makes calls fail is compiled by gcc and preloaded on Linux",
)
HERE = Path(__file__).parent
MODEL = HERE.parent / "fmus" / "small_models" / "pi.py"
DRAWN = 60
SCENARIO = """
stop = "1/20"
[components.pi]
fmu = "pi.py"
start = { r = 0.1 }
[record]
"pi.u" = true
[metrics]
u = { kind = "max", of = "pi.u" }
"""
VERBS = {
    "build": ["build", "pi.py", "-o", "out"],
    "run": ["run", "s.toml", "-o", "run", "--json"],
    "sweep": ["sweep", "s.toml", "--vary", "pi.K_p=0.5,0.6", "-o", "swept", "--json"],
}
CASES = [(verb, number) for number in range(DRAWN // 3) for verb in VERBS]


@dataclass(frozen=True)
class Place:
    """A project and its cache, and what preloads the failing calls."""

    folder: Path
    library: Path

    def copy(self, folder: Path) -> "Place":
        shutil.copytree(self.folder, folder)
        return Place(folder, self.library)

    def command(self, verb: str, at: int | None) -> "subprocess.CompletedProcess[str]":
        """Carry out a verb in which the ``at``-th call fails, none if 0 or None."""
        project, cache = self.folder / "project", self.folder / "cache"
        environment = {**os.environ, "FEEDDRIVE_CACHE": str(cache)}
        if at is not None:
            self.count.write_bytes(bytes(8))
            environment |= {
                "LD_PRELOAD": str(self.library),
                "FAILING_BELOW": f"{project}:{cache}",
                "FAILING_COUNT": str(self.count),
                "FAILING_AT": str(at),
                "FAILING_TOLD": str(self.folder / "told"),
            }
        return subprocess.run(
            [sys.executable, "-m", "orchestrator", *VERBS[verb]],
            cwd=project,
            env=environment,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )

    @property
    def count(self) -> Path:
        return self.folder / "count"

    def counted(self) -> int:
        return int.from_bytes(self.count.read_bytes(), sys.byteorder)

    def outcome(self, verb: str, printed: str) -> Any:
        """Return what has to be the same, however often it is made."""
        if verb == "build":
            return (self.folder / "project/out/SmallPI.fmu").read_bytes()
        if verb == "run":
            return json.loads(printed)["metrics"]
        figures = pq.read_table(self.folder / "project/swept/figures.parquet")
        return figures.select(["u.max"]).to_pylist()

    def clear(self) -> None:
        for name in ("out", "run", "swept"):
            shutil.rmtree(self.folder / "project" / name, ignore_errors=True)


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Place:
    """A project whose cache has all libraries, but no FMU."""
    folder = tmp_path_factory.mktemp("failing")
    library = folder / "failing.so"
    command = ["gcc", "-O1", "-shared", "-fPIC", str(HERE / "failing.c"), "-ldl", "-o"]
    subprocess.run([*command, str(library)], check=True)
    place = Place(folder / "warm", library)
    (place.folder / "project").mkdir(parents=True)
    shutil.copyfile(MODEL, place.folder / "project" / "pi.py")
    (place.folder / "project" / "pyproject.toml").touch()
    (place.folder / "project" / "s.toml").write_text(SCENARIO)
    for verb in ("run", "sweep"):
        assert place.command(verb, None).returncode == 0
    place.clear()
    shutil.rmtree(place.folder / "cache" / "fmus")
    return place


@pytest.fixture(scope="module")
def known(
    warm: Place, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], tuple[int, Any]]:
    """Return how many calls a verb makes, and what comes out of it."""
    found: dict[str, tuple[int, Any]] = {}

    def of(verb: str) -> tuple[int, Any]:
        if verb not in found:
            place = warm.copy(tmp_path_factory.mktemp("counted") / verb)
            done = place.command(verb, 0)
            assert done.returncode == 0, done.stderr
            found[verb] = place.counted(), place.outcome(verb, done.stdout)
        return found[verb]

    return of


def fail(warm: Place, folder: Path, verb: str, at: int, right: Any) -> str:
    """Let one call fail; return the exit code and the call that failed."""
    place = warm.copy(folder)
    done = place.command(verb, at)
    told = place.folder / "told"
    call = told.read_text().partition(" ")[0] if told.is_file() else "none"
    where = f"{verb} with call {at} ({call}): {done.stderr}"
    assert done.returncode in (0, 1, 2), where
    assert "a fault in feeddrive" not in done.stderr, where
    assert "Traceback" not in done.stderr, where
    if done.returncode == 0:
        assert place.outcome(verb, done.stdout) == right, where
    else:
        assert "error: " in done.stderr or "members failed" in done.stderr, where
    place.clear()
    again = place.command(verb, None)
    assert again.returncode == 0, f"after {where}: {again.stderr}"
    assert place.outcome(verb, again.stdout) == right
    shutil.rmtree(place.folder)
    return f"{call} -> {done.returncode}"


@pytest.mark.parametrize(("verb", "number"), CASES)
def test_a_call_that_fails_makes_nothing_wrong(
    verb: str,
    number: int,
    warm: Place,
    known: Callable[[str], tuple[int, Any]],
    tmp_path: Path,
) -> None:
    calls, right = known(verb)
    at = 1 + drawn(f"failure {verb} {number}").randrange(calls)
    fail(warm, tmp_path / "it", verb, at, right)


@pytest.mark.parametrize("verb", VERBS)
def test_every_call_that_fails_makes_nothing_wrong(
    verb: str,
    request: pytest.FixtureRequest,
    warm: Place,
    known: Callable[[str], tuple[int, Any]],
    tmp_path: Path,
) -> None:
    if not request.config.getoption("--every-failure"):
        pytest.skip("--every-failure lets every call fail, not those drawn alone")
    calls, right = known(verb)
    wrong = []
    for at in range(1, calls + 1):
        try:
            fail(warm, tmp_path / "it", verb, at, right)
        except AssertionError as error:
            wrong.append(str(error)[:400])
            shutil.rmtree(tmp_path / "it", ignore_errors=True)
    assert wrong == [], f"{len(wrong)} of {calls}"
