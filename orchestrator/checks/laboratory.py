"""Where dynamic items try an FMU out: its variables, its steps, its instances.

A ``Laboratory`` belongs to one item in one process.  It tells its parent what
is being tried, so that a crash can be placed.  What is too much to be tried in
full is sampled evenly, and ``notes`` says so.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from time import process_time
from typing import Any, TypeVar

import numpy as np

from orchestrator.checks.instance import ERROR, Instance, Row, excitation
from orchestrator.checks.interface import Kind
from orchestrator.checks.item import WORDS, NotApplicable
from orchestrator.fmu.description import FmuDescription, FmuVariable

T = TypeVar("T")

STEPS = 50
WATCHED = 2000  # numbers that are read after a step
TRIED = 200  # variables that are tried one by one
REFUSING = 20  # variables that may refuse what they are set to


@dataclass
class Laboratory:
    """The FMU under test.

    ``model`` is fmpy's description, ``printed`` returns what the FMU wrote to stdout
    and stderr, ``kept`` is what a later stage in another process gets; ``beat`` is
    called after every call of the FMU; ``blamed`` is what was being tried when a call
    was refused last.  ``h`` (s) is the step that the FMU suggests.
    """

    description: FmuDescription
    model: Any
    folder: Path
    tell: Callable[[str], None]
    printed: Callable[[], bytes]
    kept: dict[str, Any] = field(default_factory=dict)
    attempt: str = ""
    told: str = ""
    blamed: str = ""
    stop: float | None = None  # s, for FMUs that cannot be initialised without
    beat: Callable[[], None] = lambda: None
    notes: dict[str, str] = field(default_factory=dict)

    @property
    def kind(self) -> Kind:
        """The interface that is tried: co-simulation where there is one."""
        if self.description.co_simulation:
            return "co-simulation"
        if self.description.model_exchange:
            return "model exchange"
        raise NotApplicable("it has scheduled execution only, which nobody runs here")

    @property
    def interface(self) -> Any:
        """fmpy's element CoSimulation or ModelExchange: capabilities."""
        co_simulation = self.kind == "co-simulation"
        return self.model.coSimulation if co_simulation else self.model.modelExchange

    def needs(self, capability: str) -> None:
        """Raise ``NotApplicable`` if the FMU does not declare a capability."""
        if not getattr(self.interface, capability, None):
            raise NotApplicable(f"it declares no {capability}")

    def needs_co_simulation(self) -> None:
        if self.kind != "co-simulation":
            raise NotApplicable("it has no co-simulation")

    @property
    def h(self) -> float:
        fixed = getattr(self.interface, "fixedInternalStepSize", None)
        period = self.description.period
        chosen = period or self.description.default_step or fixed
        if chosen:
            return float(chosen)
        stop = getattr(self.model.defaultExperiment, "stopTime", None)
        return float(stop) / 1000 if stop and float(stop) > 0 else 1e-3

    def variables(self, **roles: str) -> list[FmuVariable]:
        """Return the variables with these attributes, such as causality."""
        return [
            v
            for v in self.description.variables.values()
            if all(getattr(v, key) == value for key, value in roles.items())
        ]

    def sampled(self, what: str, things: Sequence[T], most: int = TRIED) -> list[T]:
        """Return all things, or ``most`` of them evenly and a note of it."""
        if len(things) <= most:
            return list(things)
        self.notes[what] = f"a sample: {most} of {len(things)} {what}"
        places = np.linspace(0, len(things) - 1, most).astype(int)
        return [things[i] for i in places]

    def as_many(self, most: int, do: Callable[[int], None], seconds: float) -> int:
        """Do k = 0, 1, ... and return how many fitted into the seconds (CPU)."""
        end = process_time() + seconds
        for k in range(most):
            do(k)
            if process_time() > end:
                self.notes["steps"] = f"{k + 1} steps instead of {most}: it is slow"
                return k + 1
        return most

    def trying(self, text: str) -> None:
        """Say what is being tried, for whoever has to explain a crash."""
        self.attempt = self.told = text
        self.tell(text)

    def doing(self, text: str) -> None:
        """Say which call comes next in what is being tried."""
        self.told = f"{self.attempt}: {text}" if self.attempt else text
        self.tell(self.told)

    @contextmanager
    def instance(self, name: str = "one", **options: Any) -> Iterator[Instance]:
        """Give a fresh instance and free it afterwards."""
        instance = Instance(self, name, **options)
        try:
            yield instance
        finally:
            instance.free()

    @contextmanager
    def running(self, name: str = "one", **options: Any) -> Iterator[Instance]:
        """Give an instance that has been initialised with its own start values."""
        with self.instance(name, **options) as instance:
            instance.begin()
            yield instance

    @cached_property
    def watched(self) -> list[FmuVariable]:
        """Every variable with numbers that may change, outputs first if too many."""
        outputs, locals_ = (
            [v for v in self.variables(causality=c) if v.fmi_type not in WORDS]
            for c in ("output", "local")
        )
        if sum(v.size for v in outputs + locals_) <= WATCHED:
            chosen = {v.name for v in outputs + locals_}
            return [v for v in self.description.variables.values() if v.name in chosen]
        outputs = self.sampled("outputs", outputs, WATCHED // 2)
        return outputs + self.sampled("locals", locals_, WATCHED - len(outputs))

    @cached_property
    def excited(self) -> list[FmuVariable]:
        """The real inputs, which a run moves."""
        return [v for v in self.variables(causality="input") if v.sort == "real"]

    @cached_property
    def movable_parameters(self) -> list[FmuVariable]:
        """Real parameters that can be set a little beside their start values."""
        real = [v for v in self.variables(causality="parameter") if v.sort == "real"]
        free = [v for v in real if v.variability != "constant"]
        return self.settable(self.sampled("parameters", free), 0.02)

    def settable(self, variables: list[FmuVariable], part: float) -> list[FmuVariable]:
        """Return those that take a value besides their start in initialisation.

        After an Error an instance is spent, so each that refuses costs another one.
        """
        left = list(variables)
        for _ in range(REFUSING):
            with self.instance() as one:
                one.enter()
                refusing = (
                    v
                    for v in left
                    if one.status(one.set, v, excitation(v, part)) >= ERROR
                )
                first = next(refusing, None)
            if first is None:
                return left
            left.remove(first)
        return []

    def column(self, place: int) -> str:
        """Return the name of a place in a row."""
        return [v.name for v in self.watched for _ in range(v.size)][place]

    def trajectory(self, count: int = STEPS, **options: Any) -> Row:
        """Return the rows of a run with moving inputs, from start values."""
        with self.running(**options) as instance:
            return instance.run(count)
