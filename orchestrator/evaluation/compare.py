"""How figures of runs are written beside each other."""

from collections.abc import Mapping

from orchestrator.quantities.quantity import NoValue, Quantity

ROUND_OFF = 1e-9  # of what it stands beside: a figure that small is nothing
LARGEST = 1e6  # % of change that are still written as a number


def number(figure: Quantity, digits: int = 6) -> str:
    """Return a figure's number without its unit, or ``none``."""
    return "none" if isinstance(figure, NoValue) else f"{figure.value:.{digits}g}"


def change(
    name: str, before: Mapping[str, Quantity], after: Mapping[str, Quantity]
) -> str:
    """Return by how much a figure changed, in per cent of what it was.

    Nothing is said where it has no meaning: one of the two is missing or has no
    value, the first is zero, or both are round-off, less than a billionth of the
    largest figure of the same metric in the same unit (the mean beside the peak).
    """
    first, second = before.get(name), after.get(name)
    if first is None or second is None:
        return ""
    unit = first.unit
    old, new = first.value, second.to(unit).value
    if not old or NoValue in (type(first), type(second)):
        return ""
    if max(abs(old), abs(new)) < ROUND_OFF * _largest_beside(name, unit, before, after):
        return ""
    share = 100 * (new / old - 1)
    if abs(share) > LARGEST:
        return f"> {LARGEST:.0e} %" if share > 0 else f"< -{LARGEST:.0e} %"
    return f"{share:+z.2f} %" if abs(share) < 1e4 else f"{share:+.3g} %"


def _largest_beside(name: str, unit: str, *runs: Mapping[str, Quantity]) -> float:
    metric = name.rpartition(".")[0]
    return max(
        (
            abs(figure.value)
            for figures in runs
            for other, figure in figures.items()
            if other.rpartition(".")[0] == metric
            and figure.unit == unit
            and not isinstance(figure, NoValue)
        ),
        default=0.0,
    )
