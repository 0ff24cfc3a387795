"""What runs in the process of an isolated FMU: ``serve``.

Requests come through the pipe (name and arguments; answered by a frame ``done`` or
``error``), or, once an FMU is bound, through the channel, until it says to leave.
Log messages go up the pipe as they come.  The process ignores Ctrl-C, which is the
master's, and ends when the master is gone, with all that the FMU has started.
"""

import ctypes
import multiprocessing as mp
import os
import socket
import sys
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import wait
from pathlib import Path
from threading import Lock, Thread
from typing import Any, NoReturn

from orchestrator.errors import FeedDriveError, SimulationError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.folders.temporary import sweep_when_free
from orchestrator.instances.clocked import ClockedInstance
from orchestrator.instances.descendants import MARK, end_marked
from orchestrator.instances.frames import encode
from orchestrator.instances.group import group_table
from orchestrator.instances.guard import guards, stand_guard
from orchestrator.instances.instance import LocalInstance
from orchestrator.instances.load import load
from orchestrator.instances.logs import LogMessage
from orchestrator.instances.sandbox import enter
from orchestrator.instances.shared import Shared
from orchestrator.instances.spawn import stand_alone
from orchestrator.instances.state import (
    back_here,
    drop_here,
    keep_here,
    restore_here,
    save_here,
)
from orchestrator.native import library as c

OWN = ("bind", "step", "exchange", "save", "restore", "keep", "back", "drop")


def serve(
    pipe: Any,
    name: str,
    description: FmuDescription,
    folder: Path,
    memory_limit: float | None,
    clocks: bool,
    shared: bool,
    denials: Any = None,
) -> None:
    """Load an FMU and carry out requests until one is to close.

    ``clocks``: it is ticked by its clock if it has one.  ``shared``: requests to step
    come through the channel, not the pipe.  ``denials``: in a sandbox, which tells
    there what it denies.
    """
    guard = _stand_alone(folder, denials)
    lock = Lock()

    def send(kind: str, value: Any) -> None:
        with lock, suppress(OSError):  # a master that is gone needs no answer
            pipe.send_bytes(encode(kind, value))

    def log(_name: str, message: LogMessage) -> None:
        send("log", message)

    try:
        if memory_limit is not None:
            _limit_memory(memory_limit)
        _import_tools()
        if guard is not None:
            if shared:
                c.library()
            enter(folder, description.path, memory_limit, guard)
        send("begun", None)  # from here on the FMU's own code may run
        instance = load(name, description, folder, log, clocks=clocks)
        server = _Server(instance, folder, shared, pipe)
        send("done", None)
    except FeedDriveError as error:
        send("error", error)
        return
    while True:
        if server.listening and (refusal := server.listen()):
            send("error", refusal)
            server.answer()
            continue
        try:
            request, *arguments = pipe.recv()
        except (EOFError, OSError):
            _end_with_master(folder)
        if request == "close":
            server.instance.close()
            _end(0)
        try:
            send("done", server.carry_out(request, arguments))
        except FeedDriveError as error:
            send("error", error)
        except MemoryError:
            send("error", SimulationError(f"{name}: out of memory in {request}"))


