"""The state of an FMU as bytes, wherever its instance runs."""

from orchestrator.instances.instance import LocalInstance
from orchestrator.instances.isolated import IsolatedInstance
from orchestrator.instances.protocol import Instance
from orchestrator.instances.state import restore_here, save_here


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
