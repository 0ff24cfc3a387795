"""An FMU into this process, by the interface it has."""

from collections.abc import Callable
from pathlib import Path

from orchestrator.fmu.description import FmuDescription
from orchestrator.instances.instance import LocalInstance
from orchestrator.instances.logs import LogMessage


def load(
    name: str,
    description: FmuDescription,
    folder: Path,
    log: Callable[[str, LogMessage], None],
    *,
    clocks: bool = False,
) -> LocalInstance:
    """Load an FMU into this process, to be ticked by its clock if it has one.

    Raises:
        FmuError: its library cannot be loaded here.
    """
    if clocks and description.co_simulation and description.clock is not None:
        from orchestrator.instances.clocked import ClockedInstance

        return ClockedInstance(name, description, folder, log)
    if description.co_simulation:
        return LocalInstance(name, description, folder, log)
    from orchestrator.instances.model_exchange import ModelExchangeInstance

    return ModelExchangeInstance(name, description, folder, log)
