"""An FMU instance in a process of its own; what it does there cannot harm the run.

The child is spawned with nothing of the caller's script and runs
``isolated_child.serve``.  Before the run and at its end, requests and answers go
through a pipe.  While running, values lie in memory that both processes map
(``shared``) and channel.c hands requests over; where there is no compiler for it,
the handing over goes through the pipe too.  What comes back is not believed
(``frames``).

A child that dies, sends nonsense, or does not answer in time ends the run with an
error naming the FMU and what it was doing.  ``close`` leaves neither process nor
file behind, nor what the FMU has started, and says if the FMU did not survive its
end; a child whose master dies ends by itself.
"""

import ctypes
import queue
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from fmus.compile import CompileError
from orchestrator.errors import ProcessEnded, SimulationError
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.fmu.typed import Held
from orchestrator.instances.bundle import Bundle
from orchestrator.instances.child import Child, how_ended
from orchestrator.instances.ending import Ended
from orchestrator.instances.frames import fit
from orchestrator.instances.group import Group
from orchestrator.instances.isolated_child import serve
from orchestrator.instances.logs import LogMessage
from orchestrator.instances.possible import refuse_impossible
from orchestrator.instances.shared import Shared
from orchestrator.native import library as c
from orchestrator.system import Isolation
from orchestrator.warned import warn

REFUSED, LATE, INTERRUPTED = 3, 17, 18  # as in channel.c
BEGUN_WITHIN = 60.0  # s for a child to start, before it touches the FMU
LOADED_WITHIN = 5.0  # s for a child to load the FMU, at least
ENDING_WITHIN = 5.0  # s for a child to free its FMU


