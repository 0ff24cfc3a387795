"""What is recorded how often: a single line wins over a star, --set over both."""

from fractions import Fraction

import pytest
from systems import MODELS

from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario

LINES = {"one": '"c.k" = "1/1000"', "star": '"c.*" = "1/50"'}


def rows(folder, order, *overrides):
    """Return the periods of c.k, and those of another signal."""
    file = folder / "record.toml"
    file.write_text(
        f'stop = "1/10"\n[components.c]\nfmu = "{(MODELS / "counter.py").as_posix()}"\n'
        "[record]\n" + "\n".join(LINES[line] for line in order)
    )
    record = compose(load_scenario(file, overrides), None).system.record
    return record["c.k"], record.get("c.t")


@pytest.mark.parametrize("order", [("one", "star"), ("star", "one")])
def test_a_star_takes_no_rate_from_a_single_line_wherever_it_stands(tmp_path, order):
    assert rows(tmp_path, order) == ((Fraction(1, 1000),), (Fraction(1, 50),))


def test_set_is_last_for_a_single_line_and_for_a_star(tmp_path):
    fast, slow, set_ = (Fraction(1), Fraction(1, 50), Fraction(1, 500))
    one = rows(tmp_path, ("star",), "record.c.k=1/500")
    assert one == ((set_,), (slow,))
    star = rows(tmp_path, ("one",), "record.c.*=1/500")
    assert star == ((set_,), (set_,))
    both = rows(tmp_path, ("one", "star"), "record.c.k=1", "record.c.*=1/500")
    assert both == ((fast,), (set_,))
