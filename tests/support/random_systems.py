"""Random systems of test models, and every published scenario by name."""

from fractions import Fraction
from functools import cache
from pathlib import Path

from hypothesis import strategies as st
from systems import part

from orchestrator.scenario.reading import scenarios, studies
from orchestrator.system import Component, Mapped, System

PERIODS = ["1/1000", "1/1500", "1/400"]
TICK = Fraction(1, 6000)
OUTPUTS = {
    "counter": {"1": ["k", "seen"], "1/s": ["rate"]},
    "memory": {"1": ["y"], "1/s": []},
    "integrator": {"1": ["y"], "1/s": ["z"]},
}
UNIT = {"counter": "1", "memory": "1", "integrator": "1/s"}


@cache
def fmu(model: str, period: str, fmi: int) -> Path:
    return part("c", model, period, fmi=fmi).fmu


gains = st.sampled_from([1.0, -1.0, 0.3, 1e-3])
offsets = st.sampled_from([0.0, 0.1])


@st.composite
def components(draw: st.DrawFn, name: str) -> tuple[str, Component]:
    model = draw(st.sampled_from(list(OUTPUTS)))
    period = draw(st.sampled_from(PERIODS))
    file = fmu(model, period, draw(st.sampled_from([2, 3])))
    mapped = Mapped("u", draw(gains), draw(offsets))
    later = draw(st.integers(0, 3)) * TICK
    latency = 0 if model == "integrator" else draw(st.integers(0, 2))
    component = Component(
        name, file, Fraction(period), later, latency, map={"u": mapped}
    )
    return model, component


@st.composite
def systems(draw: st.DrawFn) -> System:
    made = [draw(components(name)) for name in "abcde"[: draw(st.integers(1, 5))]]
    connections, record = {}, {}
    for model, component in made:
        sources = [
            f"{source.name}.{output}"
            for other, source in made
            for output in OUTPUTS[other][UNIT[model]]
        ]
        if sources and draw(st.booleans()):
            connections[f"{component.name}.u"] = draw(st.sampled_from(sources))
        for outputs in OUTPUTS[model].values():
            for output in outputs:
                row = Fraction(draw(st.sampled_from([*PERIODS, "1/6000"])))
                record[f"{component.name}.{output}"] = (row,)
    stop = draw(st.integers(0, 400)) * TICK
    return System("random", stop, {c.name: c for _, c in made}, connections, record)


SCENARIOS = sorted(
    f"{folder.name}/{name}" for folder in studies() for name in scenarios(folder)
)


def row(system: System) -> Fraction:
    """Return a period after which every component can stop."""
    return max(c.period for c in system.components.values())
