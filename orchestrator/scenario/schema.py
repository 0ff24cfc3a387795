"""The keys a scenario file may hold, their types and how they hang together.

A rate name stands wherever a period may stand.  In ``connections`` and
``record`` one ``*`` per name stands for any text, the same on both sides:
``"controller.*" = "trajectory.*"`` connects every input of the controller to
the trajectory's output of that name, ``"encoder.x_*" = "plant.x_*"`` likewise;
a list of sources is tried in order of writing, and a line for a single input
wins over a star.  A number as source is a constant.  A signal may be recorded
at several rates: ``"plant.x_2" = ["20 kHz", "1 kHz"]``.
"""

import re
from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import (
    Field,
    PlainValidator,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    field_validator,
    model_validator,
)

from orchestrator.errors import did_you_mean
from orchestrator.evaluation.rates import RateContext, named_period
from orchestrator.evaluation.schema import (
    Expectation,
    Likeness,
    MetricSpec,
    Strict,
    Window,
)
from orchestrator.quantities.quantity import parse_period
from orchestrator.scenario.component import ComponentSpec
from orchestrator.scenario.responses import ResponseSpec
from orchestrator.scenario.written import in_floats, parse_scalar, parse_value
from orchestrator.system import FaultKind, split_name

RESERVED = (
    *("stop", "fmi", "rates", "design", "base", "faults"),
    *("metrics", "record", "connections", "groups"),
)


def _rows(value: Any, info: ValidationInfo) -> tuple[Fraction | None, ...]:
    """Return the row periods of a record; None is that of the component."""
    several = value if isinstance(value, list) else [value]
    if not several:
        raise ValueError("give a rate, a list of rates, or true")
    found = [None if one is True else named_period(one, info) for one in several]
    return tuple(dict.fromkeys(found))


def _source(value: Any) -> float | str | tuple[str, ...]:
    if isinstance(value, str):
        return value
    if isinstance(value, list) and all(isinstance(v, str) for v in value):
        return tuple(value)
    if isinstance(value, list):
        raise ValueError("a constant source is one number")
    return parse_scalar(value)


Rate: TypeAlias = Annotated[Fraction, PlainValidator(parse_period)]
Rows: TypeAlias = Annotated[tuple[Fraction | None, ...], PlainValidator(_rows)]
Source: TypeAlias = Annotated[float | str | tuple[str, ...], PlainValidator(_source)]


