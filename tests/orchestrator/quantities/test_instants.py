"""Sets of instants meet exactly where enumeration says they do."""

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from orchestrator.quantities.instants import Instants

periods = st.builds(Fraction, st.integers(1, 12), st.integers(1, 30))
firsts = st.builds(Fraction, st.integers(0, 20), st.integers(1, 30))
sets = st.builds(Instants, periods, firsts)
STOP = Fraction(200)


def enumerated(instants: Instants, stop: Fraction = STOP) -> list[Fraction]:
    return [
        instants.first + k * instants.period
        for k in range(int((stop - instants.first) / instants.period) + 1)
    ]


@given(sets, sets)
def test_the_common_instants_are_those_of_both(a: Instants, b: Instants) -> None:
    expected = sorted(set(enumerated(a)) & set(enumerated(b)))
    common = a.common(b)
    assert (enumerated(common) if common else []) == expected
    if common:
        start, end = Fraction(7, 3), Fraction(100)
        inside = [t for t in expected if start <= t <= end]
        assert common.within(start, end) == len(inside)
        assert Instants.read(str(common)) == common


@given(sets, periods)
def test_rows_are_found_by_the_bits_of_their_times(a: Instants, row: Fraction) -> None:
    """Times as the recorder writes them: float(k * tick), whatever the tick."""
    exact = enumerated(Instants(row), Fraction(20))
    found = a.among(np.array([float(t) for t in exact]))
    assert found.tolist() == [
        t >= a.first and (t - a.first) % a.period == 0 for t in exact
    ]
