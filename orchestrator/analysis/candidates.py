"""Candidates of a search, judged in batches: constraints first, then the objective.

A candidate counts by its worst variation.  Margins are looked at with quick shots
(``shots``); only those that keep them are run.  Of two that do not, the one nearer to
keeping them is better (Deb 2000).
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isnan

import numpy as np
from numpy.typing import NDArray

from orchestrator.analysis.fit import Free, assigned
from orchestrator.analysis.members import Group, Job, Outcome, Workers, split
from orchestrator.analysis.shots import Shots
from orchestrator.analysis.variations import Assignment, Axis, grid
from orchestrator.errors import TuneError, did_you_mean
from orchestrator.quantities.quantity import NoValue, Quantity
from orchestrator.response.expected import loop
from orchestrator.scenario.compose import Composition
from orchestrator.system import Value

Real = NDArray[np.float64]
Values = Mapping[str, Mapping[str, Value]]

BAD = 1e9  # times worse than any candidate that keeps the constraints
MOST = 1e6  # of a bound, by which it can be missed; so it is by what has no value


@dataclass(frozen=True)
class Constraint:
    """A figure and the bound it keeps; ``sign`` 1 for >=, -1 for <=."""

    figure: str
    sign: int
    bound: float

    def missed(self, value: float) -> float:
        """Return by how much of the bound a value misses it; 0 if it keeps it.

        What has no value (nan) keeps none.
        """
        short = self.sign * (self.bound - value)
        if isnan(short):
            return MOST
        return max(0.0, min(short / (abs(self.bound) or 1.0), MOST))


def owner_of(figure: str) -> str:
    """Return the metric or response of ``loop.modulus_margin``."""
    return figure.rpartition(".")[0]


def parse_constraint(text: str) -> Constraint:
    """Return what ``loop.modulus_margin >= 0.5`` says.

    Raises:
        TuneError: it is written otherwise.
    """
    found = re.fullmatch(r"\s*([\w.\[\]]+)\s*(>=|<=)\s*([-+.\deE]+)\s*", text)
    try:
        if found is None:
            raise ValueError
        return Constraint(found[1], 1 if found[2] == ">=" else -1, float(found[3]))
    except ValueError:
        raise TuneError(
            f'--subject-to {text!r}: write "loop.modulus_margin >= 0.5"'
        ) from None


@dataclass(frozen=True)
class Judged:
    """One set of values: its objective in the worst variation, and what it misses.

    ``failure`` says which run of it failed or has not the figures, and why.
    """

    objective: float
    missed: float
    worst: Mapping[str, object] = field(default_factory=dict)
    failure: str = ""

    @property
    def rank(self) -> float:
        if self.missed > 0 or not np.isfinite(self.objective):
            return BAD * (1 + min(self.missed, MOST))
        return self.objective


class Judge:
    """Judges candidates in batches: constraints first, then the objective."""

    def __init__(
        self,
        composition: Composition,
        free: Sequence[Free],
        objective: str,
        constraints: Sequence[Constraint],
        over: Sequence[Axis],
        workers: Workers,
    ) -> None:
        self.composition, self._free = composition, tuple(free)
        self._objective, self.constraints = objective, tuple(constraints)
        self.variations: list[Assignment] = list(grid(over)) if over else [{}]
        self._group: Group = workers(composition, 10_000)
        self.evaluations = 0
        spec = composition.scenario.spec
        self._asked = {
            owner: spec.responses[owner]
            for c in constraints
            if (owner := owner_of(c.figure)) in spec.responses
        }
        self.full = {n: loop(composition, s) for n, s in self._asked.items()}
        self._shots = {n: Shots(composition, r) for n, r in self.full.items()}

    def judge(self, candidates: Real, *, run_all: bool = False) -> list[Judged]:
        """Return the judgement of candidates (n, free).

        ``run_all``: also of those that miss a margin the objective is found.
        """
        members = [
            [self._values(x, variation) for variation in self.variations]
            for x in candidates
        ]
        missed = np.zeros((len(members), len(self.variations)))
        flat = [m for of_one in members for m in of_one]
        for name, shots in self._shots.items():
            for i, shot in enumerate(shots.take(flat)):
                for c in self.constraints:
                    owner, _, figure = c.figure.rpartition(".")
                    if owner == name:
                        at = np.unravel_index(i, missed.shape)
                        missed[at] += c.missed(shot.figure(figure))
        keep = [i for i in range(len(members)) if run_all or not np.any(missed[i])]
        self.evaluations += len(flat)
        objectives = np.full(missed.shape, np.inf)
        failures = self._run(members, keep, objectives, missed)
        return [
            self._judged(objectives[i], missed[i], failures.get(i, ""))
            for i in range(len(members))
        ]

    def _run(
        self,
        members: Sequence[Sequence[Values]],
        keep: Sequence[int],
        objectives: Real,
        missed: Real,
    ) -> dict[int, str]:
        width, failures = len(self.variations), {}
        jobs = [Job(i * width + j, members[i][j]) for i in keep for j in range(width)]
        for outcome in self._group.run(jobs):
            at = divmod(outcome.index, width)
            if outcome.failure is not None:
                missed[at] += 10.0
                failures[at[0]] = f"a run failed: {outcome.failure}"
                continue
            asked = self._figures(outcome)
            for c in self._of_runs:
                missed[at] += c.missed(asked[c.figure].value)
            for name, figure in asked.items():
                if isinstance(figure, NoValue):
                    failures[at[0]] = f"{name} has no value: {figure.why}"
            if not isinstance(asked[self._objective], NoValue):
                objectives[at] = asked[self._objective].value
        return failures

    @property
    def _of_runs(self) -> list[Constraint]:
        return [c for c in self.constraints if owner_of(c.figure) not in self._asked]

    def _figures(self, outcome: Outcome) -> dict[str, Quantity]:
        """Return the figures of a run that are asked for.

        Raises:
            TuneError: its metrics have no such figure.
        """
        asked = {self._objective: f"--minimise {self._objective}"}
        asked |= {c.figure: f"--subject-to {c.figure}" for c in self._of_runs}
        for name, where in asked.items():
            if name not in outcome.figures:
                remedy = did_you_mean(name, outcome.figures)
                raise TuneError(f"{where}: no such figure; {remedy}")
        return {name: outcome.figures[name] for name in asked}

    def _judged(self, objectives: Real, missed: Real, failure: str) -> Judged:
        i = int(np.argmax(missed)) if np.any(missed) else int(np.argmax(objectives))
        return Judged(
            float(np.max(objectives)),
            float(np.max(missed)),
            dict(self.variations[i]),
            failure,
        )

    def _values(self, x: Real, variation: Assignment) -> Values:
        values = {
            c: dict(v) for c, v in assigned([f.name for f in self._free], x).items()
        }
        numbers, more = split(self.composition, variation)
        if more:
            raise TuneError(f"--over {more[0]}: is no real number of a component")
        for component, of in numbers.items():
            values.setdefault(component, {}).update(of)
        return values

    def close(self) -> None:
        for shots in self._shots.values():
            shots.close()
