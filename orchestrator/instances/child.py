"""The process of an FMU as its master has it: what it says, and how it ends.

A thread takes what comes up the pipe.  ``kill`` ends the process and all that the
FMU started in it; ``close`` leaves nothing of either.
"""

import multiprocessing as mp
import os
import queue
import signal
import socket
import sys
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import wait
from threading import Thread
from typing import Any

from orchestrator.instances.descendants import end_marked, new_mark
from orchestrator.instances.frames import LARGEST, Damaged, decode
from orchestrator.instances.guard import guards
from orchestrator.instances.logs import LogMessage
from orchestrator.instances.spawn import spawn

UNASKED = 1000  # answers that may wait to be taken
GUARD_WITHIN = 3.0  # s for a guard to kill what is left


class Child:
    """A process that runs ``target(pipe, *arguments)``.

    ``log`` takes its messages, ``ended`` is called when it has ended, or sent what is
    no frame: then it is ``damaged``.  In a ``sandbox``, the target has as its last
    argument where it tells what it is denied.
    """

    def __init__(
        self,
        target: Callable[..., None],
        *arguments: Any,
        log: Callable[[LogMessage], None],
        ended: Callable[[], None],
        sandbox: bool = False,
    ) -> None:
        self.damaged = False
        self._log, self._ended = log, ended
        self._answers: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
        self.pipe, theirs = mp.get_context("spawn").Pipe()
        self._mark = new_mark()
        self._denied: list[str] = []
        self._denials, telling = None, []
        if sandbox:
            self._denials, end = mp.get_context("spawn").Pipe(duplex=False)
            telling = [end]
        self._process = spawn(self._mark, target, theirs, *arguments, *telling)
        for end in (theirs, *telling):
            end.close()
        self._ending = _ending(self._process)
        self._listener = Thread(target=self._listen, daemon=True)
        self._listener.start()

    @property
    def pid(self) -> int:
        return int(self._process.pid)

    @property
    def alive(self) -> bool:
        return bool(self._process.is_alive())

    def send(self, *request: Any) -> None:
        """Send a request; that the child is gone is noticed by the listener."""
        with suppress(OSError):
            self.pipe.send(request)

    def answer(self, within: float) -> tuple[str, Any]:
        """Return the next answer: done, begun or error; ``ended`` if there is none.

        Raises:
            queue.Empty: none came within so many seconds.
        """
        kind, value = self._answers.get(timeout=within)
        if kind == "ended":
            self._answers.put((kind, value))
        return kind, value

    def unasked(self) -> bool:
        """Tell whether an answer is there, before anything is asked."""
        with suppress(queue.Empty):
            return self.answer(0.0)[0] != "ended"
        return False

    def join(self, within: float) -> int | None:
        """Wait for its end; return its exit code, None if it has none yet."""
        self._process.join(within)
        code: int | None = self._process.exitcode
        return code

    def kill(self) -> None:
        """Kill it, if it is alive, and what the FMU has started."""
        if sys.platform == "win32":
            self._process.kill()
            return
        self._process.terminate()  # its guard leaves nothing, if it has one
        self._process.join(GUARD_WITHIN if guards() else 0.0)
        with suppress(OSError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()
        end_marked(self._mark)

    def close(self) -> None:
        """Kill it and give back what was taken for it."""
        self.kill()
        self._process.join()
        if sys.platform != "win32":  # what is left may hold the other end of the pipe
            with (
                socket.socket(fileno=os.dup(self.pipe.fileno())) as end,
                suppress(OSError),
            ):
                end.shutdown(socket.SHUT_RDWR)
        self._listener.join()
        self.denials()
        if self._denials is not None:
            self._denials.close()
            self._denials = None
        self.pipe.close()
        if self._ending != self._process.sentinel:
            os.close(self._ending)

    def denials(self) -> str:
        """Return what its sandbox denied until now, as a sentence if anything was."""
        if self._denials is not None:
            with suppress(EOFError, OSError):
                while self._denials.poll():
                    told = self._denials.recv_bytes(LARGEST)
                    self._denied.append(told.decode("utf-8", "replace"))
        return f" Its sandbox denied {', '.join(self._denied)}." if self._denied else ""

    def _listen(self) -> None:
        """Take what comes up the pipe, until the child has ended; in a thread."""
        try:
            while self.pipe in wait([self.pipe, self._ending]):
                kind, value = decode(self.pipe.recv_bytes(LARGEST))
                if kind == "log":
                    self._log(value)
                elif self._answers.qsize() > UNASKED:
                    raise Damaged("answers that nobody asked for")
                else:
                    self._answers.put((kind, value))
        except (EOFError, ConnectionError):
            pass  # it has ended
        except (Damaged, OSError):  # an OSError is a length that cannot be
            self.damaged = True
        self._ended()
        self._answers.put(("ended", None))


def how_ended(code: int | None) -> str:
    """Say how a process ended by its exit code."""
    if code is not None and code < 0:
        return f"signal {-code} ({signal.Signals(-code).name})"
    return f"exit code {code}"


def _ending(process: Any) -> int:
    """Return what can be waited for until a process has ended.

    Its sentinel is a pipe, which what it leaves behind may hold open.
    """
    if hasattr(os, "pidfd_open"):
        with suppress(OSError):
            return os.pidfd_open(process.pid)
    sentinel: int = process.sentinel
    return sentinel
