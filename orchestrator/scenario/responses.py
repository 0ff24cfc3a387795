"""``[responses]``: what of a scenario's loops is measured, where and how."""

from collections.abc import Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    PlainSerializer,
    PlainValidator,
    ValidationError,
    field_validator,
    model_validator,
)

from orchestrator.errors import ScenarioError
from orchestrator.evaluation.schema import Strict
from orchestrator.quantities.quantity import parse_period

FIGURES = {
    "phase_margin_deg": "deg",
    "gain_margin_db": "1",
    "modulus_margin": "1",
    "delay_margin_s": "s",
    "crossover_hz": "Hz",
    "s_max": "1",
}
FIGURES_OF_TRANSFER = ("peak", "peak_hz", "bandwidth_hz")

Names = tuple[str, ...]


def _lowest(value: Any) -> Fraction:
    if isinstance(value, int | float | Decimal):
        raise ValueError(
            f'{value} has no unit: write "{value} Hz" for the lowest line, or '
            f'"{value} s" for its period'
        )
    return parse_period(value)


class ResponseSpec(Strict):
    """A loop broken at outputs (``break``), or what ``excite`` makes of ``observe``:
    the rms injected, in its unit or with its own, or ``auto``; the lowest line
    (``from``, a rate); the form of excitation."""

    breaks: Names = Field(default=(), alias="break")
    excite: Names = ()
    observe: Names = ()
    amplitude: float | str = "auto"
    lowest: Annotated[Fraction, PlainValidator(_lowest), PlainSerializer(str)] = Field(
        default=Fraction(1), alias="from"
    )  # its period (s)
    excitation: Literal["multisine", "chirp", "stepped"] = "multisine"

    @field_validator("breaks", "excite", "observe", mode="before")
    @classmethod
    def _one_or_several(cls, value: Any) -> Any:
        if isinstance(value, str):
            return (value,)
        return tuple(value) if isinstance(value, list) else value

    @model_validator(mode="after")
    def _a_loop_or_a_way(self) -> "ResponseSpec":
        if bool(self.breaks) == bool(self.excite or self.observe):
            raise ValueError(
                'say either break = "component.output", or both excite = '
                '"component.input" and observe = "component.output"'
            )
        if bool(self.excite) != bool(self.observe):
            lacking = "observe" if self.excite else "excite"
            raise ValueError(f"{lacking} is missing: from where to where?")
        return self

    @property
    def injected(self) -> Names:
        """Where something is added."""
        return self.breaks or self.excite

    @property
    def named(self) -> Mapping[str, Names]:
        """All variables it names, by key."""
        return {"break": self.breaks, "excite": self.excite, "observe": self.observe}

    @property
    def figures(self) -> Sequence[str]:
        """The figures that can be expected of it."""
        return tuple(FIGURES) if self.breaks else FIGURES_OF_TRANSFER


def response_of(
    breaks: Sequence[str],
    excite: Sequence[str],
    observe: Sequence[str],
    amplitude: str,
    lowest: str,
    excitation: str,
) -> ResponseSpec:
    """Return what the options of a command say; a bare ``lowest`` is in hertz.

    Raises:
        ScenarioError: one of them is malformed.
    """
    if bool(breaks) == bool(excite or observe) or bool(excite) != bool(observe):
        raise ScenarioError(
            "say either --break component.output, or both --excite component.input "
            "and --observe component.output"
        )
    keys = {"break": tuple(breaks), "excite": tuple(excite), "observe": tuple(observe)}
    more = {"amplitude": amplitude, "from": _hertz(lowest), "excitation": excitation}
    try:
        return ResponseSpec.model_validate({**keys, **more})
    except ValidationError as error:
        first = error.errors()[0]
        raise ScenarioError(f"--{first['loc'][0]}: {first['msg']}") from None


def _hertz(written: str) -> str:
    return written if written.strip()[-1:].isalpha() else f"{written} Hz"
