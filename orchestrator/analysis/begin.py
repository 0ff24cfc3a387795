"""What is free to be tuned, and the values that tuning begins with."""

from collections.abc import Container, Mapping, Sequence
from fnmatch import fnmatchcase

from orchestrator.analysis.fit import Bracket, Free, free_values
from orchestrator.errors import TuneError, did_you_mean
from orchestrator.result import Result
from orchestrator.scenario.compose import Composition
from orchestrator.scenario.design import run_step
from orchestrator.session import run_earlier
from orchestrator.system import Value, split_name

REACH = 4.0  # times and parts of a recipe's value a value may become unasked


def matching(
    composition: Composition, pattern: str, known: Container[str] = ()
) -> list[str]:
    """Return the real parameters that ``controller.K_*`` stands for.

    What starts at 0 is switched off and not meant, unless it is ``known`` otherwise.

    Raises:
        TuneError: there are none.
    """
    owner, wanted = split_name(pattern)
    if "*" not in pattern:
        return [pattern]
    if owner not in composition.fmus:
        known = did_you_mean(owner, composition.fmus)
        raise TuneError(f"--free {pattern}: no component {owner!r}; {known}")
    variables = composition.fmus[owner].variables
    names = [
        f"{owner}.{name}"
        for name, v in variables.items()
        if v.causality == "parameter" and v.sort == "real" and fnmatchcase(name, wanted)
    ]
    names = [n for n in names if n in known or composition.parameter(n).value != 0]
    if not names:
        raise TuneError(f"--free {pattern}: matches no real parameter of {owner}")
    return names


def free_of(
    composition: Composition,
    patterns: Sequence[str],
    bounds: Mapping[str, Bracket],
    begin: Mapping[str, float] | None = None,
) -> tuple[Free, ...]:
    """Return what is free to be tuned, with brackets given or about its start.

    ``begin`` are values of a recipe, about which brackets are narrower.
    """
    known = {*bounds, *(begin or {})}
    names = [n for p in patterns for n in matching(composition, p, known)]
    names = list(dict.fromkeys(names))
    about = {n: v for n, v in (begin or {}).items() if n in names and v}
    near = {n: _near(v) for n, v in about.items()}
    return free_values(composition, names, {**near, **bounds}, about)


def _near(value: float) -> Bracket:
    low, high = sorted((value / REACH, value * REACH))
    return low, high


def begin_of(composition: Composition) -> dict[str, float]:
    """Return the values of ``tune.start``, by name; none without it.

    Raises:
        DesignError: it cannot be carried out.
        TuneError: it sets nothing, or what its components do not have.
    """
    step = composition.scenario.spec.tune.start
    if step is None:
        return {}
    if not step.sets:
        raise TuneError("tune.start.sets is missing: whose values are they?")

    def lookup(name: str) -> Value:
        return composition.parameter(name).value

    def earlier(name: str) -> Result:
        return run_earlier(composition.scenario.beside(name))

    found = run_step("tune.start", step, lookup, earlier).values
    values: dict[str, float] = {}
    for key, value in found.items():
        takers = [c for c in step.sets if key in composition.fmus[c].variables]
        if not takers or not isinstance(value, float):
            owners = " and ".join(step.sets)
            raise TuneError(f"tune.start: {key} is no real parameter of {owners}")
        values |= {f"{component}.{key}": value for component in takers}
    return values
