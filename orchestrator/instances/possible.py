"""Whether this process may start one for an FMU, of the kind that is asked for."""

import multiprocessing as mp
from pathlib import Path

from orchestrator.errors import SimulationError
from orchestrator.instances.sandbox import why_not
from orchestrator.system import Isolation


def refuse_impossible(name: str, fmu: Path, isolation: Isolation) -> None:
    """Refuse, by SimulationError, a process that cannot be started or fenced in."""
    if mp.current_process().daemon:
        raise SimulationError(
            f"{name} ({fmu.name}): this process is a daemon (of "
            f"multiprocessing.Pool?) and may not start one for the FMU; use "
            f"concurrent.futures.ProcessPoolExecutor, or isolation = 'none'"
        )
    if isolation.sandbox and (why := why_not()):
        raise SimulationError(
            f'{name} ({fmu.name}): isolation = "sandbox": {why}; run it elsewhere, or '
            f'without a sandbox as isolation = "process"'
        )
