"""Tables of numbers and of matrices against NumPy's own interpolation."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.table import lookup, lookup_rows, slopes
from fmus.trace import numpy_on_symbols

POINTS = np.array([0.2, 0.25, 0.4, 0.6])
MATRICES = np.random.default_rng(3).normal(size=(4, 2, 3))
ROWS = MATRICES.reshape(8, 3)


def expected(x):
    flat = MATRICES.reshape(4, 6)
    return np.array([np.interp(x, POINTS, v) for v in flat.T]).reshape(2, 3)


@given(st.floats(0, 1))
def test_matrices_are_interpolated_element_by_element_and_held_beyond_the_ends(x):
    for slope in (None, slopes(POINTS, ROWS)):
        got = lookup_rows(x, POINTS, ROWS, slope)
        assert got == pytest.approx(expected(x), abs=1e-15)


def test_a_table_of_matrices_gives_the_same_on_symbols():
    with numpy_on_symbols():
        x, rows, points = ca.SX.sym("x"), ca.SX.sym("r", 8, 3), ca.SX.sym("p", 4)
        slope = slopes(points, rows)
        traced = [
            lookup_rows(x, POINTS, ROWS),
            lookup_rows(x, points, rows),
            lookup_rows(x, points, rows, slope),
        ]
        function = ca.Function("f", [x, points, rows], traced)
    for value in (0.1, 0.2, 0.33, 0.6, 0.7):
        for got in function(value, POINTS, ROWS):
            assert got.full() == pytest.approx(expected(value), abs=1e-15)


def test_a_matrix_of_one_row_and_one_column_is_a_lookup_of_numbers():
    values = np.array([1.0, -2.0, 0.5, 4.0])
    for x in (0.1, 0.22, 0.5):
        assert lookup_rows(x, POINTS, values[:, None])[0, 0] == lookup(
            x, POINTS, values
        )


@pytest.mark.parametrize("rows", [np.zeros((7, 3)), np.zeros(8), np.zeros((4, 2, 3))])
def test_rows_that_the_breakpoints_cannot_share_out_are_refused(rows):
    with pytest.raises(ValueError, match="one below the other: 4 points"):
        lookup_rows(0.3, POINTS, rows)


def test_one_point_is_no_table():
    with pytest.raises(ValueError, match="2 to 256 points, not 1"):
        lookup_rows(0.3, POINTS[:1], ROWS[:2])
