"""What an FMU tells of a model, whatever the version of FMI."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from fmus.layout import Layout, Variable
from fmus.model import Continuous, Model, Sampled
from fmus.trace import Traced

Fmi: TypeAlias = Literal[2, 3]

CLOCK = "clock"  # the input clock of a sampled model in FMI 3


@dataclass(frozen=True)
class Subject:
    """What an FMU is made of, as far as its description tells.

    ``text`` is the docstring of the module; ``sources`` are the C files to be
    compiled, none for an FMU that runs Python; ``data`` the content of the model's
    data files by path.  ``author``, ``copyright`` and
    ``license`` may be None.  ``resources`` are files of the archive that the C in
    ``equations`` reads, which stands for the traced equations.  Without ``clock`` a
    sampled model has none in FMI 3.
    """

    model: Model
    traced: Traced
    layout: Layout
    module: str
    text: str
    sources: tuple[str, ...] = ()
    data: Mapping[str, bytes] = field(default_factory=dict)
    author: str | None = None
    copyright: str | None = None
    license: str | None = None
    clock: bool = True
    equations: str = ""
    resources: Mapping[str, bytes] = field(default_factory=dict)

    @property
    def clocked(self) -> bool:
        """Whether an importer may tick the model by a clock, in FMI 3."""
        return self.native and self.clock and isinstance(self.model, Sampled)

    @property
    def native(self) -> bool:
        return bool(self.sources)

    @property
    def model_exchange(self) -> bool:
        """Whether an importer may integrate the model itself."""
        model = self.model
        plain = isinstance(model, Continuous) and not (model.advance or model.delay)
        return self.native and plain

    @property
    def summary(self) -> str:
        return next(iter(self.text.strip().splitlines()), self.model.name)


class Role(NamedTuple):
    """Attributes that say who may set a variable and when it changes."""

    causality: str
    variability: str
    initial: str | None


def role(variable: Variable, model: Model) -> Role:
    """Return a legal combination of causality, variability and initial."""
    changing = "continuous" if isinstance(model, Continuous) else "discrete"
    if variable.boolean:
        changing = "discrete"
    if variable.var.constant:
        return Role("local", "constant", "exact")
    match variable.block:
        case "parameter":
            variability = "fixed" if variable.var.fixed else "tunable"
            return Role("parameter", variability, "exact")
        case "input":
            return Role("input", changing, None)
        case "output":
            return Role("output", changing, "calculated")
        case "state":
            return Role("local", changing, "exact")
    return Role("local", changing, "calculated")


def check_start(model: Model, variable: Variable) -> None:
    """Refuse a start value no importer would take.

    Raises:
        ValueError: it is not finite or out of its bounds, or the variable has the
            name of the independent variable or of the clock of FMI 3.
    """
    start, var = np.array(variable.start), variable.var
    low = -np.inf if var.min is None else var.min
    high = np.inf if var.max is None else var.max
    where = f"{model.name}: {variable.block} {variable.name!r}"
    if variable.name == "time":
        raise ValueError(f"{where} has the name of the independent variable")
    if variable.name == CLOCK and isinstance(model, Sampled):
        raise ValueError(f"{where} has the name of the clock of FMI 3")
    if not np.isfinite(start).all():
        raise ValueError(f"{where} starts at {variable.start}: give finite numbers")
    if not ((low <= start) & (start <= high)).all():
        raise ValueError(f"{where} starts out of its bounds [{low}, {high}]")