class _Server:
    """The FMU and, once it is bound, the memory shared with the master."""

    def __init__(
        self, instance: LocalInstance, folder: Path, by_channel: bool, pipe: Any
    ) -> None:
        self.instance, self.folder, self.by_channel = instance, folder, by_channel
        self.pipe = pipe
        self.memory: Shared | None = None
        self.listening = False

    def carry_out(self, request: str, arguments: Sequence[Any]) -> Any:
        if request in OWN:
            return getattr(self, request)(*arguments)
        return getattr(self.instance, request)(*arguments)

    def bind(
        self, inputs: Sequence[FmuVariable], outputs: Sequence[FmuVariable]
    ) -> None:
        if self.memory is None:  # else the FMU was instantiated anew
            self.memory = Shared.given(self.folder, self.pipe)
        self.shared = self.memory.channel
        self.instance.outcome = self.shared.outcome
        n = sum(v.size for v in inputs)
        self.instance.bind(self.memory.values, inputs, 0, outputs, n)
        if self.by_channel:
            self.kernel = self._kernel()
            self.listening = True

    def save(self) -> list[bytes]:
        """Return the FMU's state, with the inputs that were handed over set."""
        self._set_inputs()
        self.shared.doing = len(c.DOING)
        return [save_here(self.instance)]

    def restore(self, state: bytes) -> None:
        restore_here(self.instance, state)

    def keep(self) -> None:
        self._set_inputs()
        self.state = keep_here(self.instance)

    def back(self) -> None:
        back_here(self.instance, self.state)

    def drop(self) -> None:
        drop_here(self.instance, self.state)

    def _kernel(self) -> c.Kernel:
        """Return a kernel of which this FMU is the only part."""
        instance = self.instance
        groups = [instance.inputs, instance.outputs]
        tables = [(c.Group * len(g))(*map(group_table, g)) for g in groups]
        ticker = instance.ticker() if isinstance(instance, ClockedInstance) else None
        part = c.Part(
            instance=instance.slave.value,
            do_step=c.address(instance.do_step),
            clock=ctypes.addressof(instance.clock),
            inputs=ctypes.addressof(tables[0]),
            n_inputs=len(tables[0]),
            outputs=ctypes.addressof(tables[1]),
            n_outputs=len(tables[1]),
            outcome=ctypes.addressof(instance.outcome),
            major=instance.step_major,
            ticker=ctypes.addressof(ticker) if ticker else None,
        )
        self._kept = tables, part, ticker
        return c.Kernel(parts=ctypes.addressof(part))

    def listen(self) -> FeedDriveError | None:
        """Serve the channel; return the error of a request that failed."""
        library = c.library()
        if library.channel_serve(ctypes.addressof(self.shared), self.kernel):
            return None
        kernel, instance = self.kernel, self.instance
        how = c.FAILURES[int(kernel.failure)]
        status, group = int(kernel.status), int(kernel.group)
        if how == "step":
            return instance.failed_step(float(kernel.h), status)
        if how == "tick":
            assert isinstance(instance, ClockedInstance)
            return instance.failed_tick(status)
        if how == "get":
            return instance.outputs[group].failure("get", status)
        if how == "set":
            return instance.inputs[group].failure("set", status)
        sink = instance.inputs[group]
        assert sink.vector is not None
        given = sink.vector[sink.first : sink.first + sink.size]
        return sink.misfit(given.tolist())

    def answer(self) -> None:
        """Tell the master that its request failed."""
        c.library().channel_answer(ctypes.addressof(self.shared))

    def exchange(self) -> None:
        """Set inputs that were given, get outputs; through the pipe."""
        self._set_inputs()
        self.shared.doing = c.DOING.index("get")
        self.instance.pull()
        self.shared.doing = len(c.DOING)

    def step(self) -> None:
        """Set inputs that were given, step, get outputs; through the pipe."""
        self._set_inputs()
        self.shared.doing = c.DOING.index("doStep")
        self.instance.step(self.shared.t, self.shared.h)
        self.exchange()

    def _set_inputs(self) -> None:
        if self.shared.given:
            self.shared.doing = c.DOING.index("set")
            self.instance.push()
            self.shared.given = 0


def _import_tools() -> None:
    """Import what loading an FMU needs, which is not the FMU's time."""
    from fmpy import fmi2, fmi3

    _ = fmi2, fmi3


def _stand_alone(folder: Path, denials: Any) -> socket.socket | None:
    """Make this process independent of the terminal and of the master's end."""
    stand_alone()
    if guards():
        return stand_guard(lambda: sweep_when_free(folder), denials)
    Thread(target=_end_with_master, args=(folder,), daemon=True).start()
    return None


def _end_with_master(folder: Path) -> NoReturn:
    """Wait for the end of the master, delete what it left, and end too."""
    master = mp.parent_process()
    assert master is not None
    wait([master.sentinel])
    if mark := os.environ.get(MARK):
        end_marked(mark)
    sweep_when_free(folder)
    _end(1)


def _end(code: int) -> NoReturn:
    """End at once: neither exit handlers nor threads of an FMU can hinder it."""
    sys.stderr.flush()
    os._exit(code)


def _limit_memory(size: float) -> None:
    """Let the process take ``size`` bytes more than it has; nothing on Windows."""
    if sys.platform == "win32":
        return
    import resource

    taken = 0
    with suppress(OSError):
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        taken = pages * resource.getpagesize()
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = taken + int(size)
    limit = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
