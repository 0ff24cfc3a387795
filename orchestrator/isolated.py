"""An FMU instance in a process of its own, for FMUs that bring an interpreter.

Two Python FMUs in one interpreter can silently run each other's code, and a
crash of theirs must not take the run along.  The child is spawned with no
state of ours; requests and answers go through one pipe, one round trip per
step (inputs with it, outputs back).  A child that dies or does not answer
ends the run with an error naming the FMU.
"""

import multiprocessing as mp
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import FeedDriveError, SimulationError
from orchestrator.fmu import FmuDescription, FmuVariable
from orchestrator.instance import LocalInstance, LogMessage

ANSWER_WITHIN = 60.0  # s; longer means the FMU hangs


class IsolatedInstance:
    """The same calls as ``LocalInstance``, carried out by a child process."""

    def __init__(
        self,
        name: str,
        description: FmuDescription,
        folder: Path,
        log: Callable[[str, LogMessage], None],
    ) -> None:
        self.name = name
        self.description = description
        self._log = log
        self._inputs: tuple[int, int] = (0, 0)
        self._outputs: tuple[int, int] = (0, 0)
        self._read: list[float] | None = None
        self._pending: list[float] = []
        context = mp.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        arguments = (theirs, name, description, folder)
        self._child: Any = context.Process(target=_serve, args=arguments, daemon=True)
        self._child.start()
        theirs.close()
        self._answer("load")

    def instantiate(self) -> None:
        self._ask("instantiate")

    def write(self, variables: Sequence[FmuVariable], values: list[float]) -> None:
        self._ask("write", list(variables), values)

    def read(self, variables: Sequence[FmuVariable]) -> list[float]:
        answer: list[float] = self._ask("read", list(variables))
        return answer

    def enter_initialization(self, start: float) -> None:
        self._ask("enter_initialization", start)

    def exit_initialization(self) -> None:
        self._ask("exchange", self._pending)
        self._pending, self._read = [], None
        self._ask("exit_initialization")

    def bind(
        self,
        vector: NDArray[np.float64],
        inputs: Sequence[FmuVariable],
        first_input: int,
        outputs: Sequence[FmuVariable],
        first_output: int,
    ) -> None:
        self._vector = vector
        sizes = [sum(v.size for v in group) for group in (inputs, outputs)]
        self._inputs = (first_input, first_input + sizes[0])
        self._outputs = (first_output, first_output + sizes[1])
        self._ask("bind", list(inputs), list(outputs), *sizes)

    def push(self) -> None:
        first, last = self._inputs
        self._pending = self._vector[first:last].tolist()
        self._read = None

    def step(self, t: float, h: float) -> None:
        self._read = self._ask("step", self._pending, t, h)

    def pull(self) -> None:
        if self._read is None:
            self._read = self._ask("exchange", self._pending)
        first, last = self._outputs
        self._vector[first:last] = self._read

    def close(self) -> None:
        """Ask the child to free the instance and end; kill it if it does not."""
        if self._child.is_alive():
            try:
                self._pipe.send(("close",))
                self._child.join(5)
            except OSError:
                pass
            if self._child.is_alive():
                self._child.kill()
                self._child.join()
        self._pipe.close()

    def _ask(self, request: str, *arguments: Any) -> Any:
        try:
            self._pipe.send((request, *arguments))
        except OSError:
            raise self._died(request) from None
        return self._answer(request)

    def _answer(self, request: str) -> Any:
        while True:
            try:
                if not self._pipe.poll(ANSWER_WITHIN):
                    raise SimulationError(
                        f"{self.name} ({self.description.path.name}): no answer to "
                        f"{request} within {ANSWER_WITHIN:.0f} s; its process is "
                        f"killed: run it alone in another tool to see why"
                    )
                kind, value = self._pipe.recv()
            except (EOFError, OSError):
                raise self._died(request) from None
            if kind == "log":
                self._log(self.name, value)
            elif kind == "error":
                raise value
            else:
                return value

    def _died(self, request: str) -> SimulationError:
        self._child.join(5)
        code = self._child.exitcode
        how = (
            f"signal {-code}" if code is not None and code < 0 else f"exit code {code}"
        )
        return SimulationError(
            f"{self.name} ({self.description.path.name}): its process ended with {how} "
            f"during {request}: run it alone in another tool to see why"
        )


def _serve(pipe: Any, name: str, description: FmuDescription, folder: Path) -> None:
    """Carry out requests until the pipe closes; runs in the child."""
    try:
        instance = LocalInstance(
            name,
            description,
            folder,
            lambda _name, message: pipe.send(("log", message)),
        )
        pipe.send(("done", None))
    except FeedDriveError as error:
        pipe.send(("error", error))
        return
    vector = np.zeros(0)
    inputs = 0
    while True:
        try:
            request, *arguments = pipe.recv()
        except EOFError:
            request = "close"
        if request == "close":
            instance.close()
            return
        try:
            answer: Any = None
            if request == "bind":
                first, second, inputs, outputs = arguments
                vector = np.zeros(inputs + outputs)
                instance.bind(vector, first, 0, second, inputs)
            elif request in ("step", "exchange"):
                values, *when = arguments
                if len(values):
                    vector[:inputs] = values
                    instance.push()
                if when:
                    instance.step(*when)
                instance.pull()
                answer = vector[inputs:].tolist()
            else:
                answer = getattr(instance, request)(*arguments)
            pipe.send(("done", answer))
        except FeedDriveError as error:
            pipe.send(("error", error))
