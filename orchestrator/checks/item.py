"""What a check is: a numbered item, its function, and what it says.

Numbers are those of the checklist; a number may have a static item (reads the
archive) and a dynamic one (runs the FMU, in a process of its own).  A function
yields what it saw: a text, or a ``Finding`` where the FMU is at fault.  It
raises ``NotApplicable`` or ``CannotRun`` with the reason.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

Part: TypeAlias = Literal["static", "dynamic"]
Severity: TypeAlias = Literal["error", "advice"]
Verdict: TypeAlias = Literal["pass", "finding", "not applicable", "could not be run"]

WORDS = ("String", "Binary", "Clock")  # types that hold no numbers


@dataclass(frozen=True)
class Finding:
    """A fault: against the standard (error), or what its guide advises.

    ``mend`` replaces the item's own remedy.
    """

    text: str
    severity: Severity = "error"
    mend: str = ""


def advice(text: str, mend: str = "") -> Finding:
    """Return a finding that is no violation, but will cost a user time."""
    return Finding(text, "advice", mend)


class NotApplicable(Exception):
    """The FMU has nothing that the item could look at."""


class CannotRun(Exception):
    """The item could not be carried out here."""


Said: TypeAlias = str | Finding
Checker: TypeAlias = Callable[..., Iterator[Said]]
Register: TypeAlias = Callable[[Checker], Checker]


@dataclass(frozen=True)
class Item:
    """One check: where the standard asks for it, and how a fault is mended.

    ``stages`` run one after the other, dynamic ones each in a fresh process; the
    first takes the subject, the next also what the one before it kept.
    ``seconds`` of computing limit each as a whole.
    """

    number: int
    part: Part
    title: str
    clause: str
    mend: str
    stages: tuple[Checker, ...]
    seconds: float = 60.0

    @property
    def key(self) -> str:
        return f"{self.number}{'S' if self.part == 'static' else 'D'}"


@dataclass
class Outcome:
    """What came of one item.

    ``seen`` are observations, ``findings`` faults; ``notes`` tell what was only
    sampled, or cut short; ``reason`` why an item did not apply or could not be run.
    """

    item: Item
    seen: list[str] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    reason: str = ""
    verdict: Verdict = "pass"


REGISTRY: dict[str, Item] = {}


def static(number: int, title: str, clause: str, mend: str) -> Register:
    """Register a function of an ``Archive`` as the static item of a number."""

    def register(function: Checker) -> Checker:
        item = Item(number, "static", title, clause, mend, (function,))
        REGISTRY[item.key] = item
        return function

    return register


def dynamic(
    number: int,
    title: str,
    clause: str,
    mend: str,
    *,
    then: Checker | None = None,
    seconds: float = 60.0,
) -> Register:
    """Register a function of a ``Laboratory`` as the dynamic item of a number.

    ``then`` is run in another process with what the first put in ``lab.kept``.
    """

    def register(function: Checker) -> Checker:
        stages = (function,) if then is None else (function, then)
        item = Item(number, "dynamic", title, clause, mend, stages, seconds)
        REGISTRY[item.key] = item
        return function

    return register
