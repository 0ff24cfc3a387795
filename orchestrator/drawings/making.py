"""Points of the curves of a figure: from runs, sweeps, measured loops, functions.

A ``Maker`` belongs to one study and does everything once: a run that several curves
or figures need, a sweep whose figures several curves show.
"""

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.analysis.sweep import Sweep, sweep
from orchestrator.analysis.variations import Axis as Varied
from orchestrator.drawings.registry import Curve, Mark, Panel
from orchestrator.drawings.spectra import density, rate, spectrum
from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.evaluation.metrics import factor
from orchestrator.outcome import Run
from orchestrator.quantities.quantity import Quantity, converter
from orchestrator.quantities.unit import product_unit, quotient_unit, unit_of
from orchestrator.report.contour import magnification, outline, traced
from orchestrator.reproduction.published import Statement
from orchestrator.reproduction.reference import FigureSpec, Reference, read_reference
from orchestrator.reproduction.reproduce import reproduce
from orchestrator.response.measure import measure
from orchestrator.response.measured import Response
from orchestrator.scenario.compose import compose
from orchestrator.scenario.design import find_function
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run, run_earlier

Array: TypeAlias = NDArray[np.float64]
DESIGN = "design."


class Points(NamedTuple):
    """A curve's name and points (n,) in the units of its axes."""

    name: str
    x: Array
    y: Array
    style: str
    colour: int | None = None
    grey: bool = False


class Shown(NamedTuple):
    """What the source prints at a place: a number, or from ``low`` to ``high``."""

    x: tuple[float, float] | None
    y: tuple[float, float] | None
    text: str


