"""The n-th call to the system fails: no wrong result with 0, and the next run is clean.

60 failures are drawn by the commit; ``--every-failure`` makes every n fail and prints
what came of it.  At another 30 calls power fails: all processes are killed, and files
lose what was not synced.  The commands are forked from a process with all imports done;
for each verb one that is started as users do makes as many calls.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from draws import drawn
from forker import Forker

from orchestrator.result import Result

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="what makes calls fail is preloaded on Linux"
)
MODEL = Path(__file__).parents[1] / "fmus" / "small_models" / "pi.py"
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
    "checkpoint": [
        *("run", "s.toml", "-o", "run", "--json", "--checkpoint", "1/100"),
    ],
    "resume": ["resume", "cut", "--json"],
    "resume run": ["resume", "run", "--json"],
    "from": ["run", "s.toml", "-o", "run", "--json", "--from", "kept@1/50"],
    "kept": [
        *("run", "s.toml", "-o", "kept", "--checkpoint", "1/100"),
        "--keep-checkpoints",
    ],
    "export": ["export", "whole", "-o", "out.csv"],
    "plot": ["plot", "whole", "pi.u", "-o", "out.html"],
}
FAILING = [verb for verb in VERBS if verb not in ("resume run", "kept")]
POWER = 30
CASES = [(verb, n) for n in range(-(-DRAWN // len(FAILING))) for verb in FAILING]
DARK = [
    (verb, number)
    for number in range(POWER // 6)
    for verb in ("build", "run", "sweep", "checkpoint", "resume", "from")
]


@dataclass(frozen=True)
class Place:
    """A project and its cache, and what preloads the failing calls."""

    folder: Path
    library: Path
    forker: Forker | None  # none: verbs are started as users do

    def copy(self, folder: Path) -> "Place":
        shutil.copytree(self.folder, folder)
        return replace(self, folder=folder)

    def command(
        self, verb: str, at: int | None, *, dark: bool = False
    ) -> "subprocess.CompletedProcess[str]":
        """Carry out a verb in which the ``at``-th call fails, none if 0 or None.

        ``dark``: power fails there instead.
        """
        project, cache = self.folder / "project", self.folder / "cache"
        environment = {"FEEDDRIVE_CACHE": str(cache)}
        if at is not None:
            self.count.write_bytes(bytes(8))
            environment |= {
                "LD_PRELOAD": str(self.library),
                "FAILING_BELOW": f"{project}:{cache}",
                "FAILING_COUNT": str(self.count),
                "FAILING_AT": str(at),
                "FAILING_TOLD": str(self.folder / "told"),
            }
        if dark:
            environment["FAILING_POWER"] = str(self.journal)
        if self.forker is not None:
            return self.forker.run(VERBS[verb], project, environment)
        return subprocess.run(
            [sys.executable, "-m", "orchestrator", *VERBS[verb]],
            cwd=project,
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
            start_new_session=True,
        )

    @property
    def journal(self) -> Path:
        return self.folder / "journal"

    def lose(self, names: bool) -> None:
        """Take from all files what was not synced; with ``names`` also new names in
        folders that were not.
        """
        sizes: dict[str, int] = {}
        new: dict[str, str] = {}  # names since their folder was synced: path -> before
        source = ""
        for line in self.journal.read_text().splitlines():
            what, size, path = line.split(" ", 2)
            if what == "t":
                sizes[path] = 0
            elif what == "w":
                sizes.setdefault(path, int(size))
            elif what == "s":
                sizes[path] = int(size)
            elif what == "r":
                source = path
            elif what == "d":
                new = {p: s for p, s in new.items() if str(Path(p).parent) != path}
            elif what == "n":
                for known in [k for k in sizes if f"{k}/".startswith(f"{source}/")]:
                    sizes[path + known.removeprefix(source)] = sizes.pop(known)
                new[path] = source
        for path, before in reversed(new.items()) if names else ():
            if Path(path).exists() and not Path(before).exists():
                with suppress(OSError):
                    Path(path).rename(before)
        for path, size in sizes.items():
            if Path(path).is_file() and Path(path).stat().st_size > size:
                os.truncate(path, size)

    @property
    def count(self) -> Path:
        return self.folder / "count"

    def counted(self) -> int:
        return int.from_bytes(self.count.read_bytes(), sys.byteorder)

    def outcome(self, verb: str, printed: str) -> Any:
        """Return what has to be the same, however often it is made."""
        if verb == "build":
            return (self.folder / "project/out/SmallPI.fmu").read_bytes()
        if verb in ("export", "plot"):
            name = "out.csv" if verb == "export" else "out.html"
            return (self.folder / "project" / name).read_bytes()
        if verb in ("run", "checkpoint", "resume", "from"):
            folder = "cut" if verb == "resume" else "run"
            found = Result(self.folder / "project" / folder)["pi.u"].values
            return json.loads(printed)["metrics"], found.tobytes()
        figures = pq.read_table(self.folder / "project/swept/figures.parquet")
        return figures.select(["u.max"]).to_pylist()

    def clear(self) -> None:
        for name in ("out", "run", "swept"):
            shutil.rmtree(self.folder / "project" / name, ignore_errors=True)
        for file in ("out.csv", "out.html"):
            (self.folder / "project" / file).unlink(missing_ok=True)


@pytest.fixture(scope="session")
def warm(forker: Forker, tmp_path_factory: pytest.TempPathFactory) -> Place:
    """A project whose cache has all libraries, but no FMU."""
    place = Place(tmp_path_factory.mktemp("failing") / "warm", forker.library, forker)
    (place.folder / "project").mkdir(parents=True)
    shutil.copyfile(MODEL, place.folder / "project" / "pi.py")
    (place.folder / "project" / "pyproject.toml").touch()
    (place.folder / "project" / "s.toml").write_text(SCENARIO)
    for verb in ("run", "sweep"):
        done = place.command(verb, None)
        assert done.returncode == 0, done.stderr
    (place.folder / "project" / "run").rename(place.folder / "project" / "whole")
    place.clear()
    done = place.command("kept", None)
    assert done.returncode == 0, done.stderr
    cut_off(place)
    shutil.rmtree(place.folder / "cache" / "fmus")
    return place


def cut_off(place: Place) -> None:
    """Leave a run that was killed behind its third checkpoint."""
    code = (
        "from orchestrator.master.checkpoint import Keeper; import os; write ="
        " Keeper.write; n = iter(range(9))\n"
        "def cut(*a): write(*a); next(n) < 2 or os._exit(9)\n"
        "Keeper.write = cut; from orchestrator.cli import main; main()"
    )
    words = ["run", "s.toml", "-o", "cut", "--checkpoint", "1/100"]
    environment = {**os.environ, "FEEDDRIVE_CACHE": str(place.folder / "cache")}
    done = subprocess.run(
        [sys.executable, "-c", code, *words],
        cwd=place.folder / "project",
        env=environment,
        check=False,
    )
    assert done.returncode == 9


def counted(place: Place, verb: str) -> tuple[int, Any]:
    """Return how many calls a verb makes here, and what comes out of it."""
    done = place.command(verb, 0)
    assert done.returncode == 0, done.stderr
    return place.counted(), place.outcome(verb, done.stdout)


@pytest.fixture(scope="session")
def known(
    warm: Place, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], tuple[int, Any]]:
    """Return how many calls a verb makes, and what comes out of it."""
    found: dict[str, tuple[int, Any]] = {}

    def of(verb: str) -> tuple[int, Any]:
        if verb not in found:
            folder = tmp_path_factory.mktemp("counted")
            forked = counted(warm.copy(folder / "forked"), verb)
            found[verb] = counted(replace(warm.copy(folder / "it"), forker=None), verb)
            assert forked[1] == found[verb][1]
            # members of a sweep go to whichever process is free, which loads for itself
            other = abs(forked[0] - found[verb][0])
            assert other <= (0.05 * forked[0] if verb == "sweep" else 0)
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
    if verb != "resume" or done.returncode:
        again = place.command(verb, None)
        assert again.returncode == 0, f"after {where}: {again.stderr}"
        assert place.outcome(verb, again.stdout) == right, where
    shutil.rmtree(place.folder)
    return f"{call} -> {done.returncode}"


@pytest.mark.parametrize(("verb", "number"), CASES)
def test_a_call_that_fails_makes_nothing_wrong(
    verb: str,
    number: int,
    record_property: Callable[[str, object], None],
    warm: Place,
    known: Callable[[str], tuple[int, Any]],
    tmp_path: Path,
) -> None:
    calls, right = known(verb)
    at = 1 + drawn(f"failure {verb} {number}").randrange(calls)
    what = fail(warm, tmp_path / "it", verb, at, right)
    record_property("told", f"{verb}, one of {calls} calls fails: {what}")


@pytest.mark.parametrize("verb", FAILING)
def test_every_call_that_fails_makes_nothing_wrong(
    verb: str,
    request: pytest.FixtureRequest,
    record_property: Callable[[str, object], None],
    warm: Place,
    known: Callable[[str], tuple[int, Any]],
    tmp_path: Path,
) -> None:
    if not request.config.getoption("--every-failure"):
        pytest.skip("--every-failure lets every call fail, not those drawn alone")
    calls, right = known(verb)
    wrong, came = [], Counter[str]()
    for at in range(1, calls + 1):
        try:
            came[fail(warm, tmp_path / "it", verb, at, right)] += 1
        except AssertionError as error:
            wrong.append(str(error)[:400])
            shutil.rmtree(tmp_path / "it", ignore_errors=True)
    told = ", ".join(f"{what}: {n}" for what, n in sorted(came.items()))
    record_property("told", f"{verb}, {calls} calls: {told}; wrong: {len(wrong)}")
    assert wrong == [], f"{len(wrong)} of {calls}"


@pytest.mark.parametrize(("verb", "number"), DARK)
def test_power_that_fails_loses_nothing_that_is_used_later(
    verb: str,
    number: int,
    warm: Place,
    known: Callable[[str], tuple[int, Any]],
    tmp_path: Path,
) -> None:
    calls, right = known(verb)
    draw = drawn(f"power {verb} {number}")
    at, names = draw.randint(1, calls), draw.random() < 0.5
    dark(warm, tmp_path / "it", verb, at, right, names)


def dark(
    warm: Place, folder: Path, verb: str, at: int, right: Any, names: bool
) -> None:
    """Let power fail at a call; what was begun is gone on with or made anew."""
    place = warm.copy(folder)
    done = place.command(verb, at, dark=True)
    where = f"{verb}, dark at call {at}: {done.stderr}"
    assert done.returncode == -signal.SIGKILL, where
    if place.journal.exists():
        place.lose(names)
    figures = place.folder / "project" / "run" / "metrics.json"
    if figures.is_file() and figures.read_text():  # it says that it is complete
        assert place.outcome("run", figures.read_text()) == right, where
    elif verb == "checkpoint":
        gone_on = place.command("resume run", None)
        assert gone_on.returncode in (0, 1, 2), where
        assert "a fault in feeddrive" not in gone_on.stderr, where
        assert "Traceback" not in gone_on.stderr, where
        if gone_on.returncode == 0:
            assert place.outcome(verb, gone_on.stdout) == right, where
    place.clear()
    again = place.command(verb, None)
    printed = again.stdout
    if verb == "resume" and "is complete" in again.stderr:
        printed = (place.folder / "project" / "cut" / "metrics.json").read_text()
    else:
        assert again.returncode == 0, f"after {where}: {again.stderr}"
    assert place.outcome(verb, printed) == right, where
    shutil.rmtree(place.folder)
