"""The keys of one component: what it is, when it steps, what it starts with."""

from fractions import Fraction
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, PlainValidator, field_validator, model_validator

from orchestrator.evaluation.rates import named_period
from orchestrator.evaluation.schema import Strict
from orchestrator.quantities.quantity import parse_bytes, parse_period, parse_time
from orchestrator.scenario.maps import MapSpec
from orchestrator.scenario.written import parse_setting
from orchestrator.signals.recording import AtEnd, Interpolation
from orchestrator.system import Interface, Kind, Value

Time: TypeAlias = Annotated[Fraction, PlainValidator(parse_time)]
Period: TypeAlias = Annotated[Fraction, PlainValidator(named_period)]
Number: TypeAlias = Annotated[Value, PlainValidator(parse_setting)]


class ExperimentSpec(Strict):
    """Whether the stop time is handed over, and a relative tolerance."""

    stop: bool = False
    tolerance: float | None = Field(default=None, gt=0)


class ComponentSpec(Strict):
    """One component: its FMU (``plants.x``, a ``.py`` or an ``.fmu``) and times.

    Or the signals of a file, ``data``: ``interpolation`` between its rows, ``begin`` is
    its time (s) at the start of the run, ``rate`` how far apart its rows are, exactly;
    ``at_end`` its last values hold or the run ends.
    """

    fmu: str = ""
    data: str | None = None
    interpolation: Interpolation = "hold"
    begin: Time = Fraction(0)
    rate: Period | None = None
    at_end: AtEnd | None = None
    step: Period | None = None
    offset: Time = Fraction(0)
    latency: int = Field(default=0, ge=0)
    kind: Kind | None = None
    parameters: dict[str, Number] = Field(default_factory=dict)
    start: dict[str, Number] = Field(default_factory=dict)
    map: dict[str, MapSpec] = Field(default_factory=dict)
    isolation: Literal["process", "sandbox", "none"] | None = None
    answer_within: Annotated[Fraction, PlainValidator(parse_period)] = Fraction(60)
    memory_limit: Annotated[float | None, PlainValidator(parse_bytes)] = None
    experiment: ExperimentSpec = Field(default_factory=ExperimentSpec)
    split: bool | None = None
    interface: Interface | None = None

    @field_validator("map", mode="before")
    @classmethod
    def _short_map(cls, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        return {k: {"name": v} if isinstance(v, str) else v for k, v in value.items()}

    @model_validator(mode="after")
    def _model_or_data(self) -> "ComponentSpec":
        if bool(self.fmu) == (self.data is not None):
            raise ValueError(
                'give fmu = "...", a model, or data = "...", a file of signals'
            )
        of_data = {"interpolation", "begin", "rate", "at_end"} & self.model_fields_set
        if self.fmu and of_data:
            raise ValueError(f"{min(of_data)} is for data = a file of signals")
        return self

    @model_validator(mode="after")
    def _each_value_once(self) -> "ComponentSpec":
        if twice := [name for name in self.parameters if name in self.start]:
            raise ValueError(
                f"{twice[0]} stands under parameters and under start, which are one "
                f"table; remove one of the two"
            )
        return self

    @field_validator("offset")
    @classmethod
    def _not_before_zero(cls, value: Fraction) -> Fraction:
        if value < 0:
            raise ValueError(f"{value} is before the start at 0")
        return value