class Maker:
    """Makes the curves of a study's figures; ``folder`` keeps its runs.

    ``known`` has values of rows of ``reference.toml`` that are known already.
    """

    def __init__(
        self, study: Path, folder: Path, known: Mapping[str, float | None] | None = None
    ) -> None:
        self._study = study
        self._folder = folder
        self._known = dict(known or {})
        self._runs: dict[tuple[str, tuple[str, ...]], Run] = {}
        self._sweeps: dict[str, Sweep] = {}
        self._loops: dict[str, Response] = {}
        self._called: dict[str, Mapping[str, Any]] = {}
        self._reference: Reference | None = None

    def curves(self, panel: Panel) -> list[Points]:
        """Return the curves of a panel.

        Raises:
            FeedDriveError: a source does not give what the curve asks for.
        """
        makers = {
            "scenario": self._recorded,
            "vary": self._varied,
            "broken": self._measured,
            "call": self._called_curve,
            "rows": self._of_rows,
            "x_data": self._printed,
        }
        found: list[Points] = []
        for curve in panel.curves:
            if curve.source == "scenario" and curve.show == "contour":
                found += self._contour(curve, panel, bool(found))
                continue
            x, y = makers[curve.source](curve, panel)
            if curve.relative:
                y = y / y[0]
            x, y = _from(curve.x_origin, x), _from(curve.origin, _part(curve, y))
            if curve.power:
                y = np.asarray(y * x**curve.power)
            y = curve.factor * y
            known = np.isfinite(x) & np.isfinite(y)
            if not np.any(known):
                raise ScenarioError(f"{curve.of}: no point of it is a number")
            style = curve.style
            found.append(Points(curve.name, x[known], y[known], style, curve.colour))
        return found

    def shown(self, mark: Mark, panel: Panel) -> Shown:
        """Return what the source prints at a mark, in the units of the axes."""
        places = [(mark.x, panel.x.unit), (mark.y, panel.y.unit)]
        x, y = (None if at is None else self._place(at, unit) for at, unit in places)
        return Shown(x, y, mark.text)

    def _place(self, at: float | str, unit: str) -> tuple[float, float]:
        if not isinstance(at, str):
            return at, at
        row = self._row(at)
        published = row.published
        ends: tuple[float, float]
        if isinstance(published, Statement):
            if published.between is None:
                one = published.below if published.above is None else published.above
                if one is None:
                    raise ScenarioError(f"{at} prints no number to be marked")
                ends = one, one
            else:
                ends = published.between
        elif isinstance(published, float | int):
            ends = published, published
        else:
            raise ScenarioError(f"{at} prints no number to be marked")
        low, high = (Quantity(float(end), row.unit).to(unit).value for end in ends)
        return low, high

    def _row(self, name: str) -> FigureSpec:
        if self._reference is None:
            self._reference = read_reference(self._study / "reference.toml")
        figures = self._reference.figures
        if name not in figures:
            remedy = did_you_mean(name, figures)
            raise ScenarioError(f"no row {name!r} in reference.toml; {remedy}")
        return figures[name]

    def _file(self, curve: Curve) -> str:
        name = str(curve.scenario)
        return name if "/" in name else str(self._study / f"{name}.toml")

    def _run(self, curve: Curve) -> Run:
        key = self._file(curve), curve.set
        if key not in self._runs:
            folder = self._folder / f"{len(self._runs):03d}_{Path(key[0]).stem}"
            scenario = load_scenario(key[0], curve.set)
            self._runs[key] = run(scenario, folder, report=False)
        return self._runs[key]

    def _recorded(self, curve: Curve, panel: Panel) -> tuple[Array, Array]:
        done = self._run(curve)
        if curve.of.startswith(DESIGN):
            over, found = (_designed(done, n) for n in (str(curve.over), curve.of))
            return _in(*over, panel.x.unit), _in(*found, panel.y.unit)
        by = curve.scale, curve.per
        time, y, unit = _signal(done, curve.of, curve.against, *by)
        if curve.over is None:
            x, x_unit = time, "s"
        else:
            _, x, x_unit = _signal(done, curve.over, curve.over_against, *by)
        if curve.window is not None:
            inside = (time >= curve.window[0]) & (time <= curve.window[1])
            time, x, y = time[inside], x[inside], y[inside]
        if curve.show in ("spectrum", "density"):
            x, y = (spectrum if curve.show == "spectrum" else density)(time, y)
            x_unit = "Hz"
        elif curve.show == "rate":
            y, unit = rate(time, y), f"({unit})/s"
        wanted = panel.y.unit
        if curve.show == "density":
            wanted = wanted.removesuffix("/Hz^0.5")
        return _in(x, x_unit, panel.x.unit), _in(y, unit, wanted)

    def _contour(self, curve: Curve, panel: Panel, drawn: bool) -> list[Points]:
        done = self._run(curve)
        paths = [path for path in traced(done, curve.name) if path.metric == curve.of]
        if not paths:
            raise ScenarioError(f"{curve.scenario} has no contour metric {curve.of!r}")
        path, M = paths[0], magnification(paths)
        x, y = (
            foot + M * away for foot, away in zip(path.foot, path.away, strict=True)
        )
        name = f"{curve.name or 'path'}, error × {M:,.0f}"
        found = [Points(name, *self._plane(path.unit, panel, x, y), curve.style)]
        if not drawn:
            edge = self._plane(path.unit, panel, *outline(path))
            found.insert(0, Points("command", *edge, "dashed", grey=True))
        return found

    @staticmethod
    def _plane(unit: Any, panel: Panel, x: Array, y: Array) -> tuple[Array, Array]:
        return _in(x, unit, panel.x.unit), _in(y, unit, panel.y.unit)

    def _varied(self, curve: Curve, panel: Panel) -> tuple[Array, Array]:
        file = self._file(curve)
        key = f"{file} {curve.set} {curve.vary} {curve.values}"
        if key not in self._sweeps:
            axis = Varied(str(curve.vary), curve.values)
            self._sweeps[key] = sweep(file, [axis], sets=curve.set)
        found = self._sweeps[key]
        y = self._column(found, curve.of, panel.y.unit, curve.relative)
        if curve.over is not None:
            return self._column(found, curve.over, panel.x.unit, False), y
        values = [row[str(curve.vary)] for row in found.rows]
        return np.array(values, dtype=float), y

    @staticmethod
    def _column(found: Sweep, name: str, unit: str, as_it_is: bool) -> Array:
        if name not in found.units:
            remedy = did_you_mean(name, found.units)
            raise ScenarioError(f"{found.scenario} has no {name!r}; {remedy}")
        values = [row.get(name) for row in found.rows]
        column = np.array([np.nan if v is None else v for v in values], dtype=float)
        if as_it_is or unit == "dB":
            return column
        return _in(column, found.units[name], unit)

    def _measured(self, curve: Curve, panel: Panel) -> tuple[Array, Array]:
        file = self._file(curve)
        key = f"{file} {curve.set} {curve.broken} {curve.lowest}"
        if key not in self._loops:
            composition = compose(load_scenario(file, curve.set), run_earlier)
            broken = str(curve.broken).split()
            lowest = Fraction(curve.lowest)
            self._loops[key] = measure(composition, broken, lowest=lowest, quick=True)
        found = self._loops[key]
        matrices: Mapping[str, Any] = {"L": found.L, "S": found.S, "T": found.T}
        if curve.of not in matrices:
            raise ScenarioError(f"of = {curve.of!r}: a measured loop has L, S and T")
        if len(found.breaks) == 1:
            y = matrices[curve.of][:, 0, 0]
            return (y.real if curve.over else found.hz), y
        singular = np.linalg.svd(matrices[curve.of], compute_uv=False)
        return found.hz, np.asarray(singular[:, 0], dtype=float)

    def _called_curve(self, curve: Curve, panel: Panel) -> tuple[Array, Array]:
        call = str(curve.call)
        key = f"{call} {sorted(curve.arguments.items())}"
        if key not in self._called:
            try:
                self._called[key] = find_function(call)(**curve.arguments)
            except (LookupError, TypeError, ValueError) as error:
                raise ScenarioError(f"{call} failed: {error}") from error
        found = self._called[key]
        names = (curve.over or next(iter(found)), curve.of)
        for name in names:
            if name not in found:
                raise ScenarioError(f"{call} gives no {name!r}; {', '.join(found)}")
        x, y = (np.asarray(found[name]) for name in names)
        return np.asarray(np.real(x), dtype=float), y

    def _of_rows(self, curve: Curve, panel: Panel) -> tuple[Array, Array]:
        rows = [self._row(name) for name in curve.rows]
        values = [
            self._place(row.id, row.unit)[0] if curve.published else self._value(row)
            for row in rows
        ]
        y = [
            np.nan
            if v is None
            else v
            if curve.factor != 1  # which makes another quantity of it
            else Quantity(v, row.unit).to(panel.y.unit).value
            for row, v in zip(rows, values, strict=True)
        ]
        return np.array(curve.at, dtype=float), np.array(y, dtype=float)

    def _value(self, row: FigureSpec) -> float | None:
        if row.id not in self._known:
            folder = self._folder / f"row_{len(self._known):03d}"
            done = reproduce(self._study, row.id, folder=folder)
            self._known |= {figure.spec.id: figure.value for figure in done.figures}
        return self._known[row.id]

    @staticmethod
    def _printed(curve: Curve, panel: Panel) -> tuple[Array, Array]:
        return np.array(curve.x_data, float), np.array(curve.y_data, float)


