"""What a source says, as data: which values keep to it."""

import pytest
from pydantic import ValidationError

from orchestrator.reproduction.published import Statement, judge

OTHERS = {"half": 0.5, "two": 2.0, "lost": None}


@pytest.mark.parametrize(
    ("published", "value", "verdict"),
    [
        (100, 104.9, "agrees"),
        (100, 105.1, "differs"),
        (-100, -104.9, "agrees"),
        (0.0, 0.0, "agrees"),
        (0.0, 1e-9, "differs"),
        (None, 1.0, "computed"),
        ("drawn", 1.0, "out of reach"),
        (100, None, "out of reach"),
        ({"below": 10}, 9.9, "agrees"),
        ({"below": 10}, 10.0, "contradicts"),
        ({"above": 1}, 1.0, "contradicts"),
        ({"above": 1}, 1.1, "agrees"),
        ({"between": [160, 250]}, 160.0, "agrees"),
        ({"between": [160, 250]}, 159.9, "contradicts"),
        ({"equals": "two"}, 2.09, "agrees"),
        ({"equals": "two"}, 2.11, "contradicts"),
        ({"equals": "two", "factor": 0.5}, 1.04, "agrees"),
        ({"less_than": "two"}, 1.99, "agrees"),
        ({"less_than": "two"}, 2.0, "contradicts"),
        ({"less_than": "two", "factor": 0.5}, 1.1, "contradicts"),
        ({"less_than": "two", "percent": 40}, 1.19, "agrees"),
        ({"less_than": "two", "percent": 40}, 1.21, "contradicts"),
        ({"greater_than": "two", "percent": 40}, 2.79, "contradicts"),
        ({"greater_than": "two", "factor": 3}, 6.1, "agrees"),
        ({"less_than": "lost"}, 1.0, "out of reach"),
    ],
)
def test_a_value_is_judged_by_what_is_published(published, value, verdict):
    said = Statement(**published) if isinstance(published, dict) else published
    assert judge(said, value, OTHERS, 0.05) == verdict


def test_half_of_the_last_printed_digit_counts_as_agreement():
    assert judge(0.0, 0.004, {}, 0.05, rounded=0.01) == "agrees"
    assert judge(0.0, 0.006, {}, 0.05, rounded=0.01) == "differs"


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"says": "flat"},
        {"below": 1, "above": 0},
        {"between": [2, 1]},
        {"below": 1, "factor": 2},
        {"less_than": "two", "factor": 2, "percent": 3},
        {"equals": "two", "percent": 3},
    ],
)
def test_a_statement_says_exactly_one_thing(wrong):
    with pytest.raises(ValidationError):
        Statement(**wrong)
