"""The state of an FMU, wherever its instance runs: as bytes, or kept in the FMU."""

from typing import Any

from orchestrator.instances.instance import LocalInstance
from orchestrator.instances.isolated import IsolatedInstance
from orchestrator.instances.protocol import Instance
from orchestrator.instances.state import (
    back_here,
    drop_here,
    keep_here,
    restore_here,
    save_here,
)


def save(instance: Instance) -> bytes:
    """Return the state of an initialised instance, all inputs set that were pushed.

    Raises:
        SimulationError: the FMU refuses, or its process is damaged.
    """
    if isinstance(instance, IsolatedInstance):
        answer = instance.ask("save")
        if not (isinstance(answer, list) and [type(a) for a in answer] == [bytes]):
            raise instance.damaged("save")
        return bytes(answer[0])
    assert isinstance(instance, LocalInstance)
    return save_here(instance)


def restore(instance: Instance, state: bytes) -> None:
    """Bring an initialised instance into a state that was saved.

    Raises:
        SimulationError: the FMU refuses.
    """
    if isinstance(instance, IsolatedInstance):
        instance.ask("restore", state)
        return
    assert isinstance(instance, LocalInstance)
    restore_here(instance, state)


class Kept:
    """The state of an initialised instance, one of each at a time, inside the FMU.

    From then on the FMU is told that its steps may be taken back.

    Raises:
        SimulationError: the FMU refuses, or its process is damaged.
    """

    def __init__(self, instance: Instance) -> None:
        self._instance, self._state = instance, _kept(instance)

    def back(self) -> None:
        """Bring the instance back to it."""
        if isinstance(self._instance, IsolatedInstance):
            self._instance.ask("back")
        else:
            assert isinstance(self._instance, LocalInstance)
            back_here(self._instance, self._state)

    def drop(self) -> None:
        """Let the FMU forget it."""
        if isinstance(self._instance, IsolatedInstance):
            self._instance.ask("drop")
        else:
            assert isinstance(self._instance, LocalInstance)
            drop_here(self._instance, self._state)


def _kept(instance: Instance) -> Any:
    if isinstance(instance, IsolatedInstance):
        instance.do_step = None  # through the pipe, where a step may be taken back
        return instance.ask("keep")
    assert isinstance(instance, LocalInstance)
    return keep_here(instance)
