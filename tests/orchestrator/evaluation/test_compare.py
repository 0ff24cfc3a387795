"""A change is said where it means something, and only there."""

import pytest

from orchestrator.evaluation.compare import change
from orchestrator.quantities.quantity import NoValue, Quantity


def told(before: Quantity, after: Quantity, peak: float = 0.0) -> str:
    beside = {"m.peak": Quantity(peak, "um"), "other.peak": Quantity(1e9, "um")}
    return change("m.mean", beside | {"m.mean": before}, beside | {"m.mean": after})


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        (Quantity(2.0, "um"), Quantity(3.0, "um"), "+50.00 %"),
        (Quantity(2.0, "um"), Quantity(3e-3, "mm"), "+50.00 %"),
        (Quantity(2.0, "um"), Quantity(2.0, "um"), "+0.00 %"),
        (Quantity(0.0, "um"), Quantity(3.0, "um"), ""),
        (Quantity(1.0, "um"), Quantity(321.0, "um"), "+3.2e+04 %"),
        (Quantity(1.0, "um"), Quantity(4.7e271, "um"), "> 1e+06 %"),
        (Quantity(1.0, "um"), Quantity(-4.7e271, "um"), "< -1e+06 %"),
        (Quantity(1e-300, "um"), Quantity(4.7e271, "um"), "> 1e+06 %"),
        (Quantity(1.0, "um"), NoValue("um", why="not settled"), ""),
        (NoValue("um", why="not settled"), Quantity(1.0, "um"), ""),
    ],
)
def test_a_change_is_in_per_cent_of_what_it_was(
    before: Quantity, after: Quantity, text: str
) -> None:
    assert told(before, after) == text


def test_round_off_beside_its_own_peak_is_no_change() -> None:
    small, smaller = Quantity(2.6e-11, "um"), Quantity(1.6e-12, "um")
    assert told(small, smaller) == "-93.85 %"
    assert told(small, smaller, peak=2.5) == ""
    assert told(small, Quantity(0.1, "um"), peak=2.5) == "> 1e+06 %"
