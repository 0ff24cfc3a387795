"""A sine of one frequency in recorded rows, alone or over that of another signal."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.evaluation.spectrum import unseen
from orchestrator.quantities.quantity import NoValue, Quantity
from orchestrator.quantities.unit import Unit, quotient_unit

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class Sine:
    """The sine of ``hertz`` in rows at times (s) and values (n,) in a unit."""

    time: Array
    values: Array
    hertz: float
    unit: Unit

    def figures(self) -> dict[str, Quantity]:
        """Return amplitude and phase, without values if its rows do not show it."""
        if why := unseen(self.time, self.hertz):
            none = NoValue("deg", why=why)
            return {"amplitude": NoValue(self.unit, why=why), "phase": none}
        c = self._fitted()
        return {"amplitude": Quantity(abs(c), self.unit), "phase": _phase(c)}

    def over(self, base: "Sine", unit: str | None, name: str) -> dict[str, Quantity]:
        """Return ratio (in ``unit``) and phase over a signal's, called ``name``."""
        of_both = quotient_unit(self.unit, base.unit.of_difference())
        why = unseen(self.time, self.hertz)
        below = 0.0 if why else base._fitted()
        if below == 0:
            why = why or f"{name} has no component at {self.hertz:g} Hz"
            none = NoValue(of_both, why=why)
            return {"ratio": none.to(unit), "phase": NoValue("deg", why=why)}
        c = self._fitted() / below
        return {"ratio": Quantity(abs(c), of_both).to(unit), "phase": _phase(c)}

    def _fitted(self) -> complex:
        return sine_fit(self.time, self.values, self.hertz)


def sine_fit(time: Array, y: Array, hertz: float) -> complex:
    """Return the complex amplitude c of y ~ Im(c exp(j w t)) + mean, least squares."""
    angle = 2 * np.pi * hertz * time
    columns = np.column_stack([np.sin(angle), np.cos(angle), np.ones_like(time)])
    (real, imaginary, _), *_ = np.linalg.lstsq(columns, y, rcond=None)
    return complex(real, imaginary)


def _phase(c: complex) -> Quantity:
    return Quantity(float(np.angle(c, deg=True)), "deg")
