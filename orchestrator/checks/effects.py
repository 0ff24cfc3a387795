"""What moving a known did to unknowns, against what was declared.

The kinds constant, fixed and tunable say that an unknown is the known times a
factor that only parameters change, plus a rest.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from orchestrator.checks.instance import Row
from orchestrator.checks.item import Finding, Said
from orchestrator.checks.moment import Known, Unknown

Values: TypeAlias = dict[str, Row]

SAME_FACTOR = 1e-4
NOISE = 1e-9  # of a value's size
# Whose values may differ from those at first without changing a factor of the kind.
MAY_DIFFER = {"tunable": (), "fixed": ("tunable",), "constant": ("tunable", "fixed")}


@dataclass
class Effects:
    """Knowns by the unknown that they change undeclared."""

    of: dict[str, set[str]] = field(default_factory=dict)

    def add(self, unknown: str, known: str) -> None:
        """Add that an unknown changed with a known it does not list."""
        self.of.setdefault(unknown, set()).add(known)

    def compare(
        self, known: str, unknowns: Iterable[Unknown], before: Values, after: Values
    ) -> None:
        """Add every unknown that differs and does not list the known."""
        for unknown in unknowns:
            one, other = before[unknown.name], after[unknown.name]
            if known not in (unknown.kinds or {}) and not np.array_equal(
                one, other, equal_nan=True
            ):
                self.add(unknown.name, known)

    def told(self, text: str, where: str = "InitialUnknowns") -> Iterator[Said]:
        """Tell them; ``text`` has places for unknown, knowns and where to list."""
        for name, found in self.of.items():
            listed = ", ".join(sorted(found))
            yield Finding(f"{text.format(name, listed, where)} list")


@dataclass
class Factors:
    """Factors measured, by unknown and known, each with what was different."""

    of: dict[tuple[str, str], list[tuple[str, Row, Row]]] = field(default_factory=dict)

    def add(
        self, different: str, known: Known, delta: float, one: Values, other: Values
    ) -> None:
        """Add those between the values before and after a change by ``delta``."""
        for name, value in other.items():
            size = np.maximum(np.abs(value), np.abs(one[name]))
            entry = (value - one[name]) / delta, NOISE * size / abs(delta)
            self.of.setdefault((name, known.name), []).append((different, *entry))

    def told(self, unknowns: Iterable[Unknown], by: str) -> Iterator[Said]:
        """Tell which factors do not keep to their kind.

        All are zero where a co-simulation does not show an input at once.
        """
        kinds = {u.name: u.kinds or {} for u in unknowns}
        for (name, known), measured in self.of.items():
            kind = kinds[name].get(known, "")
            if kind not in MAY_DIFFER:
                continue
            allowed = ("", *MAY_DIFFER[kind])
            rows = [row for row in measured if row[0] in allowed]
            factors = np.array([factor for _, factor, _ in rows])
            noise = np.max([noise for *_, noise in rows], axis=0)
            if not np.isfinite(factors).all():
                continue
            spread = np.ptp(factors, axis=0)
            bad = spread > SAME_FACTOR * np.max(np.abs(factors), axis=0) + noise
            if bad.any():
                column = factors[:, int(np.argmax(bad))]
                yield Finding(
                    f"{by} d {name} / d {known} is between {column.min():.6g} and "
                    f"{column.max():.6g}, but dependenciesKind is {kind}"
                )
