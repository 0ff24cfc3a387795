"""One page that is open: what it draws, the runs it started.

It says ``try`` (a position of a slider), ``run``, ``abort``, ``window`` (a zoom),
``compare``, ``ask`` (a verb); each with an ``id``, under which the answer comes: a
frame, or {"id", "error"}.  While a run goes on frames come with ``t`` and ``stop``,
while a verb does its log, line by line.
"""

import asyncio
import json
from collections import OrderedDict
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from orchestrator.errors import ScenarioError
from orchestrator.outcome import Run
from orchestrator.page.compared import compared
from orchestrator.page.curves import Board, board_of, figures, finite
from orchestrator.page.kept import Passing
from orchestrator.page.project import Project
from orchestrator.page.running import Running
from orchestrator.page.verbs import Asking
from orchestrator.page.work import Work, answer_of

BOARDS = 8  # that can still be zoomed
LOOK = 1.0  # s between two looks at the files of the project


class Session:
    """Answers one WebSocket until it closes."""

    def __init__(self, project: Project, work: Work, asked: WebSocket) -> None:
        self._project, self._work, self._asked = project, work, asked
        self._boards: OrderedDict[int, Board] = OrderedDict()
        self._running: dict[int, Running | Asking] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    async def go_on(self) -> None:
        """Answer until the page is closed; then its runs are aborted."""
        await self._asked.accept()
        does: dict[str, Callable[[int, Mapping[str, Any]], Awaitable[None]]] = {
            "try": self._try,
            "run": self._run,
            "abort": self._abort,
            "window": self._window,
            "compare": self._compare,
            "ask": self._ask,
        }
        self._start(self._watch())
        try:
            with suppress(WebSocketDisconnect):
                while True:
                    said = json.loads(await self._asked.receive_text())
                    number, do = int(said["id"]), does[said["do"]]
                    self._start(self._answered(number, do(number, said)))
        except (ValueError, KeyError, TypeError):
            await self._asked.close(1003, "not understood")
        finally:
            for running in self._running.values():
                running.abort()
            for task in self._tasks:
                task.cancel()

    def _start(self, doing: Any) -> None:
        task = asyncio.create_task(doing)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _answered(self, number: int, doing: Awaitable[None]) -> None:
        try:
            await doing
        except WebSocketDisconnect:
            return
        except Exception as error:
            with suppress(RuntimeError, WebSocketDisconnect):  # closed meanwhile
                await self._asked.send_json({"id": number, **answer_of(error)})

    async def _watch(self) -> None:
        """Tell the page when files of the project changed, which are read again."""
        known = self._project.stamp()
        while True:
            await asyncio.sleep(LOOK)
            now = await asyncio.to_thread(self._project.stamp)
            if now != known:
                known = now
                await self._work.done(self._work.shelf.clear)
                await self._asked.send_json({"changed": True})

    async def _try(self, number: int, said: Mapping[str, Any]) -> None:
        file = self._project.scenario(str(said["scenario"]))
        width, settings = int(said["width"]), _settings(said)

        def drawn() -> bytes | str:
            found = self._work.shelf.run(file, settings)
            return (
                found if isinstance(found, str) else self._frame(number, found, width)
            )

        found = await self._work.done(drawn)
        if isinstance(found, str):
            await self._asked.send_json({"id": number, "later": found})
        else:
            await self._asked.send_bytes(found)

    async def _run(self, number: int, said: Mapping[str, Any]) -> None:
        file = self._project.scenario(str(said["scenario"]))
        width = int(said["width"])
        pace = said.get("pace")
        running = Running(file, _settings(said), None if pace is None else float(pace))
        self._running[number] = running
        loop = asyncio.get_running_loop()

        def told(t: float, stop: float, rows: Passing | None) -> None:
            head = {"id": number, "t": t, "stop": stop, "live": True}
            board = board_of(rows) if rows else Board([])
            frame = board.frame(head, width)
            loop.call_soon_threadsafe(self._start, self._asked.send_bytes(frame))

        def done() -> bytes:
            return self._frame(number, running.run(told), width)

        try:
            await self._asked.send_bytes(await self._work.run(done))
        finally:
            del self._running[number]

    async def _compare(self, number: int, said: Mapping[str, Any]) -> None:
        names, signals = list(map(str, said["runs"])), said.get("signals", ())
        width = int(said["width"])

        def drawn() -> bytes:
            told, panels = compared(self._project, names, list(map(str, signals)))
            board = self._keep(number, Board(panels))
            return board.frame({"id": number, "board": number, **told}, width)

        await self._asked.send_bytes(await self._work.done(drawn))

    async def _ask(self, number: int, said: Mapping[str, Any]) -> None:
        asking = self._running[number] = Asking(self._project, said)

        async def told(line: str) -> None:
            await self._asked.send_json({"id": number, "live": True, "line": line})

        try:
            answer = await asking.done(told)
            await self._asked.send_json({"id": number, **finite(answer)})
        finally:
            del self._running[number]

    async def _abort(self, number: int, said: Mapping[str, Any]) -> None:
        if running := self._running.get(int(said["run"])):
            running.abort()

    async def _window(self, number: int, said: Mapping[str, Any]) -> None:
        board = self._boards.get(int(said["board"]))
        if board is None:
            raise ScenarioError("these curves are no longer kept; run again")
        window = (float(said["from"]), float(said["to"]))
        head = {"id": number, "board": said["board"]}
        frame = await self._work.done(board.frame, head, int(said["width"]), window)
        await self._asked.send_bytes(frame)

    def _frame(self, number: int, run: Run, width: int) -> bytes:
        board = self._keep(number, board_of(run))
        timing = run.timing
        head = {
            "id": number,
            "board": number,
            "figures": figures(run),
            "diverged": run.diverged,
            "ended": run.ended and str(run.ended),
            "warnings": run.warnings,
            "unlike": run.unlike,
            "paced": str(timing.paced) if timing and timing.paced else None,
            "kept": None if isinstance(run, Passing) else str(run.folder),
        }
        return board.frame(head, width)

    def _keep(self, number: int, board: Board) -> Board:
        self._boards[number] = board
        while len(self._boards) > BOARDS:
            self._boards.popitem(last=False)
        return board


def _settings(said: Mapping[str, Any]) -> dict[str, float | str]:
    """Return what is set: numbers, or text as ``--set`` takes it.

    Raises:
        ScenarioError: it is neither.
    """
    found: dict[str, float | str] = {}
    for key, value in dict(said.get("settings", {})).items():
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise ScenarioError(f"{key}: {value!r} is neither a number nor a text")
        found[str(key)] = value if isinstance(value, str) else float(value)
    return found
