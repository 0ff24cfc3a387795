"""``[responses]``: which loops of a scenario are measured, where and how."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    PlainSerializer,
    PlainValidator,
    ValidationError,
    field_validator,
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


class ResponseSpec(Strict):
    """A loop broken at outputs (``break``): the rms injected, in their unit or with
    its own, or ``auto``; the lowest line (``from``, a rate); the form of excitation."""

    breaks: tuple[str, ...] = Field(alias="break", min_length=1)
    amplitude: float | str = "auto"
    lowest: Annotated[Fraction, PlainValidator(parse_period), PlainSerializer(str)] = (
        Field(default=Fraction(1), alias="from")
    )  # its period (s)
    excitation: Literal["multisine", "chirp", "stepped"] = "multisine"

    @field_validator("breaks", mode="before")
    @classmethod
    def _one_or_several(cls, value: Any) -> Any:
        if isinstance(value, str):
            return (value,)
        return tuple(value) if isinstance(value, list) else value


def response_of(
    breaks: Sequence[str], amplitude: str, lowest: str, excitation: str
) -> ResponseSpec:
    """Return what the options of a command say.

    Raises:
        ScenarioError: one of them is malformed.
    """
    keys = {"break": tuple(breaks), "amplitude": amplitude, "from": lowest}
    try:
        return ResponseSpec.model_validate({**keys, "excitation": excitation})
    except ValidationError as error:
        first = error.errors()[0]
        name = first["loc"][0] if first["loc"] else "response"
        raise ScenarioError(f"--{name}: {first['msg']}") from None
