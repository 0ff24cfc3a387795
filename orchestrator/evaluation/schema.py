"""The keys of ``[metrics]`` and ``[expect]`` in a scenario file.

A metric takes one recorded signal (``of``), over ``window = [from, to]`` (s;
the whole record without), multiplied by ``scale`` and divided by ``per``
(a number, a number with unit ``"3 m/rad"``, or ``component.parameter`` with its
unit), in ``unit``.  Its figures are called ``<metric>.<figure>``.  ``at`` takes
the rows of that rate, where signals are recorded at several; without it they
are those of the highest rate, and of two signals that are compared the ones at
which both are published.
"""

from fractions import Fraction
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PlainSerializer,
    PlainValidator,
    field_validator,
    model_validator,
)

from orchestrator.errors import did_you_mean
from orchestrator.evaluation.rates import named_period
from orchestrator.plugins import named
from orchestrator.quantities.quantity import parse_time

Factor: TypeAlias = float | str


class Strict(BaseModel):
    """A table that refuses keys it does not know, with the nearest it knows."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _refuse_unknown_keys(cls, value: Any) -> Any:
        if isinstance(value, dict):
            known = {f.alias or name for name, f in cls.model_fields.items()}
            for key in value:
                if key not in known:
                    remedy = did_you_mean(str(key), known)
                    raise ValueError(f"there is no key {key!r}; {remedy}")
        return value


def _window(value: Any) -> tuple[Fraction, Fraction]:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError("a window is two times, [from, to]")
    start, end = map(parse_time, value)
    if start >= end:
        raise ValueError(f"the window ends ({end} s) before it begins ({start} s)")
    return start, end


# kept as exact times: pydantic's own serialiser of fractions warns of its own text
Time: TypeAlias = Annotated[Fraction, PlainValidator(parse_time), PlainSerializer(str)]
Window: TypeAlias = Annotated[
    tuple[Fraction, Fraction], PlainValidator(_window), PlainSerializer(list)
]


Period: TypeAlias = Annotated[
    Fraction, PlainValidator(named_period), PlainSerializer(str)
]


class _Metric(Strict):
    of: str
    unit: str | None = None
    scale: Factor = 1.0
    per: Factor = 1.0
    window: Window | None = None
    at: Period | None = None

    def signals(self) -> dict[str, str]:
        """Return the recorded signals the metric takes, by key."""
        return {"of": self.of}


class ErrorMetric(_Metric):
    """``.peak`` (largest magnitude), ``.rms`` and ``.mean`` of against - of."""

    kind: Literal["error"]
    against: str

    def signals(self) -> dict[str, str]:
        return {"of": self.of, "against": self.against}


class PlainMetric(_Metric):
    """One figure of a signal, called as the kind; ``peak`` and ``mean_abs`` are of
    the magnitude, ``span`` is max - min."""

    kind: Literal["peak", "rms", "mean", "mean_abs", "max", "min", "final", "span"]


class SettlingMetric(_Metric):
    """``.settling`` (s after the window's begin), ``.peak`` and ``.peak_time`` (s).

    Settled from the first sample on after which the distance from ``final``
    (in ``unit``) stays within ``band`` times its own largest value.
    """

    kind: Literal["settling"]
    band: float = Field(default=0.05, gt=0, lt=1)
    final: float = 0.0


class SineMetric(_Metric):
    """Least-squares sine at ``frequency_hz``: ``.amplitude`` and ``.phase`` (deg).

    With ``against``: ``.ratio`` (in ``unit``) and ``.phase`` of one over the other.
    """

    kind: Literal["sine"]
    frequency_hz: Factor
    against: str | None = None

    def signals(self) -> dict[str, str]:
        other = {} if self.against is None else {"against": self.against}
        return {"of": self.of, **other}


class SpectrumMetric(_Metric):
    """``.amplitude`` of a spectral line (Hann, one-sided), and its ``.frequency`` (Hz).

    The line nearest ``frequency_hz``, or the strongest one within ``band_hz``, whose
    frequency is interpolated between lines.
    """

    kind: Literal["spectrum"]
    frequency_hz: Factor | None = None
    band_hz: tuple[float, float] | None = Field(default=None, strict=False)

    @model_validator(mode="after")
    def _one_line(self) -> "SpectrumMetric":
        if (self.frequency_hz is None) == (self.band_hz is None):
            raise ValueError("give frequency_hz or band_hz")
        if self.band_hz is not None and not 0 <= self.band_hz[0] < self.band_hz[1]:
            raise ValueError("band_hz takes the lower end, then the upper end")
        return self


class OnsetMetric(_Metric):
    """``.limit``: value of ``ramp`` at which the oscillation of ``of`` begins to grow,
    and ``.time`` (s) of it.

    A gain that rises slowly passes the limit of stability where the oscillation,
    as root mean square over pieces of ``piece`` (s), is smallest.
    """

    kind: Literal["onset"]
    ramp: str
    piece: float = Field(default=0.05, gt=0)

    def signals(self) -> dict[str, str]:
        return {"of": self.of, "ramp": self.ramp}


class StepMetric(_Metric):
    """Response to a step of ``height`` at the window's begin, up from 0.

    ``.rise`` (s, 10 to 90 %), ``.reach`` (s, to 90 %), ``.overshoot`` (%),
    ``.settling`` (s, until the error stays within ``band``, in ``unit``) and the
    last ``.error``.
    """

    kind: Literal["step"]
    height: Factor
    band: float = Field(gt=0)


class ContourMetric(_Metric):
    """Deviation of two axes, ``of`` and ``across``, from a contour of ``size``.

    ``.peak`` (largest magnitude), ``.rms``, ``.max`` (outside) and ``.min`` (inside):
    the distance from a circle of radius ``size``, or from a ``square`` of side
    ``size`` that stands on its corner, or |x| + |y| - ``size`` of a ``diamond``, or the
    distance from a ``rose`` of four petals, r = ``size`` cos 2φ.
    """

    kind: Literal["contour"]
    across: str
    shape: Literal["circle", "diamond", "rose", "square"]
    size: Factor

    def signals(self) -> dict[str, str]:
        return {"of": self.of, "across": self.across}


class SustainedMetric(_Metric):
    """``.level``: value of ``level`` on its first stair that ends oscillating.

    Stairs last ``dwell`` from the window's begin; oscillating means that ``of`` spans
    more than ``span`` (in ``unit``) in the last ``tail`` of a stair.
    """

    kind: Literal["sustained"]
    level: str
    dwell: Time
    tail: Time
    span: float = Field(gt=0)

    def signals(self) -> dict[str, str]:
        return {"of": self.of, "level": self.level}


class PluginMetric(_Metric):
    """Figures of a signal by the function ``name`` of another package.

    It is an entry point of ``feeddrive.metrics`` and takes the rows' times (s) and
    values, their unit, and the ``arguments``.
    """

    kind: Literal["plugin"]
    name: str
    arguments: dict[str, Any] = Field(default_factory=dict)

    @field_validator("name")
    @classmethod
    def _is_added(cls, value: str) -> str:
        if value not in (known := named("metrics")):
            raise ValueError(
                f"no installed package adds a metric {value!r} (entry points of "
                f"feeddrive.metrics); {did_you_mean(value, known)}"
            )
        return value


MetricSpec: TypeAlias = Annotated[
    ErrorMetric
    | OnsetMetric
    | PlainMetric
    | SettlingMetric
    | SineMetric
    | SpectrumMetric
    | StepMetric
    | ContourMetric
    | SustainedMetric
    | PluginMetric,
    Field(discriminator="kind"),
]


class Expectation(Strict):
    """Bounds a figure must keep: ``below``, ``above``, ``near`` with ``within``."""

    below: float | None = None
    above: float | None = None
    near: float | None = None
    within: float | None = Field(default=None, gt=0)
    unit: str | None = None

    @model_validator(mode="after")
    def _says_something(self) -> "Expectation":
        if (self.near is None) != (self.within is None):
            raise ValueError("near and within are given together")
        if self.below is None and self.above is None and self.near is None:
            raise ValueError("give below, above, or near and within")
        return self


class Tolerance(Strict):
    """How far a signal may be from its baseline.

    ``absolute`` is in its unit, ``relative`` a share of the baseline's range, ``time``
    in s, ``frequency`` a share of the dominant one.
    """

    absolute: float = Field(default=0.0, ge=0)
    relative: float = Field(default=1e-6, ge=0)
    time: Time = Fraction(0)
    frequency: float = Field(default=0.01, ge=0)


class Likeness(Tolerance):
    """``expect_like``: the folder of baselines, and what is compared how.

    Without ``signals`` all that the baseline holds is; a signal's own table replaces
    the common tolerances that it names.
    """

    folder: str
    signals: dict[str, Tolerance] = Field(default_factory=dict)

    def of(self, name: str) -> Tolerance:
        """Return the tolerances of a signal."""
        common = {key: getattr(self, key) for key in Tolerance.model_fields}
        own = self.signals.get(name)
        given = (
            {} if own is None else {k: getattr(own, k) for k in own.model_fields_set}
        )
        return Tolerance.model_construct(**{**common, **given})
