"""Dynamic item: reference results that an FMU brings are those it computes.

Simulated by fmpy.  A value is as in the reference if it differs by a thousandth
of the column's range at most; where an event falls, a twentieth of the rows may
instead be like a neighbouring sample.  See ``references`` for what is read.
"""

import csv
from collections.abc import Callable, Iterator
from time import monotonic
from typing import Any

import fmpy
import numpy as np

from orchestrator.checks.archive import Archive
from orchestrator.checks.instance import Row
from orchestrator.checks.item import Finding, NotApplicable, Said, advice, dynamic
from orchestrator.checks.laboratory import Laboratory
from orchestrator.checks.references import CSV, Experiment, File, experiments
from orchestrator.fmu.description import FmuVariable

TOLERANCE = 1e-3  # of a column's range
MOVED = 0.05  # of the rows may be those of a neighbouring sample
LONGEST = 40.0  # s that one experiment may take
TYPES = {"co-simulation": "CoSimulation", "model exchange": "ModelExchange"}
WORDS = {"true": 1.0, "false": 0.0}


@dynamic(
    33,
    "Reference results are those of the FMU",
    "FMI-LS-REF 1.0.0-alpha.1 (roles experiment and result); checklist of fmi-guides",
    "simulate once more and put those results into extra/, with stop time and step "
    "size of the experiment",
    seconds=150.0,
)
def resimulated(lab: Laboratory) -> Iterator[Said]:
    archive = Archive(lab.description.path)
    found = experiments(archive)
    if not found:
        raise NotApplicable("it brings no reference results")
    end = monotonic() + 2 * LONGEST
    for experiment in found:
        if monotonic() > end:
            yield f"{experiment.name}: no time left"
            continue
        try:
            yield from _again(lab, archive, experiment)
        except ValueError as error:
            yield Finding(f"{experiment.name}: {error}")


def _again(lab: Laboratory, fmu: Archive, experiment: Experiment) -> Iterator[Said]:
    file = experiment.references
    if file.type != CSV or file.name not in fmu.names:
        yield f"{experiment.name}: {file.source} is no CSV file here, not compared"
        return
    wanted = _table(fmu, file)
    times = wanted.pop("time")
    variables = lab.description.variables
    compared = [n for n in wanted if n in variables and _is_number(variables[n])]
    lab.trying(f"simulating {experiment.name}")
    default = lab.model.defaultExperiment
    step = experiment.number("stepSize") or lab.description.default_step
    stop = experiment.number("stopTime") or getattr(default, "stopTime", None)
    step = step or float(np.median(np.diff(times)))
    result = fmpy.simulate_fmu(
        str(lab.folder),
        validate=False,
        model_description=lab.model,
        fmi_type=TYPES[lab.kind],
        start_time=experiment.number("startTime"),
        stop_time=float(stop or times[-1]),
        output_interval=step,
        relative_tolerance=experiment.number("tolerance"),
        start_values=_parameters(lab, fmu, experiment.parameters),
        input=_inputs(lab, fmu, experiment.stimuli),
        output=compared,
        timeout=LONGEST,
        step_finished=_going_on(lab),
    )
    rows = times <= result["time"][-1] + 1e-9 * step
    if not rows.any() or not compared:
        yield f"{experiment.name}: nothing to compare"
        return
    finding = Finding if experiment.promised else advice
    for name in compared:
        told = _difference(times[rows], wanted[name][rows], result, name, step)
        if told:
            yield finding(f"{experiment.name}: {name} {told}")
    left = sorted(wanted.keys() - set(compared))
    yield (
        f"{experiment.name}: {len(compared)} columns, {rows.sum()} of {len(rows)} rows"
        + (f", without {', '.join(left)}" if left else "")
    )


def _going_on(lab: Laboratory) -> Callable[[float, Any], bool]:
    def step_finished(time: float, recorder: Any) -> bool:
        lab.beat()
        return True

    return step_finished


