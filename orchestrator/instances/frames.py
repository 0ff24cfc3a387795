"""What the process of an FMU says to its master: frames of JSON, never pickles.

An FMU shares its process and may write whatever it likes into the pipe, so nothing
that comes is believed: a frame is of a known kind and holds a value of that kind's
type, or the process is damaged.
"""

import json
from collections.abc import Sequence
from typing import Any

from orchestrator.errors import FeedDriveError, FmuError, SimulationError
from orchestrator.fmu.description import FmuVariable
from orchestrator.fmu.typed import Held
from orchestrator.instances.ending import Ended
from orchestrator.instances.logs import LogMessage
from orchestrator.result import Result

LARGEST = 64 << 20  # bytes of a frame
TOO_LARGE = 1 << 64  # for a whole number
_ERRORS = {kind.__name__: kind for kind in (FeedDriveError, FmuError, SimulationError)}


class Damaged(Exception):
    """What came is no frame."""


def encode(kind: str, value: Any) -> bytes:
    """Return the frame of a kind.

    From the process of an FMU: begun, done, log or error; from that of a run: warned,
    reached, error or finished.
    """
    if isinstance(value, Ended):
        told: Any = {"by": value.by, "at": value.at, "reason": value.reason}
    elif isinstance(value, FeedDriveError):
        name = type(value).__name__
        told = {"error": name if name in _ERRORS else "SimulationError"}
        told["text"] = str(value)
    elif isinstance(value, LogMessage):
        told = {"status": value.status, "category": value.category}
        told |= {"text": value.text, "time": value.time}
    elif isinstance(value, Result):
        timing = value.timing
        assert timing is not None
        told = [
            [timing.wall_s, timing.instants, timing.simulated_s, timing.executor],
            value.ended and [value.ended.by, value.ended.at, value.ended.reason],
        ]
    elif isinstance(value, list):
        told = [{"hex": v.hex()} if isinstance(v, bytes) else v for v in value]
    else:
        told = value
    return json.dumps([kind, told]).encode()


def decode(data: bytes) -> tuple[str, Any]:
    """Return kind and value of a frame.

    Raises:
        Damaged: it is none.
    """
    try:
        kind, told = json.loads(data)
        return kind, _VALUES[kind](told)
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise Damaged(str(error)) from None


def fit(values: Any, variables: Sequence[FmuVariable]) -> bool:
    """Tell whether values are those of variables, by number and type."""
    kinds = [(str, bytes) if v.is_text else (int, float) for v in variables]
    sizes = [v.size for v in variables]
    wanted = [kind for kind, n in zip(kinds, sizes, strict=True) for _ in range(n)]
    return (
        isinstance(values, list)
        and len(values) == len(wanted)
        and all(map(isinstance, values, wanted))
    )


def _done(told: Any) -> Any:
    if isinstance(told, dict):
        return _ended(told)
    if isinstance(told, list):
        return [_held(value) for value in told]
    if told is None:
        return None
    raise TypeError("neither values nor nothing")


def _held(told: Any) -> Held:
    if isinstance(told, dict):
        return bytes.fromhex(_text(told["hex"]))
    return told if isinstance(told, str) else _number(told)


def _error(told: Any) -> FeedDriveError:
    if "error" in told:
        return _ERRORS[told["error"]](_text(told["text"]))
    return _ended(told)


def _ended(told: Any) -> Ended:
    return Ended(_text(told["by"]), _number(told["at"]), _text(told["reason"]))


def _log(told: Any) -> LogMessage:
    status, category, text = (_text(told[k]) for k in ("status", "category", "text"))
    return LogMessage(status, category, text, _number(told["time"]))


def _finished(told: Any) -> tuple[list[Any], list[Any] | None]:
    (wall, instants, simulated, executor), end = told
    timing = [_number(wall), _number(instants), _number(simulated), _text(executor)]
    if end is not None:
        by, at, reason = end
        end = [_text(by), _number(at), _text(reason)]
    return timing, end


def _nothing(told: Any) -> None:
    if told is not None:
        raise TypeError("something")


def _number(told: Any) -> float:
    if not isinstance(told, float | int):
        raise TypeError("no number")
    if isinstance(told, int) and abs(told) >= TOO_LARGE:
        raise TypeError("no number of FMI")
    return told  # a whole one stays so: it may have 64 bits


def _text(told: Any) -> str:
    if not isinstance(told, str):
        raise TypeError("no text")
    return told


_VALUES = {
    "begun": _nothing,
    "done": _done,
    "error": _error,
    "finished": _finished,
    "log": _log,
    "reached": _text,
    "warned": _text,
}
