"""How far one value may go before the first expectation fails: bisection."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from orchestrator.analysis.members import (
    Group,
    Job,
    Outcome,
    Workers,
    refuse_driven,
    split,
)
from orchestrator.errors import ScenarioError
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import naming, run_earlier

FURTHEST = 1024.0  # times the nominal value, and as many times smaller
FINE = 1e-4  # of the value


@dataclass(frozen=True)
class Break:
    """``holds`` and ``breaks`` are neighbours; ``what`` fails first beyond.

    None for both where nothing breaks up to ``FURTHEST`` times the nominal value.
    """

    direction: str
    holds: float
    breaks: float | None
    what: str


def until_breaks(
    scenario: str | Path, key: str, sets: Sequence[str] = ()
) -> tuple[float, list[Break]]:
    """Return a key's nominal value and where it breaks, downwards and upwards.

    Each bound is found to 1e-4 of its value; between nominal and bound the
    expectations are taken to hold or fail once (a sweep shows if they do not).

    Raises:
        ScenarioError: no expectations, the key is no number of a component that is
            not zero, or a connection drives it, or the scenario itself does not meet
            its expectations.
    """
    base = load_scenario(scenario, list(sets))
    with naming(base):
        composition = compose(base, run_earlier)
    if not base.spec.expected_of_run:
        raise ScenarioError(f"{base.file}: has no [expect] that could break")
    nominal = composition.parameter(key).value
    if nominal == 0:
        raise ScenarioError(f"--until-breaks {key}: is 0; give --vary a range instead")
    refuse_driven(composition, "--until-breaks", [key])
    with closing(Workers()) as workers:
        return nominal, _both_ways(workers(composition, 1), key, nominal)


def _both_ways(group: Group, key: str, nominal: float) -> list[Break]:
    def outcomes(values: Sequence[float]) -> list[Outcome]:
        jobs = []
        for i, value in enumerate(values):
            numbers, more = split(group.composition, {key: value})
            if more:
                raise ScenarioError(
                    f"--until-breaks {key}: is no real number of a component"
                )
            jobs.append(Job(i, numbers))
        return sorted(group.run(jobs), key=lambda outcome: outcome.index)

    (first,) = outcomes([nominal])
    if not first.met:
        raise ScenarioError(
            f"--until-breaks {key}: the scenario itself does not hold: {_why(first)}"
        )
    found = []
    for direction, factors in (
        ("down", [2.0**-i for i in range(1, 11)]),
        ("up", [2.0**i for i in range(1, 11)]),
    ):
        found.append(_bisected(direction, nominal, factors, outcomes))
    return found


def _bisected(
    direction: str, nominal: float, factors: Sequence[float], outcomes: object
) -> Break:
    assert callable(outcomes)
    holds, breaks, what = nominal, None, ""
    tried = [nominal * f for f in factors]
    for value, outcome in zip(tried, outcomes(tried), strict=True):
        if not outcome.met:
            breaks, what = value, _why(outcome)
            break
        holds = value
    if breaks is None:
        return Break(direction, holds, None, "")
    while abs(breaks - holds) > FINE * abs(holds):
        inner = [holds + (breaks - holds) * i / 9 for i in range(1, 9)]
        for value, outcome in zip(inner, outcomes(inner), strict=True):
            if not outcome.met:
                breaks, what = value, _why(outcome)
                break
            holds = value
    return Break(direction, holds, breaks, what)


def _why(outcome: Outcome) -> str:
    failed = [c.text for c in outcome.checks if not c.met]
    return outcome.failure or "; ".join(failed)
