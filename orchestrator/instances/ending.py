"""How an FMU ends a run, which is an outcome and not a failure.

By discarding a step and saying that it has terminated, or how far the step went
(FMI 2.0); by ``terminateSimulation`` or an early return (FMI 3.0); by an event that
asks for it (model exchange).
"""

import ctypes
from math import isnan, nan
from typing import Any

from orchestrator.errors import SimulationError

WHOLE = 1e-9  # of a step, by which a step that is whole may fall short
_OK, _LAST_TIME, _TERMINATED = 0, 2, 3  # fmi2OK, fmi2LastSuccessfulTime, fmi2Terminated


class Ended(SimulationError):
    """An FMU ended the run: which, at what time (s), and how it said so."""

    def __init__(self, by: str, at: float, reason: str) -> None:
        super().__init__(f"{by} ended the run at t = {at:.9g} s: {reason}")
        self.by, self.at, self.reason = by, at, reason


def discarded(instance: Any, t: float, h: float) -> tuple[float, str] | None:
    """Return when and why an FMU ended a run by discarding a step from t to t + h.

    None if it says neither that it has terminated nor how far it came.
    """
    if instance.description.fmi_major == 3:
        reached = float(instance.outcome.reached)
        if instance.outcome.ended:
            return reached, "it discarded a step and asked to end the simulation"
        if t <= reached < t + h:
            return reached, f"it discarded a step of {h:.9g} s"
        return None
    library, slave = instance.library, instance.slave
    if not instance.description.co_simulation:
        return None
    last, over = ctypes.c_double(nan), ctypes.c_int(0)
    for name, kind, value in (
        ("fmi2GetRealStatus", _LAST_TIME, last),
        ("fmi2GetBooleanStatus", _TERMINATED, over),
    ):
        function = getattr(library, name)
        function.restype = ctypes.c_int
        if function(slave, ctypes.c_int(kind), ctypes.byref(value)) != _OK:
            value.value = nan if value is last else 0
    known = not isnan(last.value) and t <= last.value <= t + h
    if over.value:
        at = last.value if known else t
        return at, "it discarded a step and said that it has terminated"
    return (last.value, f"it discarded a step of {h:.9g} s") if known else None
