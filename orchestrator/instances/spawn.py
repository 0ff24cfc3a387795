"""Starting a child process that has nothing of the caller's but its arguments."""

import multiprocessing as mp
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from threading import Lock
from types import ModuleType
from typing import Any

from fmus.own import HOME, found_elsewhere
from orchestrator.instances.descendants import marked

_ONE = Lock()  # what a child inherits is changed for the whole process


def spawn(mark: str, target: Callable[..., None], *arguments: Any) -> Any:
    """Start a process that neither runs the caller's script nor sees Ctrl-C.

    It and what it starts have a mark (``descendants``).
    """
    with _ONE, _without_main(), _without_interrupts(), _at_home(), marked(mark):
        context = mp.get_context("spawn")
        child = context.Process(target=target, args=arguments, daemon=True)
        child.start()
    return child


def stand_alone() -> None:
    """Make this process, which was spawned, independent of the caller's."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the caller's
    if hasattr(os, "setpgid"):  # with tools it starts, so that all end together
        os.setpgid(0, 0)
    with suppress(OSError):  # stdout is the caller's, say for --json
        sys.stdout.flush()
        os.dup2(2, 1)
    tracker: Any = getattr(resource_tracker, "_resource_tracker", None)
    if getattr(tracker, "_fd", None) is not None:  # which serves the caller's tree
        os.close(tracker._fd)
        tracker._fd = None


@contextmanager
def _at_home() -> Iterator[None]:
    """Let the child, which gets our path, find this package before another."""
    if not (found_elsewhere("orchestrator") or found_elsewhere("fmus")):
        yield
        return
    sys.path.insert(0, str(HOME))
    try:
        yield
    finally:
        sys.path.remove(str(HOME))


@contextmanager
def _without_main() -> Iterator[None]:
    """Hide the caller's script, which a child would run again on import."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Block SIGINT; a child inherits that until it can ignore the signal."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