def _difference(
    times: Row, wanted: Row, result: Any, name: str, step: float
) -> str | None:
    """Tell how a column differs from the reference, None if it does not."""
    at, values = result["time"], np.asarray(result[name], float)
    known = np.isfinite(wanted)
    times, wanted = times[known], wanted[known]
    size = max(np.ptp(wanted), 1e-3 * np.max(np.abs(wanted), initial=0), 1e-9)
    first = np.searchsorted(at, times - 1.001 * step)
    last = np.searchsorted(at, times + 1.001 * step)
    near = [values[i:j] for i, j in zip(first, last, strict=True)]
    error = np.abs(np.interp(times, at, values) - wanted)
    beyond = np.array(
        [
            max(n.min() - w, w - n.max()) if len(n) else np.inf
            for n, w in zip(near, wanted, strict=True)
        ]
    )
    allowed = TOLERANCE * size
    bad = error > allowed
    if not (beyond > allowed).any() and bad.sum() <= max(1, MOVED * len(bad)):
        return None
    worst = int(np.argmax(error))
    return (
        f"differs from the reference in {bad.sum()} of {len(bad)} rows, most at "
        f"{times[worst]:.6g} s: {np.interp(times[worst], at, values):.6g}, not "
        f"{wanted[worst]:.6g}"
    )


def _table(fmu: Archive, file: File) -> dict[str, Row]:
    """Return the columns of a CSV file, ``time`` among them.

    Raises:
        ValueError: it has no such column, or a cell that is no number.
    """
    text = fmu.content(file.name or "").decode("utf-8-sig")
    rows = [row for row in csv.reader(text.splitlines(), skipinitialspace=True) if row]
    if len(rows) < 3 or rows[0][0].strip() != "time":
        raise ValueError(f"{file.source} has no column time, or less than two rows")
    head = [name.strip() for name in rows[0]]
    if any(len(row) != len(head) for row in rows):
        raise ValueError(f"{file.source} has rows of different length")
    columns = {}
    for name, *cells in zip(*[head, *rows[1:]], strict=True):
        try:
            columns[name] = np.array([_value(cell.strip()) for cell in cells])
        except ValueError:
            if name == "time":
                raise
    return columns


def _value(cell: str) -> float:
    return WORDS[cell] if cell in WORDS else float(cell or "nan")


def _is_number(variable: FmuVariable) -> bool:
    text = variable.sort == "string" or variable.fmi_type in ("Binary", "Clock")
    return not text and not variable.shape


def _typed(variable: FmuVariable) -> type:
    return {"real": float, "boolean": bool}.get(variable.sort, int)


def _inputs(lab: Laboratory, fmu: Archive, file: File | None) -> Any:
    """Return the stimuli as fmpy takes them: a structured array."""
    if file is None:
        return None
    if file.type != CSV or file.name not in fmu.names:
        raise ValueError(f"its stimuli {file.source} are no CSV file in the FMU")
    table = _table(fmu, file)
    inputs = {v.name: v for v in lab.variables(causality="input") if _is_number(v)}
    names = [name for name in table if name in inputs]
    types = [("time", float)] + [(name, _typed(inputs[name])) for name in names]
    array = np.zeros(len(table["time"]), np.dtype(types))
    for name in ("time", *names):
        array[name] = table[name]
    return array


def _parameters(lab: Laboratory, fmu: Archive, file: File | None) -> dict[str, Any]:
    """Return the values of a parameter set (SSP: an SSV file) for our variables."""
    if file is None:
        return {}
    if file.name not in fmu.names:
        raise ValueError(f"its parameters {file.source} are not in the FMU")
    found = {}
    for parameter in fmu.parsed(file.name or "").iter("{*}Parameter"):
        name, values = parameter.get("name"), [e.get("value") for e in parameter]
        variable = lab.description.variables.get(name)
        if variable is not None and _is_number(variable) and values and values[0]:
            found[name] = _typed(variable)(_value(values[0]))
    return found