class IsolatedInstance:
    """The same calls as ``LocalInstance``, carried out by a child process."""

    step_major = 2  # channel_step is called like fmi2DoStep

    def __init__(
        self,
        name: str,
        description: FmuDescription,
        folder: Path,
        log: Callable[[str, LogMessage], None],
        isolation: Isolation,
        clocks: bool = False,
    ) -> None:
        refuse_impossible(name, description.path, isolation)
        self.name, self.description = name, description
        self.clock = ctypes.c_double(0.0)
        self.inputs: list[Group] = []
        self.outputs: list[Group] = []
        self.do_step: Any = None
        self._isolation, self._folder, self._log = isolation, folder, log
        self._requests: deque[str] = deque(maxlen=4)
        self._said: deque[LogMessage] = deque(maxlen=3)
        self._channel: c.Channel | None = None
        self._waiting = False  # for an answer through the pipe
        self._loaded = self._failed = False
        self.outcome = c.Outcome()
        try:
            self._library: Any = c.library()
        except CompileError:
            self._library = None
        self._link = c.Link(within=isolation.answer_within)
        self.slave = ctypes.c_void_p(ctypes.addressof(self._link))
        self._child = Child(
            *(serve, name, description, folder, isolation.memory_limit, clocks),
            self._library is not None,
            log=self._hear,
            ended=self._note_end,
            sandbox=isolation.sandbox,
        )

    def instantiate(self) -> None:
        if not self._loaded:
            # not sooner, so that several children start at once
            self._answer("start", BEGUN_WITHIN)
            within = max(self._isolation.answer_within, LOADED_WITHIN)
            self._answer("load", within)
            self._loaded = True
        self.ask("instantiate")

    def write(self, variables: Sequence[FmuVariable], values: list[Held]) -> None:
        self.ask("write", list(variables), values)

    def read(self, variables: Sequence[FmuVariable]) -> list[Held]:
        self._deliver()
        answer = self.ask("read", list(variables))
        if not fit(answer, variables):
            raise self.damaged("read")
        return cast("list[Held]", answer)

    def set_up(self, start: float, stop: float | None, tolerance: float | None) -> None:
        self.ask("set_up", start, stop, tolerance)

    def enter_initialization(self) -> None:
        self.ask("enter_initialization")

    def exit_initialization(self) -> None:
        self._deliver()
        self.ask("exit_initialization")

    def bind(
        self,
        vector: NDArray[np.float64],
        inputs: Sequence[FmuVariable],
        first_input: int,
        outputs: Sequence[FmuVariable],
        first_output: int,
    ) -> None:
        n, m = (sum(v.size for v in group) for group in (inputs, outputs))
        self._request("bind", list(inputs), list(outputs))
        child = self._child
        try:
            if self._channel is None:  # else the FMU was instantiated anew
                self._memory = Shared.made(n + m, self._folder, child.pipe, child.pid)
        except ConnectionError:
            raise self._died("bind") from None
        channel = self._memory.channel
        channel.doing = len(c.DOING)
        self._answer("bind")
        self._channel, self._names = channel, [v.name for v in inputs]
        self.outcome = channel.outcome
        self._link.channel, self._link.stale = ctypes.addressof(channel), 1
        self._link.values = self._memory.place
        self._link.n_inputs, self._link.n_outputs = n, m
        values = self._memory.values
        self._to = values[:n], vector[first_input : first_input + n]
        self._from = vector[first_output : first_output + m], values[n:]
        if self._library is not None:
            self.do_step = self._library.channel_step
            functions = self._library.channel_get, self._library.channel_set
            if n:
                self.inputs = [Bundle(self, vector, first_input, n, *functions)]
            if m:
                self.outputs = [Bundle(self, vector, first_output, m, *functions)]

    def push(self) -> None:
        assert self._channel is not None
        self._to[0][:] = self._to[1]
        self._channel.given = self._link.stale = 1

    def step(self, t: float, h: float) -> None:
        self.clock.value = t
        if self.do_step is not None:
            if status := self.do_step(self.slave, t, h, 1):
                raise self.failed_step(h, status)
            return
        assert self._channel is not None
        self._channel.t, self._channel.h = t, h
        self._channel.steps += 1
        self.ask("step")
        self._link.stale = 0

    def pull(self) -> None:
        if self._link.stale:
            self._exchange()
        to, values = self._from
        to[:] = values

    def quiet(self) -> None:
        self.ask("quiet")

    def ended(self) -> SimulationError:
        """Return how the FMU ended the run by its latest step."""
        end = self.ask("ended")
        return end if isinstance(end, Ended) else self.damaged("ended")

    def failed_step(self, h: float, status: int) -> SimulationError:
        """Return the error for a request through the channel that went wrong."""
        if status == REFUSED:
            try:
                self._answer("doStep")
            except SimulationError as error:
                return error
        if status == INTERRUPTED:
            return SimulationError(f"{self.name}: a signal interrupted {self._doing()}")
        return self._late() if status == LATE else self._died(self._doing())

    def close(self) -> None:
        """Ask the child to free the instance and end; kill it if it does not."""
        within = self._link.within = min(self._link.within, ENDING_WITHIN)
        damaged = self._child.damaged or (not self._waiting and self._child.unasked())
        if damaged and not self._failed:
            self._warn("is damaged and killed: it sent what is no answer")
        elif self._child.alive and not self._occupied():
            with suppress(SimulationError):
                self._leave()
                self._child.send("close")
                self._say_how_it_ended(self._child.join(within), within)
        self._child.close()
        if (denied := self._child.denials()) and not self._failed:
            warn(f"{self.name} ({self.description.path.name}):{denied}")
        if self._channel is not None:
            self._link.channel, self._channel = None, None
            self.outcome = c.Outcome()
            del self._to, self._from
            with suppress(BufferError):
                self._memory.close()

    def _say_how_it_ended(self, code: int | None, within: float) -> None:
        """Warn of an FMU that does not survive its own end; its rows are fine."""
        if code == 0 or self._failed:
            return
        how = f"did not end within {within:g} s and is killed"
        if code is not None:
            how = f"ended with {how_ended(code)}"
        self._warn(f"{how} when it was terminated and freed after the run")

    def _warn(self, how: str) -> None:
        where = f"{self.name} ({self.description.path.name})"
        warn(f"{where}: its process {how}; what was recorded is complete")

    def _occupied(self) -> bool:
        channel = self._channel
        busy = channel is not None and channel.asked.number != channel.answered.number
        return self._waiting or busy

    def _deliver(self) -> None:
        """Let inputs that were pushed reach the FMU."""
        if self._channel is not None and self._channel.given:
            self._exchange()

    def _exchange(self) -> None:
        if self._library is None:
            self.ask("exchange")
            self._link.stale = 0
        elif status := self._library.channel_ask(self.slave, c.ASK.index("exchange")):
            raise self.failed_step(0.0, status)

    def _leave(self) -> None:
        if self._channel is None or self._library is None:
            return
        if status := self._library.channel_ask(self.slave, c.ASK.index("leave")):
            raise self.failed_step(0.0, status)

    def ask(self, request: str, *arguments: Any) -> Any:
        self._request(request, *arguments)
        return self._answer(request)

    def _request(self, request: str, *arguments: Any) -> None:
        self._requests.append(request.replace("_", " "))
        self._leave()
        if self._child.unasked():
            raise self.damaged(request)
        self._link.stale = 1
        self._child.send(request, *arguments)

    def _answer(self, request: str, within: float = 0.0) -> Any:
        self._waiting = True
        within = within or self._isolation.answer_within
        if not self._loaded:
            self._requests.append(request)
        try:
            kind, value = self._child.answer(within)
        except queue.Empty:
            raise self._late(within) from None
        self._waiting = False
        if kind == "error":
            raise value
        if kind == "ended":
            raise self._died(self._doing())
        if kind != ("begun" if request == "start" else "done"):
            raise self.damaged(request)
        return value

    def _hear(self, message: LogMessage) -> None:
        self._said.append(message)
        self._log(self.name, message)

    def _note_end(self) -> None:
        self._link.ended = 1

    def _late(self, within: float | None = None) -> SimulationError:
        self._failed = True
        self._child.kill()
        within = within or self._isolation.answer_within
        return SimulationError(
            f"{self.name} ({self.description.path.name}): no answer within "
            f"{within:g} s (answer_within) in {self._doing()}; its process is killed. "
            f"{self._history()}"
        )

    def damaged(self, request: str) -> SimulationError:
        """Return the error for an answer that is none to this request."""
        self._child.damaged = True
        return self._died(request)

    def _died(self, request: str) -> SimulationError:
        self._failed = True
        if self._child.damaged:
            self._child.kill()
            return ProcessEnded(
                f"{self.name} ({self.description.path.name}): its process is damaged: "
                f"what it sent during {request} is no answer; it is killed. "
                f"{self._history()}"
            )
        code = self._child.join(ENDING_WITHIN)
        how = how_ended(code)
        remedy = ""
        if self._isolation.memory_limit is not None:
            remedy = f"; memory_limit is {self._isolation.memory_limit / 1e6:g} MB"
        elif code == -9:
            remedy = "; the system kills so when memory runs out"
        return ProcessEnded(
            f"{self.name} ({self.description.path.name}): its process ended with {how} "
            f"during {request}{remedy}. {self._history()}"
        )

    def _doing(self) -> str:
        """Say what the FMU was last asked to do."""
        channel = self._channel
        if channel is None or channel.steps == 0 or channel.doing == len(c.DOING):
            return self._requests[-1] if self._requests else "load"
        if not 0 <= channel.doing < len(c.DOING):
            return "a call that its damaged process does not tell"
        word = c.DOING[channel.doing]
        kind = word if word == "doStep" else f"{word} before or after doStep"
        return f"{kind} of {channel.h:.9g} s at t = {channel.t:.9g} s"

    def _history(self) -> str:
        calls = list(self._requests)
        if self._channel is not None and self._channel.steps:
            inputs = ", ".join(
                f"{name} = {value:.6g}"
                for name, value in zip(self._names[:4], self._to[0], strict=False)
            )
            n = self._channel.steps
            calls = [*calls[-1:], f"{n} steps, the last with {inputs or 'no inputs'}"]
        said = "; ".join(map(str, self._said)) or "nothing"
        told = f"Its last calls: {', '.join(calls) or 'load'}. It logged: {said}."
        return told + self._child.denials()
