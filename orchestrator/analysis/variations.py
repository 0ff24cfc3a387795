"""What is varied in a sweep: axes of a grid, distributions of a sample.

An axis is written as ``--vary`` takes it, its key as ``--set``:

    plant.m_2=0.3e-3:0.5e-3:5         five values, both ends included
    plant.m_2=+-20%:9                 nine values about the nominal one
    controller.latency=0,1,2          these values
    "rates.control=5 kHz,10 kHz"      text, each as ``--set`` takes it
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ScenarioError

Setting: TypeAlias = float | str  # a value, or text as --set takes it
Assignment: TypeAlias = Mapping[str, Setting]
Nominal: TypeAlias = Callable[[str], float]
Method: TypeAlias = Literal["sobol", "lhs", "normal"]
FloatArray: TypeAlias = NDArray[np.float64]
_AROUND = re.compile(r"\+-\s*([\d.eE+-]+)\s*%")
_PARTED = re.compile(r"\s*([-+\d.eE]+)\s*(\D*?)\s*")


@dataclass(frozen=True)
class Axis:
    """A key and the values it takes."""

    key: str
    values: tuple[Setting, ...]


@dataclass(frozen=True)
class Tolerance:
    """A key and how its value is spread: uniform from ``a`` to ``b``, or normal with
    mean ``a`` and standard deviation ``b``."""

    key: str
    kind: Literal["uniform", "normal"]
    a: float
    b: float

    def distribution(self) -> Any:
        """Return the distribution as SciPy has it."""
        from scipy import stats

        if self.kind == "normal":
            return stats.norm(self.a, self.b)
        return stats.uniform(self.a, self.b - self.a)


def parse_axis(text: str, nominal: Nominal) -> Axis:
    """Return the axis that a ``--vary`` describes; ``nominal`` gives a key's value.

    Raises:
        ScenarioError: it is written in none of the forms above.
    """
    key, equals, written = (part.strip() for part in text.partition("="))
    if not equals or not key or not written:
        raise ScenarioError(f"--vary {text}: write key=a:b:n, key=+-20%:n or key=x,y,z")
    spread, colon, count = written.rpartition(":")
    if not colon:
        values = tuple(_setting(v) for v in written.split(","))
        return Axis(key, values)
    try:
        n = int(count)
    except ValueError:
        n = 0
    if n < 2:
        raise ScenarioError(
            f"--vary {text}: {count!r} is no number of values; give at least 2"
        )
    around = _AROUND.fullmatch(spread)
    if around:
        centre, share = nominal(key), float(around[1]) / 100
        if centre == 0:
            raise ScenarioError(
                f"--vary {text}: {key} is 0, of which every percentage is 0; write "
                f"its values, {key}=a:b:{n}"
            )
        ends, unit = (centre * (1 - share), centre * (1 + share)), ""
    else:
        ends, unit = _ends(text, spread)
    numbers = np.linspace(*ends, n).tolist()
    return Axis(key, tuple(f"{v!r} {unit}" if unit else v for v in numbers))


def _ends(text: str, spread: str) -> tuple[tuple[float, float], str]:
    low, colon, high = spread.partition(":")
    first, last = _PARTED.fullmatch(low), _PARTED.fullmatch(high)
    try:
        if not colon or first is None or last is None:
            raise ValueError
        ends = float(first[1]), float(last[1])
    except ValueError:
        raise ScenarioError(
            f"--vary {text}: {spread!r} is no range; write a:b:n, such as 1e-3:2e-3:5"
        ) from None
    units = {u for u in (first[2], last[2]) if u}
    if len(units) > 1:
        raise ScenarioError(f"--vary {text}: the ends have two units; write one")
    return ends, next(iter(units), "")


def _setting(text: str) -> Setting:
    try:
        return float(text) if "." in text or "e" in text.lower() else str(int(text))
    except ValueError:
        return text.strip()


def grid(axes: Sequence[Axis]) -> Iterator[dict[str, Setting]]:
    """Yield every combination, the last axis fastest.

    Raises:
        ScenarioError: a key is varied twice.
    """
    keys = [axis.key for axis in axes]
    twice = {key for key in keys if keys.count(key) > 1}
    if twice:
        raise ScenarioError(f"--vary: {', '.join(sorted(twice))} is varied twice")
    for values in product(*(axis.values for axis in axes)):
        yield dict(zip(keys, values, strict=True))


def sample(
    tolerances: Sequence[Tolerance], method: Method, n: int, seed: int
) -> list[Assignment]:
    """Return n assignments drawn from the tolerances.

    ``sobol`` and ``lhs`` spread them evenly (scrambled Sobol sequence, Latin
    hypercube), ``normal`` draws each independently.

    Raises:
        ScenarioError: there is nothing to draw from, or no positive number of it.
    """
    from scipy.stats import qmc

    if not tolerances:
        raise ScenarioError(
            "--sample: the scenario has no [tolerances]; write there, say, "
            '"plant.m_2" = "+-20 %"'
        )
    if n < 1:
        raise ScenarioError(f"--n {n}: at least one member is needed")
    d = len(tolerances)
    unit: FloatArray
    if method == "sobol":
        whole = qmc.Sobol(d, seed=seed).random_base2(max(1, (n - 1).bit_length()))
        unit = whole[:n]
    elif method == "lhs":
        unit = qmc.LatinHypercube(d, seed=seed).random(n)
    else:
        unit = np.random.default_rng(seed).random((n, d))
    columns = [
        t.distribution().ppf(unit[:, i]).tolist() for i, t in enumerate(tolerances)
    ]
    return [
        dict(zip((t.key for t in tolerances), row, strict=True))
        for row in zip(*columns, strict=True)
    ]
