"""Work that takes a while, off the loop that answers: one piece after the other.

It is executed in the context of whoever asked, so that what ``serve`` allows of
others' Python holds here as well.
"""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from types import TracebackType
from typing import Any, ParamSpec, TypeVar

from fmus.build import BuildError
from fmus.compile import CompileError
from fmus.units import UnitError
from orchestrator.errors import FeedDriveError, shown
from orchestrator.page.document import Editor
from orchestrator.page.kept import Shelf

P = ParamSpec("P")
T = TypeVar("T")
RUNS = 4  # that go on at a time


class Work:
    """The threads of a page: one bench for what is looked at, some for runs."""

    def __init__(self) -> None:
        self._bench = ThreadPoolExecutor(1)
        self._runs = ThreadPoolExecutor(RUNS)
        self.shelf, self.editor = Shelf(), Editor()  # they belong to the bench

    async def done(self, do: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Return what comes of work on the bench."""
        return await self._in(self._bench, lambda: do(*args, **kwargs))

    async def run(self, do: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Return what comes of a run, beside the bench."""
        return await self._in(self._runs, lambda: do(*args, **kwargs))

    async def _in(self, pool: ThreadPoolExecutor, do: Callable[[], T]) -> T:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(pool, copy_context().run, do)

    def __enter__(self) -> "Work":
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        for pool in (self._bench, self._runs):
            pool.shutdown(wait=False, cancel_futures=True)


def refusal(error: BaseException) -> str:
    """Return what the page says of an error, as the command line would."""
    if isinstance(error, FeedDriveError | BuildError | CompileError | UnitError):
        return shown(str(error))
    if isinstance(error, OSError):
        reason = error.strerror or str(error)
        return f"{error.filename}: {reason}" if error.filename else reason
    return f"a fault in feeddrive: {type(error).__name__}: {error}"


def answer_of(error: BaseException) -> dict[str, Any]:
    """Return the answer that tells an error, and the folder with rows if any."""
    folder = getattr(error, "folder", None)
    return {"error": refusal(error)} | ({"folder": str(folder)} if folder else {})