def _signal(
    done: Run, of: str, against: str | None, scale: float | str, per: float | str
) -> tuple[Array, Array, str]:
    """Return time, values, and their unit, of a signal less another."""
    for name in filter(None, (of, against)):
        if name not in done:
            remedy = did_you_mean(name, list(done))
            raise ScenarioError(
                f"{done.scenario.name}: {name} is not recorded; {remedy}"
            )
    signal = done[of]
    values = signal.values
    if against is not None:
        other = done[against]
        if len(other) != len(signal):
            raise ScenarioError(f"{of} and {against} are recorded at two rates")
        values = values - _in(other.values, other.unit, signal.unit)
    times, by = (factor(f, done.composition.parameter) for f in (scale, per))
    unit = str(quotient_unit(product_unit(signal.unit, times.unit), by.unit))
    return signal.time, values * times.value / by.value, unit


def _designed(done: Run, name: str) -> tuple[Array, str]:
    """Return an array that a design step has found, ``design.<step>.<name>``."""
    step, _, field = name.removeprefix(DESIGN).partition(".")
    composition = done.composition
    found = composition.designs.get(step)
    if not name.startswith(DESIGN) or found is None or field not in found.values:
        raise ScenarioError(f"{done.scenario.name}: no design step gives {name!r}")
    component = composition.scenario.spec.design[step].sets[0]
    unit = str(composition.unit(f"{component}.{field}"))
    return np.asarray(found.values[field], dtype=float), unit


def _from(origin: str | None, values: Array) -> Array:
    if origin is None:
        return values
    zero = values[0] if origin == "first" else values[-1]
    return np.asarray(zero - values if origin == "left" else values - zero)


def _in(values: Array, unit: Any, wanted: str) -> Array:
    own = unit_of(unit)
    return np.asarray(
        converter(own, unit_of(wanted).of_difference(own.relative))(values)
    )


def _part(curve: Curve, y: NDArray[Any]) -> Array:
    match curve.part:
        case "magnitude":
            y = np.abs(y)
        case "db":
            y = 20 * np.log10(np.abs(y))
        case "phase":
            y = np.degrees(np.unwrap(np.angle(y)))
            y = y - 360 * np.round(y[0] / 360)
        case "real":
            y = np.real(y)
        case "imag":
            y = np.imag(y)
    if np.iscomplexobj(y):
        raise ScenarioError(f"{curve.of} is complex: say which part of it")
    return np.asarray(y, dtype=float)
