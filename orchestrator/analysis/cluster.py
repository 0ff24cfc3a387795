"""Members of a sweep on many machines, by Dask.

A composition travels once, as its lock with the FMUs in it, found on a worker by
its digest; then batches of values.  A worker that dies is replaced by its cluster
and its batches are done again; a batch that kills its worker each time is split,
and the member that does so alone is failed.
"""

import atexit
import hashlib
import io
import zipfile
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from orchestrator.analysis.members import Group, Job, Outcome, Workers
from orchestrator.errors import ScenarioError
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.lock import LOCK, write_lock
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

BATCH = 32


class Cluster:
    """The workers at a scheduler's address, such as ``tcp://10.0.0.1:8786``.

    Raises:
        ScenarioError: Dask is not installed, or nobody answers there.
    """

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise ScenarioError(
                "--scheduler: Dask is not installed; pip install "
                "'feeddrive-cosim[cluster]'"
            ) from None
        try:
            self._client: Any = Client(address, timeout=10)  # type: ignore[no-untyped-call]
        except (OSError, ValueError) as error:
            raise ScenarioError(
                f"--scheduler {address}: no scheduler answers ({error})"
            ) from None

    def close(self) -> None:
        """Leave the scheduler."""
        self._client.close()

    def __call__(self, composition: Composition, count: int = 1) -> "Remote":
        """Return the runner of a composition's members."""
        return Remote(self._client, packed(composition), count)


class Remote:
    """Runs the members of a composition on a cluster."""

    executor = "cluster"

    def __init__(self, client: Any, content: bytes, count: int) -> None:
        self._client, self._count = client, count
        self._digest = hashlib.sha256(content).hexdigest()
        self._content = client.scatter(content, broadcast=True)

    def run(self, jobs: Sequence[Job]) -> Iterator[Outcome]:
        """Yield the outcome of every job, in order."""
        batches = [list(jobs[i : i + BATCH]) for i in range(0, len(jobs), BATCH)]
        futures = [self._submit(batch) for batch in batches]
        for batch, future in zip(batches, futures, strict=True):
            yield from self._taken(batch, future)

    def _submit(self, batch: Sequence[Job]) -> Any:
        arguments = self._digest, self._content, self._count, batch
        return self._client.submit(carry_out, *arguments, pure=False)

    def _taken(self, batch: Sequence[Job], future: Any) -> Iterator[Outcome]:
        from distributed.scheduler import KilledWorker

        try:
            yield from future.result()
        except KilledWorker:
            if len(batch) == 1:
                why = "kills the process it runs in"
                yield Outcome(batch[0].index, {}, failure=why)
                return
            middle = len(batch) // 2
            for half in (batch[:middle], batch[middle:]):
                yield from self._taken(half, self._submit(half))


def packed(composition: Composition) -> bytes:
    """Return a composition's lock and FMUs as a zip archive, the same each time."""
    folder = Path(mkdtemp())
    write_lock(composition, folder)
    room = io.BytesIO()
    with zipfile.ZipFile(room, "w") as archive:
        for file in sorted(folder.rglob("*")):
            if file.is_file():
                name = file.relative_to(folder).as_posix()
                archive.writestr(zipfile.ZipInfo(name), file.read_bytes())
                file.unlink()
    return room.getvalue()


def carry_out(
    digest: str, content: bytes, count: int, jobs: Sequence[Job]
) -> list[Outcome]:
    """Return the outcomes of a batch; on a worker."""
    return list(_group(digest, _Content(content), count).run(jobs))


class _Content(bytes):
    """Bytes that are one and the same to a cache: the digest tells them apart."""

    def __hash__(self) -> int:
        return 0

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Content)


@cache
def _group(digest: str, content: _Content, count: int) -> Group:
    """Return the composition of a digest, unpacked once per worker."""
    folder = Path(mkdtemp(prefix=f"feeddrive-{digest[:12]}-"))
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        archive.extractall(folder)
    return _workers()(compose(load_scenario(folder / LOCK), run_earlier), count)


@cache
def _workers() -> Workers:
    workers = Workers()
    atexit.register(workers.close)
    return workers