class DesignSpec(Strict):
    """An offline step ``module:function`` whose result sets parameters.

    ``arguments`` are numbers, switches, arrays, texts or ``component.parameter``;
    ``signals`` of the scenario ``from_run`` are handed over as arrays with ``T_s``.
    """

    call: str = Field(pattern=r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$")
    arguments: dict[str, Any] = Field(default_factory=dict)
    sets: tuple[str, ...] = ()
    from_run: str | None = None
    signals: dict[str, str] = Field(default_factory=dict)

    @field_validator("sets", mode="before")
    @classmethod
    def _one_or_more(cls, value: Any) -> Any:
        if isinstance(value, str):
            return (value,)
        return tuple(value) if isinstance(value, list) else value

    @field_validator("arguments")
    @classmethod
    def _arguments(cls, value: dict[str, Any]) -> dict[str, Any]:
        return {
            k: v if isinstance(v, str) else in_floats(parse_value(v))
            for k, v in value.items()
        }

    @model_validator(mode="after")
    def _signals_come_from_a_run(self) -> "DesignSpec":
        if bool(self.signals) != (self.from_run is not None):
            raise ValueError("from_run and signals are given together or not at all")
        return self


class TuneSpec(Strict):
    """Where ``feeddrive tune`` starts: a step whose result is set in no run."""

    start: DesignSpec | None = None


class FaultSpec(Strict):
    """A fault of an input: its kind, number, and window [from, to) (s; always)."""

    kind: FaultKind
    value: Annotated[float | None, PlainValidator(parse_scalar)] = None
    samples: int | None = Field(default=None, ge=1)
    window: Window | None = None

    @model_validator(mode="after")
    def _says_its_number(self) -> "FaultSpec":
        needed = {"stuck": None, "delay": "samples"}.get(self.kind, "value")
        for key in ("value", "samples"):
            given = getattr(self, key) is not None
            if given != (key == needed):
                verb = "takes no" if given else "needs its"
                raise ValueError(f"kind {self.kind!r} {verb} {key}")
        if self.kind == "quantisation" and not (self.value or 0) > 0:
            raise ValueError("value: a quantum is greater than zero")
        if self.window is not None and self.window[0] < 0:
            raise ValueError("window: begins before the start at 0")
        return self

    @property
    def in_unit(self) -> bool:
        """Whether its number has the unit of the input."""
        return self.kind in ("bias", "override", "quantisation")


Pair: TypeAlias = Annotated[tuple[float | str, float | str], Field(strict=False)]


class ToleranceSpec(Strict):
    """How a value is spread: ``uniform`` from a to b, ``normal`` with mean and standard
    deviation, or ``around`` its nominal value by a share (``"+-20 %"``).

    Numbers may carry units, as ``"7 kg"``.
    """

    uniform: Pair | None = None
    normal: Pair | None = None
    around: float | None = None

    @model_validator(mode="before")
    @classmethod
    def _share(cls, value: Any) -> Any:
        if not isinstance(value, str):
            return value
        match = re.fullmatch(r"\s*\+-\s*([\d.]+)\s*%\s*", value)
        if match is None:
            raise ValueError(f'{value!r}: write "+-20 %", uniform or normal')
        return {"around": float(match[1]) / 100}

    @model_validator(mode="after")
    def _one_form(self) -> "ToleranceSpec":
        given = (self.uniform, self.normal, self.around)
        if sum(form is not None for form in given) != 1:
            raise ValueError(
                'write { uniform = [a, b] }, { normal = [mean, sd] } or "+-20 %"'
            )
        return self


class GroupSpec(Strict):
    """Components of one step; with ``iterate`` what passes between them is iterated
    until it agrees, to ``tolerance`` of a number (or of 1).
    """

    components: tuple[str, ...] = Field(min_length=1, strict=False)
    iterate: bool = False
    tolerance: float = Field(default=1e-9, gt=0, lt=1)


class Specification(Strict):
    """All a scenario says, after inheritance and overrides."""

    title: str = ""
    description: str = ""
    fmi: Literal[2, 3] = 2
    stop: Annotated[Fraction, PlainValidator(parse_period)]
    rates: dict[str, Rate] = Field(default_factory=dict)
    components: dict[str, ComponentSpec] = Field(min_length=1)
    connections: dict[str, Source] = Field(default_factory=dict)
    faults: dict[str, tuple[FaultSpec, ...]] = Field(default_factory=dict)
    groups: dict[str, GroupSpec] = Field(default_factory=dict)
    design: dict[str, DesignSpec] = Field(default_factory=dict)
    record: dict[str, Rows] = Field(default_factory=dict)
    metrics: dict[str, MetricSpec] = Field(default_factory=dict)
    responses: dict[str, ResponseSpec] = Field(default_factory=dict)
    tune: TuneSpec = TuneSpec()
    expect: dict[str, Expectation] = Field(default_factory=dict)
    expect_like: Likeness | None = None
    tolerances: dict[str, ToleranceSpec] = Field(default_factory=dict)
    lock: dict[str, Any] = Field(default_factory=dict)

    @field_validator("expect_like", mode="before")
    @classmethod
    def _folder_alone(cls, value: Any) -> Any:
        return {"folder": value} if isinstance(value, str) else value

    @field_validator("rates", mode="wrap")
    @classmethod
    def _share_rates(
        cls, value: Any, validate: ValidatorFunctionWrapHandler, info: ValidationInfo
    ) -> dict[str, Fraction]:
        context = info.context or RateContext()
        context.readable = False
        rates: dict[str, Fraction] = validate(value)
        context.rates, context.readable = rates, True
        return rates

    @field_validator("faults", mode="before")
    @classmethod
    def _one_or_several(cls, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        one = {k: (v,) if isinstance(v, dict) else v for k, v in value.items()}
        return {k: tuple(v) if isinstance(v, list) else v for k, v in one.items()}

    @field_validator("components")
    @classmethod
    def _plain_names(cls, value: dict[str, ComponentSpec]) -> dict[str, ComponentSpec]:
        for name in value:
            if not re.fullmatch(r"[A-Za-z_]\w*", name) or name in RESERVED:
                raise ValueError(
                    f"{name!r} cannot name a component: letters, digits and _ only, "
                    f"and none of {', '.join(RESERVED)}"
                )
        return value

    @model_validator(mode="after")
    def _ends_exist(self) -> "Specification":
        for sink, source in self.connections.items():
            ends = [sink, *(source if isinstance(source, tuple) else [source])]
            for end in (e for e in ends if isinstance(e, str)):
                if re.match(r"[-+.\d]", end):
                    raise ValueError(
                        f'connections."{sink}": {end!r} is no component.variable; a '
                        f"constant is a number without quotes, in the unit of {sink}"
                    )
                self._variable(f'connections."{sink}"', end)
                if end.count("*") > 1:
                    raise ValueError(f'connections."{sink}": {end!r} has several *')
        for name in self.faults:
            self._variable(f'faults."{name}"', name)
        for name, group in self.groups.items():
            for one in group.components:
                where = f"groups.{name}.components"
                _one_of(where, "component", one, self.components)
        for name in self.record:
            self._variable(f'record."{name}"', name)
        for name, metric in self.metrics.items():
            for key, signal in metric.signals().items():
                self._variable(f"metrics.{name}.{key}", signal)
        for name, step in self.design.items():
            for component in step.sets:
                _one_of(f"design.{name}.sets", "component", component, self.components)
        if start := self.tune.start:
            for component in start.sets:
                _one_of("tune.start.sets", "component", component, self.components)
        for name in self.tolerances:
            self._variable(f'tolerances."{name}"', name)
        for name in self.expect_like.signals if self.expect_like else ():
            self._variable(f'expect_like.signals."{name}"', name)
        for name in self.expect:
            owner, _, figure = name.rpartition(".")
            if owner in self.responses:
                known_of = self.responses[owner].figures
                _one_of(f'expect."{name}"', "figure", figure, known_of)
            elif self.responses:
                known = {*self.metrics, *self.responses}
                _one_of(f'expect."{name}"', "metric or response", owner, known)
            else:
                _one_of(f'expect."{name}"', "metric", owner, self.metrics)
        for name, response in self.responses.items():
            if name in self.metrics:
                raise ValueError(f"responses.{name}: is the name of a metric too")
            for key, named in response.named.items():
                for one in named:
                    self._variable(f"responses.{name}.{key}", one)
        return self

    @property
    def expected_of_run(self) -> dict[str, Expectation]:
        """What is expected of metrics."""
        return {k: e for k, e in self.expect.items() if not self._of_response(k)}

    @property
    def expected_of_responses(self) -> dict[str, Expectation]:
        """What is expected of responses, which no run carries out."""
        return {k: e for k, e in self.expect.items() if self._of_response(k)}

    def _of_response(self, figure: str) -> bool:
        return figure.rpartition(".")[0] in self.responses

    def _variable(self, path: str, variable: str) -> None:
        component, name = split_name(variable)
        _one_of(path, "component", component, self.components)
        if not name:
            raise ValueError(f"{path}: write {component}.<variable>, not {variable!r}")


def _one_of(
    path: str, noun: str, name: str, known: Mapping[str, Any] | Iterable[str]
) -> None:
    if name not in known:
        remedy = did_you_mean(name, known)
        raise ValueError(f"{path}: there is no {noun} {name!r}; {remedy}")
