"""A lag under a gain, as files, and the same with the lag as an FMU of others."""

from dataclasses import replace
from pathlib import Path
from zipfile import ZipFile

from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

LAG = """
from typing import Annotated, NamedTuple
from fmus.model import Continuous, Var

class State(NamedTuple):
    y: Annotated[float, Var("1", "output")] = 0.0

class Input(NamedTuple):
    u: Annotated[float, Var("1", "input")] = 0.0

class Output(NamedTuple):
    y: Annotated[float, Var("1", "output")]

class Parameters(NamedTuple):
    T: Annotated[float, Var("s", "time constant")] = 0.01

def derivative(x, u, p):
    return State((u.u - x.y) / p.T)

def output(x, u, p):
    return Output(x.y)

model = Continuous("Lag", derivative, output, State(), Input(), Parameters())
"""
GAIN = """
from typing import Annotated, NamedTuple
from fmus.model import Sampled, Var

class State(NamedTuple):
    k: Annotated[float, Var("1", "tick")] = 0.0

class Input(NamedTuple):
    y: Annotated[float, Var("1", "measured")] = 0.0

class Output(NamedTuple):
    u: Annotated[float, Var("1", "control signal")]

class Parameters(NamedTuple):
    K: Annotated[float, Var("1", "gain")] = 1.0

def step(x, u, p, T_s):
    return State(x.k + 1), Output(-p.K * u.y)

model = Sampled("Gain", step, State(), Input(), Parameters())
"""
LOOP = """
title = "lag under a gain"
stop = "1/10"
[components.plant]
fmu = "lag.py"
step = "1/1000"
[components.controller]
fmu = "gain.py"
step = "1/1000"
[connections]
"plant.u" = "controller.u"
"controller.y" = "plant.y"
[record]
"plant.y" = true
"""


def lag_loop(folder: Path, *sets: str) -> Composition:
    """Return the loop, L = K / (1 + T s), sampled at 1 kHz, with ``--set``."""
    for name, text in (("lag.py", LAG), ("gain.py", GAIN), ("loop.toml", LOOP)):
        (folder / name).write_text(text)
    return compose(load_scenario(folder / "loop.toml", sets), run_earlier)


def of_others(composition: Composition, name: str, folder: Path) -> Composition:
    """Return it with a component as an FMU whose equations are not known here."""
    part = composition.system.components[name]
    copy = folder / "theirs.fmu"
    copy.write_bytes(part.fmu.read_bytes())
    with ZipFile(copy, "a") as archive:
        archive.comment = b"theirs"
    parts = {**composition.system.components, name: replace(part, fmu=copy)}
    return replace(
        composition,
        system=replace(composition.system, components=parts),
        sources={**composition.sources, name: copy.name},
    )
