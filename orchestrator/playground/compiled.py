"""A page's scenario at every rate and latency: its module, and what the page is told.

A browser gives the bits of ``run`` with the same ``--set``: the same equations, in
plain operations and our own elementary functions, which WebAssembly carries out as any
processor does (docs/decisions/0044).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fmus.cache import cache_folder
from fmus.compile import WEB, compile_alone
from fmus.native_source import adapter_sources
from orchestrator.errors import ScenarioError, SimulationError
from orchestrator.evaluation.metrics import factors
from orchestrator.evaluation.schema import ContourMetric, ErrorMetric, PlainMetric
from orchestrator.master.fused.library import ELEMENTARY, FAULTS, HEADERS, QUIET
from orchestrator.master.layout import Column
from orchestrator.master.simulate import plan
from orchestrator.playground.schema import PageSpec
from orchestrator.playground.source import Variant, text
from orchestrator.quantities.quantity import converter
from orchestrator.quantities.unit import unit_of
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier
from orchestrator.system import split_name

STANDARD = Path(__file__).parent / "native"
# what is carried out once is made small, where a native loop leaves it as it is
SMALL = ("-Doptnone=minsize", "-DW=1", "-isystem", ".", *QUIET)


@dataclass(frozen=True)
class Choice:
    """A rate and a latency, and the composition with them."""

    rate: str
    latency: int
    sets: tuple[str, ...]
    composition: Composition
    variant: Variant


class Playable:
    """The variants of a page's scenario.

    ``rates`` and ``latencies`` restrict them to those that are named.

    Raises:
        FeedDriveError, fmus.build.BuildError: a variant cannot be composed, or its
            timetable cannot be carried out by a page.
    """

    def __init__(
        self,
        spec: PageSpec,
        rates: Sequence[str] | None = None,
        latencies: Sequence[int] | None = None,
    ) -> None:
        self.spec = spec
        self.rates = spec.rate.values if rates is None else tuple(rates)
        every = range(spec.latency.most + 1)
        self.latencies = tuple(every if latencies is None else latencies)
        self.choices = [_choice(spec, r, n) for r in self.rates for n in self.latencies]

    @cached_property
    def module(self) -> bytes:
        """The compiled module.

        Raises:
            CompileError: there is no compiler.
        """
        sources = {"played.c": text([c.variant for c in self.choices])}
        for file in (*HEADERS.glob("*.h"), FAULTS, *STANDARD.glob("*.h")):
            sources[file.name] = file.read_text(encoding="utf-8")
        adapters = adapter_sources()
        sources |= {name: adapters[name] for name in ELEMENTARY}
        folder = cache_folder() / "fused"
        return compile_alone("played", sources, WEB, folder, flags=SMALL).read_bytes()

    def told(self) -> dict[str, Any]:
        """Return what the page has to know, as JSON can hold it."""
        spec, first = self.spec, self.choices[0]
        start = next((i for i, c in enumerate(self.choices) if _starts(spec, c)), 0)
        composition = self.choices[start].composition
        return {
            "scenario": spec.scenario,
            "rates": self.rates,
            "latencies": self.latencies,
            "start": start,
            "variants": [_variant(c) for c in self.choices],
            "components": {n: own.index for n, own in first.variant.own.items()},
            "sliders": [
                {
                    "parameters": [_parameter(composition, n) for n in s.parameters],
                    "label": s.label,
                    "low": s.low,
                    "high": s.high,
                }
                for s in spec.sliders
            ],
            "switches": [_parameter(composition, n) for n in spec.switches],
            "columns": _columns(first.variant),
            "panels": list(_panels(composition)),
        }


def _starts(spec: PageSpec, choice: Choice) -> bool:
    return (choice.rate, choice.latency) == (spec.rate.start, spec.latency.start)


def _choice(spec: PageSpec, rate: str, latency: int) -> Choice:
    sets = [f"{spec.rate.key}={rate}"] * (rate != spec.rate.start)
    if latency != spec.latency.start:
        sets += [f"{name}.latency={latency}" for name in spec.latency.components]
    composition = compose(load_scenario(spec.scenario, sets), run_earlier)
    variant = Variant(plan(composition.system))
    return Choice(rate, latency, tuple(sets), composition, variant)


def _variant(choice: Choice) -> dict[str, Any]:
    """Tell the values of every component before initialisation, rows and times."""
    own = choice.variant.own.values()
    values = []
    for one in own:
        found = np.array(one.equations.start[: one.equations["size"]])
        for variable, given in one.part.start:
            found[variable.reference : variable.reference + variable.size] = given
        if not np.all(np.isfinite(found)):
            raise SimulationError(f"{one.part.name}: a start value is not finite")
        values.append(found.tolist())
    rows = choice.variant.rows()
    if len(rows) != 1:
        raise SimulationError("a page draws rows of one rate: record at one")
    ((period, _),) = choice.variant.wiring.tables.items()
    return {
        "rate": choice.rate,
        "latency": choice.latency,
        "sets": choice.sets,
        "values": values,
        "rows": next(iter(rows.values())),
        "every": [period.numerator, period.denominator],
    }


def _parameter(composition: Composition, name: str) -> dict[str, Any]:
    component, variable = split_name(name)
    described = composition.fmus[component].variables.get(variable)
    if described is None or described.size != 1:
        raise ScenarioError(f"{name} is no parameter with one value")
    value = composition.parameter(name)
    unit = str(value.unit)
    return {
        "name": name,
        "component": component,
        "reference": described.reference,
        "about": described.description,
        "unit": "" if unit == "1" else unit,
        "value": float(value.value),
    }


def _columns(variant: Variant) -> list[dict[str, Any]]:
    (columns,) = variant.columns.values()
    return [_column(column) for column in columns]


def _column(column: Column) -> dict[str, Any]:
    affine = column.affine
    gain, offset = (affine.gain, affine.offset) if affine.converts else (1.0, 0.0)
    return {"name": column.name, "gain": gain, "offset": offset}


def _panels(composition: Composition) -> list[dict[str, Any]]:
    """Tell what is drawn: errors, peaks and contours that the scenario measures."""
    found = []
    for name, metric in composition.scenario.spec.metrics.items():
        if isinstance(metric, ErrorMetric):
            unit, scale = _scale(composition, metric, metric.of, metric.unit)
            of = {"of": metric.of, "against": metric.against, "scale": scale}
            panel = {"kind": "error", "name": name, "unit": unit, **of}
        elif isinstance(metric, ContourMetric) and isinstance(metric.size, float | int):
            unit, scale = _scale(composition, metric, metric.of, metric.unit)
            of = {"of": metric.of, "across": metric.across, "scale": scale}
            shape = {"shape": metric.shape, "size": float(metric.size)}
            panel = {"kind": "contour", "name": name, "unit": unit, **of, **shape}
        elif isinstance(metric, PlainMetric) and metric.kind == "peak":
            unit, scale = _scale(composition, metric, metric.of, metric.unit)
            panel = {"kind": "peak", "name": name, "unit": unit, "of": metric.of}
            panel["scale"] = scale
        else:
            continue
        window = metric.window and [float(end) for end in metric.window]
        found.append(panel | {"window": window})
    return found


def _scale(
    composition: Composition, metric: Any, signal: str, unit: str | None
) -> tuple[str, float]:
    """Return a unit, and by what a recorded number is multiplied to be in it."""
    total = factors(metric, composition.unit(signal), composition.parameter)
    own = unit_of(total.unit)
    wanted = own if unit is None else unit_of(unit).of_difference(own.relative)
    shift, scale = converter(own, wanted)(np.array([0.0, 1.0]) * total.value)
    if shift:
        raise ScenarioError(f"{signal}: a unit with an offset is not drawn in a page")
    return str(wanted), float(scale)
