"""Newton's method for circles, in plain operations of doubles.

What comes back are the bits of ``native/fused/circle.h``, which does the same in
lanes and inside exported FMUs: the same operations in the same order, no library.
"""

from collections.abc import Callable, Sequence

TOLERANCE = 1e-12
SHIFT = 2.0**-26  # of a number, or of 1: for differences
NOISE = 2.0**-20  # of numbers that cancel in a difference of differences
ROUNDS, HALVINGS = 50, 20
INFINITE = float("inf")

Numbers = list[float]


class Refused(Exception):
    """What is asked for cannot be evaluated, or gives what is not finite."""


def newton(
    around: Callable[[Sequence[float]], Sequence[float]],
    start: Sequence[float],
    tolerance: float = TOLERANCE,
) -> Numbers | None:
    """Return z with around(z) = z up to the tolerance; None if it is not found.

    Jacobians by differences forward; a step is halved until the largest deviation
    falls.  ``around`` was called last with what is returned.

    Raises:
        Refused: ``around`` raised it at the start or near an iterate.
    """
    z = list(start)
    after = around(z)
    for _ in range(ROUNDS):
        if settled(z, after, tolerance):
            return z
        off = [g - one for g, one in zip(after, z, strict=True)]
        step = _solved(_rows(around, z, off))
        found = step and _nearer(around, z, off, step, tolerance)
        if not found:
            return None
        z, after = found
    return None


def settled(
    before: Sequence[float], after: Sequence[float], tolerance: float = TOLERANCE
) -> bool:
    """Tell whether numbers are the same up to the tolerance."""
    return all(
        abs(g - z) <= tolerance * max(1.0, abs(z))
        for z, g in zip(before, after, strict=True)
    )


def _rows(
    around: Callable[[Sequence[float]], Sequence[float]], z: Numbers, off: Numbers
) -> list[Numbers]:
    """Return the rows of the Jacobian of around(z) - z, each followed by -off."""
    rows: list[Numbers] = [[] for _ in z]
    for j in range(len(z)):
        beside = z.copy()
        beside[j] = z[j] + SHIFT * max(1.0, abs(z[j]))
        after, width = around(beside), beside[j] - z[j]
        for i, row in enumerate(rows):
            row.append(((after[i] - beside[i]) - off[i]) / width)
    return [[*row, -one] for row, one in zip(rows, off, strict=True)]


def _solved(rows: list[Numbers]) -> Numbers | None:
    """Return the solution of linear equations, by elimination; None if singular.

    What is left of larger numbers that cancel is noise of the differences, and no
    pivot: a loop without a solution would be "solved" far away from everything.
    """
    n = len(rows)
    sizes = [
        [max(abs(one), float(i == j)) for j, one in enumerate(row[:n])]
        for i, row in enumerate(rows)
    ]
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(rows[i][k]) > abs(rows[pivot][k]):
                pivot = i
        rows[k], rows[pivot] = rows[pivot], rows[k]
        sizes[k], sizes[pivot] = sizes[pivot], sizes[k]
        if not NOISE * sizes[k][k] < abs(rows[k][k]) < INFINITE:
            return None
        for i in range(k + 1, n):
            share = rows[i][k] / rows[k][k]
            for j in range(k, n + 1):
                taken = share * rows[k][j]
                rows[i][j] = rows[i][j] - taken
                if j < n and abs(taken) > sizes[i][j]:
                    sizes[i][j] = abs(taken)
    found = [0.0] * n
    for i in reversed(range(n)):
        rest = rows[i][n]
        for j in range(i + 1, n):
            rest = rest - rows[i][j] * found[j]
        found[i] = rest / rows[i][i]
    return found


def _nearer(
    around: Callable[[Sequence[float]], Sequence[float]],
    z: Numbers,
    off: Numbers,
    step: Numbers,
    tolerance: float,
) -> tuple[Numbers, Sequence[float]] | None:
    """Return where a step, halved if need be, leads nearer, and what is around it."""
    most, share = max(map(abs, off)), 1.0
    for _ in range(HALVINGS):
        trial = [one + share * s for one, s in zip(z, step, strict=True)]
        share = share / 2
        try:
            after = around(trial)
        except Refused:  # far from a solution anything may be
            continue
        far = max(abs(g - one) for g, one in zip(after, trial, strict=True))
        if far < most or settled(trial, after, tolerance):
            return trial, after
    return None
