"""Offline design steps: plain functions that compute parameters before a run.

A step calls ``module:function`` with its arguments and gets a mapping, a named
tuple or a record of parameters.  An argument ``component.parameter`` is read
from the scenario as it stands in its file, not as ``--set`` changed that
component: what a design is told changes by ``--set design.<step>.<argument>``.
Steps run in the order of writing; a later one sees what an earlier one found.
``signals`` of an earlier run are arrays (n,); with them comes their ``T_s`` (s).
"""

import importlib
import inspect
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, is_dataclass
from typing import Any, TypeAlias

import numpy as np

from fmus.allowed import refusal as not_allowed
from fmus.model import is_record, leaves
from fmus.own import OWN_PACKAGES, at_home
from orchestrator.errors import DesignError, FeedDriveError, did_you_mean
from orchestrator.result import Signal
from orchestrator.scenario.design_cache import OURS, remembered
from orchestrator.scenario.moved import refusal
from orchestrator.scenario.schema import DesignSpec
from orchestrator.scenario.written import in_floats, parse_value
from orchestrator.system import Value

Lookup: TypeAlias = Callable[[str], Value]
Earlier: TypeAlias = Callable[[str], Mapping[str, Signal]]


@dataclass(frozen=True)
class DesignResult:
    """What a step was told and what it found."""

    call: str
    arguments: Mapping[str, Any]
    values: Mapping[str, Value]


def run_step(
    where: str, step: DesignSpec, lookup: Lookup, earlier: Earlier
) -> DesignResult:
    """Carry out one design step, which stands ``where`` in the scenario.

    ``lookup`` returns the value of a ``component.parameter``; ``earlier`` the
    recorded signals of a scenario that is run first.

    Raises:
        DesignError: the function is missing, refuses its arguments or returns
            no finite parameters; the message names the step.
    """
    try:
        told = {k: _argument(v, lookup) for k, v in step.arguments.items()}
        given = dict(told)
        if step.from_run is not None:
            given |= _signals(step, earlier(step.from_run))
        values = remembered(
            step.call, given, lambda: call(find_function(step.call), given)
        )
    except DesignError as error:
        raise DesignError(f"{where}: {error}") from None
    except FeedDriveError as error:
        raise type(error)(f"{where}: {error}") from None
    return DesignResult(step.call, told, values)


def find_function(call: str) -> Callable[..., Any]:
    """Return the function that ``module:function`` names.

    Raises:
        DesignError: there is no such module or function.
    """
    module_name, _, function_name = call.partition(":")
    if why := refusal(module_name) or not_allowed(module_name):
        raise DesignError(f"call = {call!r}: {why}")
    try:
        with at_home():
            module = importlib.import_module(module_name)
    except ImportError as error:
        raise DesignError(f"call = {call!r}: cannot import it ({error})") from None
    function = getattr(module, function_name, None)
    if not callable(function):
        public = [n for n, f in vars(module).items() if callable(f) and n[0] != "_"]
        remedy = did_you_mean(function_name, public)
        raise DesignError(f"call = {call!r}: no such function; {remedy}")
    defined = f"{getattr(function, '__module__', '')}."
    if module_name.partition(".")[0] in OWN_PACKAGES and not defined.startswith(OURS):
        raise DesignError(f"call = {call!r}: no design function; those are of {OURS}")
    found: Callable[..., Any] = function
    return found


def call(
    function: Callable[..., Any], arguments: Mapping[str, Any]
) -> dict[str, Value]:
    """Return the parameters a design function finds, by name.

    Raises:
        DesignError: wrong arguments, a failure inside, a value that is not finite.
    """
    signature = inspect.signature(function)
    try:
        signature.bind(**arguments)
    except TypeError as error:
        unknown = [a for a in arguments if a not in signature.parameters]
        remedies = [did_you_mean(a, signature.parameters) for a in unknown]
        takes = f"it takes {', '.join(signature.parameters)}"
        raise DesignError(f"{error}; {' '.join(remedies) or takes}") from None
    try:
        with at_home():
            returned = function(**arguments)
    except FeedDriveError:
        raise
    except Exception as error:
        raise DesignError(
            f"{function.__name__} failed: {type(error).__name__}: {error}"
        ) from error
    return _parameters(function.__name__, returned)


def _parameters(name: str, returned: Any) -> dict[str, Value]:
    if isinstance(returned, Mapping):
        pairs = dict(returned)
    elif is_record(returned):
        pairs = _of_record(returned)
    elif is_dataclass(returned) and not isinstance(returned, type):
        pairs = asdict(returned)
    else:
        raise DesignError(
            f"{name} returned {type(returned).__name__}, not a mapping or record"
        )
    values = {}
    for key, value in pairs.items():
        plain = value.tolist() if isinstance(value, np.generic | np.ndarray) else value
        try:
            values[str(key)] = parse_value(list(plain) if _is_row(plain) else plain)
        except ValueError as error:
            raise DesignError(f"{name} returned {key} = {value}: {error}") from None
    return values


def _is_row(value: Any) -> bool:
    return isinstance(value, tuple)


def _of_record(record: Any) -> dict[str, Any]:
    try:
        return {leaf.name: leaf.value for leaf in leaves(record)}
    except TypeError:  # a plain named tuple, without units
        return dict(record._asdict())


def _argument(value: Any, lookup: Lookup) -> Any:
    if isinstance(value, str) and "." in value:
        value = in_floats(lookup(value))
    return np.array(value) if isinstance(value, tuple) else value


def _signals(step: DesignSpec, recorded: Mapping[str, Signal]) -> dict[str, Any]:
    taken = {}
    for argument, name in step.signals.items():
        if name not in recorded:
            remedy = did_you_mean(name, recorded)
            raise DesignError(f"{step.from_run} does not record {name}; {remedy}")
        taken[argument] = recorded[name]
    first = next(iter(taken.values()))
    for signal in taken.values():
        if not np.array_equal(signal.time, first.time):
            raise DesignError(
                f"{first.name} and {signal.name} of {step.from_run} were recorded "
                f"at different times; record them at one rate"
            )
    if len(first) < 2:
        raise DesignError(f"{step.from_run} recorded fewer than two rows")
    T_s = float(first.time[-1] - first.time[0]) / (len(first) - 1)
    return {"T_s": T_s} | {k: np.asarray(s.values) for k, s in taken.items()}
