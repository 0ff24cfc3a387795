"""Gains that minimise a figure: differential evolution over lanes, then a polish.

A generation is one batch of candidates (``candidates``).  What is found is measured
in full; if it misses a bound by the quick look's error, the bound is tightened by
that and the polish repeated.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from orchestrator.analysis.candidates import Constraint, Judge, Judged, owner_of
from orchestrator.analysis.fit import Free
from orchestrator.analysis.heir import write_heir
from orchestrator.analysis.members import Workers, numbers, refuse_driven
from orchestrator.analysis.variations import Assignment, Axis, Setting
from orchestrator.errors import TuneError, did_you_mean
from orchestrator.response.expected import loop
from orchestrator.response.figures import figures as response_figures
from orchestrator.response.measured import Response
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.responses import FIGURES

Real = NDArray[np.float64]

POPULATION = 8  # candidates per free value, at least 24 in all
GENERATIONS = 40
ALIKE = 1e-3  # spread of a population's objectives at which it has converged
POLISH, BATCH = 16, 16  # batches of a polish, and how many candidates each has
REACH, CLOSE = 0.03, 1e-4  # of a bracket: its first step, and its last
ROUNDS = 4  # of tightening a bound that a full measurement finds missed


@dataclass(frozen=True)
class Tuned:
    """The values found (n,), before and after, and how many runs it took."""

    free: tuple[Free, ...]
    values: Real
    start: Judged
    found: Judged
    margins: Mapping[str, tuple[float, float]]
    responses: tuple[Mapping[str, Response], Mapping[str, Response]]
    evaluations: int

    def best(self) -> dict[str, float]:
        return {f.name: float(v) for f, v in zip(self.free, self.values, strict=True)}


Progress = Callable[[int, Real, Judged], None]
Recompose = Callable[[Mapping[str, Setting]], Composition]


def tune(
    composition: Composition,
    free: Sequence[Free],
    objective: str,
    constraints: Sequence[Constraint] = (),
    over: Sequence[Axis] = (),
    *,
    begin: Mapping[str, float] | None = None,
    seed: int = 1,
    generations: int = GENERATIONS,
    recompose: Recompose,
    progress: Progress = lambda generation, x, judged: None,
) -> Tuned:
    """Find values of ``free`` that make ``objective`` least and keep ``constraints``.

    ``begin`` are values to begin with, of all that is free or of some;
    ``progress`` is told the best so far after each generation; ``recompose`` gives
    the composition with values, which is measured in full at the end.

    Raises:
        TuneError: unknown figures, what is free is varied too, or no candidate keeps
            the constraints.
    """
    _refuse_unknown(composition, objective, constraints)
    _refuse_free_and_varied(composition, free, over)
    workers = Workers()
    judge = Judge(composition, free, objective, constraints, over, workers)
    try:
        start = judge.judge(np.array([[f.start for f in free]]), run_all=True)[0]
        first = np.array([(begin or {}).get(f.name, f.start) for f in free])
        known = first if begin else None
        x = _evolved(judge, free, known, seed, generations, progress)
        for _ in range(ROUNDS):
            x = _polished(judge, free, x, seed)
            after = _measured(judge, recompose, free, x)
            pairs = list(zip(constraints, judge.constraints, strict=True))
            tighter = tuple(_tightened(*pair, after) for pair in pairs)
            if tighter == judge.constraints:
                break
            judge.constraints = tighter
        found = judge.judge(x[None])[0]
        if found.missed > 0 or not np.isfinite(found.objective):
            bounds = " and ".join(c.figure for c in constraints) or "a finite figure"
            why = f"; {found.failure}" if found.failure else ""
            raise TuneError(
                f"no candidate keeps {bounds} in every variation; widen --bounds or "
                f"lower a bound{why}"
            )
        _refuse_missed(constraints, judge.variations, after)
        nominal = _full(judge, recompose, _named(free, x))
        margins = {
            key: (q.value, response_figures(name, nominal[name])[key].value)
            for name, one in judge.full.items()
            for key, q in response_figures(name, one).items()
        }
        return Tuned(
            tuple(free),
            x,
            start,
            found,
            margins,
            (judge.full, nominal),
            judge.evaluations,
        )
    finally:
        judge.close()
        workers.close()


def _refuse_unknown(
    composition: Composition, objective: str, constraints: Sequence[Constraint]
) -> None:
    spec = composition.scenario.spec
    owner = owner_of(objective)
    if owner not in spec.metrics:
        raise TuneError(
            f"--minimise {objective}: no such metric; "
            f"{did_you_mean(owner, spec.metrics)}"
        )
    for c in constraints:
        owner, _, figure = c.figure.rpartition(".")
        if owner in spec.responses and not spec.responses[owner].breaks:
            raise TuneError(
                f"--subject-to {c.figure}: responses.{owner} breaks no loop; bounds "
                f"are kept on metrics and on the margins of loops"
            )
        if owner in spec.responses and figure not in FIGURES:
            remedy = did_you_mean(figure, FIGURES)
            raise TuneError(f"--subject-to {c.figure}: no such figure; {remedy}")
        if owner not in spec.responses and owner not in spec.metrics:
            known = did_you_mean(owner, {*spec.metrics, *spec.responses})
            raise TuneError(
                f"--subject-to {c.figure}: neither a metric nor one of [responses]; "
                f"{known}"
            )


def _refuse_free_and_varied(
    composition: Composition, free: Sequence[Free], over: Sequence[Axis]
) -> None:
    refuse_driven(composition, "--over", (axis.key for axis in over))
    for axis in over:
        varied = numbers(composition, axis.key)
        for one in free:
            if one.name == axis.key or varied & numbers(composition, one.name):
                raise TuneError(
                    f"--over {axis.key}: is free too, so that every candidate would "
                    f"be run with the varied value; leave {axis.key} out of one"
                )


class Space:
    """Brackets as [0, 1] each: in ratios where one is positive, else in differences."""

    def __init__(self, free: Sequence[Free]) -> None:
        self._low, self._high = np.array([f.bracket for f in free]).T
        self._ratio = self._low > 0

    def values(self, u: Real) -> Real:
        """Return the values at places u (..., n)."""
        low, high = np.where(self._ratio, (self._low, self._high), 1.0)
        even = self._low + (self._high - self._low) * u
        return np.asarray(np.where(self._ratio, low * (high / low) ** u, even))

    def places(self, x: Real) -> Real:
        """Return the places of values x (n,)."""
        low, high, at = np.where(
            self._ratio, (self._low, self._high, x), [[1], [2], [1]]
        )
        even = (x - self._low) / (self._high - self._low)
        return np.asarray(
            np.where(self._ratio, np.log(at / low) / np.log(high / low), even)
        )


def _evolved(
    judge: Judge,
    free: Sequence[Free],
    begin: Real | None,
    seed: int,
    generations: int,
    progress: Progress,
) -> Real:
    from scipy.optimize import differential_evolution

    space, generation = Space(free), 0
    best: list[tuple[float, Real, Judged]] = []

    def objective(u: Real) -> Real:
        nonlocal generation, best
        candidates = space.values(u.T)
        judged = judge.judge(candidates)
        ranks = np.array([j.rank for j in judged])
        i = int(np.argmin(ranks))
        if not best or ranks[i] < best[0][0]:
            best = [(float(ranks[i]), candidates[i], judged[i])]
        progress(generation, best[0][1], best[0][2])
        generation += 1
        return ranks

    n = len(free)
    differential_evolution(
        objective,
        [(0.0, 1.0)] * n,
        vectorized=True,
        updating="deferred",
        seed=seed,
        popsize=max(POPULATION, -(-24 // n)),
        maxiter=generations,
        tol=ALIKE,
        polish=False,
        init="sobol",
        x0=None if begin is None else space.places(begin).clip(0, 1),
    )
    return best[0][1]


def _polished(judge: Judge, free: Sequence[Free], x: Real, seed: int) -> Real:
    """Return the best found around x: steps along each axis and at random, a batch at
    a time, shorter where none is better, longer the way the last one went."""
    space, generator = Space(free), np.random.default_rng(seed)
    n, radius = len(free), REACH
    best = space.places(x)
    rank = judge.judge(space.values(best)[None])[0].rank
    for _ in range(POLISH):
        axes = np.concatenate([np.eye(n), -np.eye(n)])
        ways = generator.normal(size=(max(BATCH - 2 * n, 0), n))
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        tried = np.clip(best + radius * np.concatenate([axes, ways]), 0, 1)
        ranks = [j.rank for j in judge.judge(space.values(tried))]
        i = int(np.argmin(ranks))
        if ranks[i] < rank:
            best, rank, radius = tried[i], ranks[i], 1.5 * radius
        else:
            radius /= 3
        if radius < CLOSE:
            break
    return space.values(best)


def _named(free: Sequence[Free], x: Real) -> dict[str, Setting]:
    return {f.name: float(v) for f, v in zip(free, x, strict=True)}


def _full(
    judge: Judge, recompose: Recompose, values: Mapping[str, Setting]
) -> dict[str, Response]:
    """Measure what bounds are about, in full, with these values."""
    if not judge.full:
        return {}
    there = recompose(values)
    responses = judge.composition.scenario.spec.responses
    return {name: loop(there, responses[name]) for name in judge.full}


def _measured(
    judge: Judge, recompose: Recompose, free: Sequence[Free], x: Real
) -> list[dict[str, Response]]:
    """Measure in full in every variation."""
    found = _named(free, x)
    return [_full(judge, recompose, {**found, **v}) for v in judge.variations]


def _tightened(
    wanted: Constraint, now: Constraint, after: Sequence[Mapping[str, Response]]
) -> Constraint:
    """Return the bound as it is ``now``, or further by what ``wanted`` is missed by."""
    short = [wanted.sign * (wanted.bound - v) for v in _of_all(wanted, after)]
    missed = [s for s in short if not s <= 0]
    if not missed or not all(map(isfinite, missed)):  # nobody knows by how much
        return now
    return replace(now, bound=now.bound + 1.2 * now.sign * max(missed))


def _of_all(wanted: Constraint, after: Sequence[Mapping[str, Response]]) -> list[float]:
    """Return the figure of a bound in every variation; nothing if it is a metric's."""
    owner = owner_of(wanted.figure)
    return [
        response_figures(owner, of[owner])[wanted.figure].value
        for of in after
        if owner in of
    ]


def _refuse_missed(
    constraints: Sequence[Constraint],
    variations: Sequence[Assignment],
    after: Sequence[Mapping[str, Response]],
) -> None:
    """Raise ``TuneError`` if what is measured in full at the end misses a bound."""
    for c in constraints:
        for value, variation in zip(_of_all(c, after), variations, strict=False):
            if c.missed(value) > 0:
                there = ", ".join(f"{k} = {v}" for k, v in variation.items())
                at = f" at {there}" if there else ""
                raise TuneError(
                    f"{c.figure} is {value:.5g}{at} when measured in full, the bound "
                    f"{c.bound:g} is missed by what the quick looks are wrong by; "
                    f"widen --bounds or ask for a bound farther than is needed"
                )


def scenario_of(composition: Composition, found: Tuned, target: Path) -> Path:
    """Write the scenario that inherits from the tuned one and has the values found."""
    title = f"{composition.scenario.name} tuned"
    return write_heir(composition, found.best(), title, target)
