"""A scenario beside measured data: columns drive inputs, others are compared.

A column is called as the variable it was measured at: one of an input takes the place
of what drives it, any other is what the model's is compared with, row by row.  Of the
scenario only what the compared signals depend on runs, from the first row on.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fmus.units import UnitError
from orchestrator.errors import FitError, ScenarioError, did_you_mean
from orchestrator.master.layout import kind_of
from orchestrator.master.loaded import Loaded
from orchestrator.master.series import Series
from orchestrator.master.simulate import plan
from orchestrator.quantities.quantity import converter
from orchestrator.scenario.compose import Composition
from orchestrator.signals.columns import Columns, read_columns
from orchestrator.signals.recording import Interpolation, Recording, play
from orchestrator.signals.ticks import rows_of
from orchestrator.system import Component, System, Value, split_name

NAME = "measured"


@dataclass(frozen=True)
class Measured:
    """What is run, and what it is compared with, in the units of the model.

    ``system`` records ``compared``, each (rows,), every ``period`` s; ``driven`` are
    the inputs that columns drive.
    """

    system: System
    period: Fraction
    driven: tuple[str, ...]
    compared: Mapping[str, NDArray[np.float64]]

    @property
    def rows(self) -> int:
        return len(next(iter(self.compared.values())))

    @property
    def time(self) -> NDArray[np.float64]:
        """Return the times of the rows (s) from the first one on."""
        return np.asarray(np.arange(self.rows) * float(self.period), dtype=np.float64)

    @contextmanager
    def series(self) -> Iterator[Series]:
        """Give what runs the system with other values, its FMUs kept loaded."""
        loaded = Loaded()
        try:
            yield Series(plan(self.system), frozenset(self.compared), loaded)
        finally:
            loaded.drop()

    def run(
        self, series: Series, values: Mapping[str, Mapping[str, Value]]
    ) -> dict[str, NDArray[np.float64]]:
        """Return the model's rows of what is compared."""
        found, ended = series.run(values)
        if ended is not None:
            raise FitError(f"a run was {ended}; a fit needs all rows")
        return {name: found[name].values for name in self.compared}


def beside(
    composition: Composition,
    file: Path,
    *,
    rate: Fraction | None = None,
    interpolation: Interpolation = "hold",
) -> Measured:
    """Return a scenario's system with the columns of a file in their places.

    Raises:
        ScenarioError: the file cannot be read, or a column names no variable or has
            another quantity than it.
        FitError: nothing is compared, or the rows are not evenly spaced.
    """
    columns = read_columns(file)
    rows = rows_of(columns, rate)
    if rows.period is None:
        raise FitError(
            f"{file}: its rows are not evenly spaced; resample them, or say rate if "
            f"they only look so"
        )
    driven, compared = _sorted(composition, columns)
    if not compared:
        raise FitError(f"{file}: every column is an input; nothing is to be compared")
    recording = Recording(file.absolute(), None, interpolation, rows.time(0), rate)
    if interpolation == "linear":
        recording = replace(recording, step=_fastest(composition, rows.period))
    played = play(recording)
    source = Component(NAME, played.fmu, played.period)
    system = _driven(composition.system, source if driven else None, driven)
    system = _upstream(system, compared)
    parts = {
        name: _on_rows(component, composition, rows.period)
        if any(c.startswith(f"{name}.") for c in compared)
        else component
        for name, component in system.components.items()
    }
    system = replace(
        system,
        stop=played.last,
        components=parts,
        record={name: (rows.period,) for name in compared},
    )
    values = {name: _in_unit(composition, columns, name) for name in compared}
    return Measured(system, rows.period, driven, values)


def _sorted(
    composition: Composition, columns: Columns
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    driven: list[str] = []
    compared: list[str] = []
    for name in columns.values:
        component, variable = split_name(name)
        parts = composition.system.components
        if component not in parts or not variable:
            remedy = did_you_mean(name, [*parts])
            raise ScenarioError(
                f"{columns.file}: column {name!r} is no component.variable of "
                f"{composition.scenario.name}; {remedy}"
            )
        own = parts[component].map
        theirs = own[variable].name if variable in own else variable
        known = composition.fmus[component].variables
        if theirs not in known:
            raise ScenarioError(
                f"{columns.file}: {component} has no variable {variable!r}; "
                f"{did_you_mean(variable, [*own, *known])}"
            )
        is_input = known[theirs].causality == "input"
        (driven if is_input else compared).append(name)
    return tuple(driven), tuple(compared)


def _fastest(composition: Composition, period: Fraction) -> Fraction:
    return min([period, *(c.period for c in composition.system.components.values())])


def _driven(
    system: System, source: Component | None, driven: tuple[str, ...]
) -> System:
    if source is None:
        return system
    if NAME in system.components:
        raise FitError(f"a component is called {NAME}, which the data take; rename it")
    wires = {name: f"{NAME}.{name}" for name in driven}
    return replace(
        system,
        components={**system.components, NAME: source},
        connections={**system.connections, **wires},
    )


def _upstream(system: System, compared: tuple[str, ...]) -> System:
    """Return the system without what the compared signals do not depend on."""
    needed = {split_name(name)[0] for name in compared}
    while True:
        more = {
            split_name(source)[0]
            for sink, source in system.connections.items()
            if split_name(sink)[0] in needed
        }
        if more <= needed:
            break
        needed |= more
    return replace(
        system,
        components={n: c for n, c in system.components.items() if n in needed},
        connections={
            sink: source
            for sink, source in system.connections.items()
            if split_name(sink)[0] in needed
        },
        faults={s: f for s, f in system.faults.items() if split_name(s)[0] in needed},
    )


def _on_rows(
    component: Component, composition: Composition, period: Fraction
) -> Component:
    """Return a continuous component with a step that meets every row."""
    if kind_of(component, composition.fmus[component.name]) == "sampled":
        return component
    return replace(component, period=period / ceil(period / component.period))


def _in_unit(
    composition: Composition, columns: Columns, name: str
) -> NDArray[np.float64]:
    try:
        convert = converter(columns.units[name], composition.unit(name))
    except UnitError as error:
        raise ScenarioError(f"{columns.file}: {name}: {error}") from None
    return np.asarray(convert(columns.values[name]))
