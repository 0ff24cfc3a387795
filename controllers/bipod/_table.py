"""Tables of sampled systems over the angle of the rods, run at any sample time.

    (x⁺, u) = K(φ, ẋ_1) (x, y),     ν = u/(W_v m_0)

Linear between the breakpoints in φ, as the plant affine in ẋ_1, held beyond the ends.
A design's breakpoints are ``phi`` (rad), (n,), and ``v_1`` (m/s), two.  Its matrices
are those of Tustin's rule at ``T_0``; at T_s = r T_0 the same continuous system has

    A' = M⁻¹((1+r)A + (1-r)I),   B' = 2r M⁻¹B,   C' = 2C M⁻¹,   D' = D - (1-r) C M⁻¹B,
    M = (1+r)I + (1-r)A

which is A, B, C, D to the last bit where r = 1.  The source states no sample time.
Source: Hanifzadegan 2014, eq. 7.16 to 7.21.
"""

import json
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers._scheduled import period, system
from fmus.model import FloatArray, Var
from fmus.table import lookup_rows, slopes


class Table(NamedTuple):
    """Systems at angles, each at two speeds, one matrix below the other."""

    phi: Annotated[FloatArray, Var("rad", "angles of the table", fixed=True)]
    v_1: Annotated[FloatArray, Var("m/s", "slowest and fastest speed", fixed=True)]
    K: Annotated[FloatArray, Var("1", "[A B; C D] at each of them", fixed=True)]
    T_0: Annotated[float, Var("s", "sample time of the table", min=1e-9, fixed=True)]
    unit: Annotated[float, Var("m/s2", "ν where u is 1", fixed=True)]


class Slopes(NamedTuple):
    """Of the matrices over the angle."""

    K: Any


def table(file: bytes) -> Table:
    """Return the table in a file of JSON."""
    design = json.loads(file)
    weights = design["design"]["weights"]
    return Table(
        np.array(design["phi"]),
        np.array(design["v_1"]),
        system(design),
        float(period(file)),
        1 / (weights["W_v"] * weights["m_0"]),
    )


def order(t: Table) -> int:
    """Return how many states a table's systems have."""
    return int(t.K.shape[1]) - 1


def prepare(p: Table) -> Slopes:
    """Return the slopes over the angle."""
    return Slopes(slopes(p.phi, p.K))


def at(phi: Any, v_1: Any, p: Table, d: Slopes, T_s: Any) -> Any:
    """Return [A B; C D] for T_s (s) at an angle (rad) and a speed (m/s)."""
    K = lookup_rows(v_1, p.v_1, lookup_rows(phi, p.phi, p.K, d.K))
    return resampled(K, T_s / p.T_0)


def resampled(K: Any, r: Any) -> Any:
    """Return [A B; C D] of the same continuous system at r times the sample time."""
    n = K.shape[1] - 1
    A, B, C, D = K[:n, :n], K[:n, n:], K[n:, :n], K[n:, n:]
    eye = np.eye(n)
    inverse = inverted((1 + r) * eye + (1 - r) * A)
    along = np.concatenate([inverse @ ((1 + r) * A + (1 - r) * eye), 2 * C @ inverse])
    across = np.concatenate([2 * r * inverse @ B, D - (1 - r) * C @ inverse @ B])
    return np.concatenate([along, across], axis=1)


def inverted(M: Any) -> Any:
    """Return M⁻¹ by elimination without pivots, for M near a multiple of I."""
    n = M.shape[0]
    eye = np.eye(n)
    both = np.concatenate([M, eye], axis=1)
    for k in range(n):
        pivot = both[k : k + 1, :] / both[k, k]
        both = both - (both[:, k : k + 1] - eye[:, k : k + 1]) @ pivot
    return both[:, n:]
