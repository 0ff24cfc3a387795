"""A process in which all is imported already; it forks one for every command.

Most of a short command is its imports, and thousands of commands follow each other
where every call fails in turn.  A forked command sets out where the command line
begins, with the folder, environment and preloaded calls of its own, and ends as a
process does.
"""

import ctypes
import importlib
import json
import os
import pkgutil
import runpy
import select
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ENDING = 10  # s in which what watches over a command has to end after it
LEFT_OUT = ("orchestrator.page", "orchestrator.pytest_plugin", "orchestrator.__main__")


class Forker:
    """The process, seen from a test.

    ``library`` is what makes calls fail (failing.c); it is preloaded.
    """

    def __init__(self, library: Path) -> None:
        self.library = library
        self._process = subprocess.Popen(
            [sys.executable, __file__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={
                **os.environ,
                "LD_PRELOAD": str(library),
                "OPENBLAS_NUM_THREADS": "1",
            },
        )

    def run(
        self, words: list[str], folder: Path, environment: dict[str, str]
    ) -> "subprocess.CompletedProcess[str]":
        """Carry out a command of ours; ``environment`` is what it has beyond ours."""
        said = [folder.with_name(f"{folder.name}.{name}") for name in ("out", "err")]
        asked = [words, str(folder), environment, [str(file) for file in said]]
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(json.dumps(asked), file=self._process.stdin, flush=True)
        answer = self._process.stdout.readline()
        assert answer, "the process that forks has ended"
        code, left = json.loads(answer)
        assert left == [], "processes of the command that were not waited for"
        texts = [file.read_text() for file in said]
        return subprocess.CompletedProcess(words, code, *texts)

    def close(self) -> None:
        """End it."""
        self._process.communicate(timeout=60)


def import_all() -> None:
    """Import our modules, and with them those of others."""
    import orchestrator

    for module in pkgutil.walk_packages(orchestrator.__path__, "orchestrator."):
        if not module.name.startswith(LEFT_OUT):
            importlib.import_module(module.name)
    tasks = list(Path("/proc/self/task").iterdir())
    assert len(tasks) == 1, "a process with threads cannot be forked"


def wait(pid: int, within: float = 300.0) -> int:
    """Return how a command ended; one that does not end is killed."""
    descriptor = os.pidfd_open(pid)
    if not select.select([descriptor], [], [], within)[0]:
        os.killpg(pid, signal.SIGKILL)
    os.close(descriptor)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


def left_in_session(session: int) -> list[str]:
    """Return the processes that a command has left in its session."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            name, _, rest = (folder / "stat").read_text().rpartition(")")
        except OSError:
            continue  # it has ended meanwhile
        state, _, _, of, *_ = rest.split()
        if int(of) == session and state != "Z":
            found.append(name)
    return found


def become(
    words: list[str], folder: str, environment: dict[str, str], said: list[str]
) -> None:
    """Make this process the command's."""
    os.setsid()
    os.chdir(folder)
    for number, (name, flags) in enumerate(
        [(os.devnull, os.O_RDONLY)]
        + [(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC) for file in said]
    ):
        descriptor = os.open(name, flags, 0o600)
        os.dup2(descriptor, number)
        os.close(descriptor)
    os.environ.update(environment)
    tempfile.tempdir = None  # the environment's
    sys.argv = ["feeddrive", *words]
    if "FAILING_COUNT" in environment:
        ctypes.CDLL(None).failing_begin()
    else:
        del os.environ["LD_PRELOAD"]


def asked() -> bool:
    """Fork for every line; return in the child True, at the end False."""
    for line in sys.stdin:
        request: Any = json.loads(line)
        pid = os.fork()
        if not pid:
            become(*request)
            return True
        code = wait(pid)
        until = time.monotonic() + ENDING
        while (left := left_in_session(pid)) and time.monotonic() < until:
            time.sleep(0.02)
        print(json.dumps([code, left]), flush=True)
    return False


if __name__ == "__main__":
    sys.path.pop(0)  # this folder
    import_all()
    if asked():
        runpy.run_module("orchestrator", run_name="__main__", alter_sys=True)
