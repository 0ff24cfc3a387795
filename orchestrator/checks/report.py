"""What came of a check: as JSON, as JUnit XML, and how it ends."""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from lxml import etree

from orchestrator.checks.archive import Archive
from orchestrator.checks.item import CannotRun, Item, Outcome, Verdict

VERDICTS: tuple[Verdict, ...] = (
    "pass",
    "finding",
    "not applicable",
    "could not be run",
)


@dataclass(frozen=True)
class Report:
    """The outcomes of all items that were tried, by number."""

    fmu: Path
    outcomes: tuple[Outcome, ...]

    @cached_property
    def major(self) -> int | None:
        """The version of FMI, 2 or 3, where the FMU tells it."""
        try:
            return Archive(self.fmu).major
        except (CannotRun, AttributeError):
            return None

    def clause(self, item: Item) -> str:
        """Where the FMU's own version of the standard asks for an item."""
        other = {2: "FMI 3.", 3: "FMI 2."}.get(self.major or 0)
        parts = item.clause.split("; ")
        own = [part for part in parts if other is None or not part.startswith(other)]
        return "; ".join(own or parts)

    @property
    def notes(self) -> list[str]:
        """What was only sampled or cut short, in any item."""
        said = (note for outcome in self.outcomes for note in outcome.notes)
        return list(dict.fromkeys(said))

    @property
    def counts(self) -> dict[str, int]:
        """How often there was each verdict."""
        found = Counter(outcome.verdict for outcome in self.outcomes)
        return {verdict: found[verdict] for verdict in VERDICTS}

    @property
    def clean(self) -> bool:
        """Whether nothing violates the standard and everything could be tried."""
        return not any(
            outcome.verdict == "could not be run"
            or any(f.severity == "error" for f in outcome.findings)
            for outcome in self.outcomes
        )

    def to_json(self) -> dict[str, Any]:
        """Return the object that ``check --json`` prints."""
        return {
            "fmu": str(self.fmu),
            "clean": self.clean,
            "counts": self.counts,
            "items": [
                _item(outcome, self.clause(outcome.item)) for outcome in self.outcomes
            ],
        }

    def to_junit(self) -> bytes:
        """Return a JUnit document: one test case per item."""
        suite = etree.Element(
            "testsuite",
            name=f"feeddrive check {self.fmu.name}",
            tests=str(len(self.outcomes)),
            failures=str(self.counts["finding"]),
            errors=str(self.counts["could not be run"]),
            skipped=str(self.counts["not applicable"]),
        )
        kinds = {
            "finding": "failure",
            "could not be run": "error",
            "not applicable": "skipped",
        }
        for outcome in self.outcomes:
            item = outcome.item
            name = f"{item.number} {item.part}: {item.title}"
            case = etree.SubElement(
                suite, "testcase", name=name, classname=self.fmu.stem
            )
            if outcome.verdict == "pass":
                continue
            lines = [f"{f.severity}: {f.text}" for f in outcome.findings]
            lines += [f"not tried to the end: {outcome.reason}"] * bool(outcome.reason)
            text = outcome.reason or f"{self.clause(item)}: {item.mend}"
            told = etree.SubElement(case, kinds[outcome.verdict], message=_plain(text))
            told.text = _plain("\n".join(lines))
        document: bytes = etree.tostring(
            suite, xml_declaration=True, encoding="UTF-8", pretty_print=True
        )
        return document


def _item(outcome: Outcome, clause: str) -> dict[str, Any]:
    item = outcome.item
    return {
        "number": item.number,
        "part": item.part,
        "title": item.title,
        "clause": clause,
        "verdict": outcome.verdict,
        "seen": outcome.seen,
        "notes": outcome.notes,
        "findings": [
            {"text": f.text, "severity": f.severity, "mend": f.mend or item.mend}
            for f in outcome.findings
        ],
        "reason": outcome.reason,
    }


def _plain(text: str) -> str:
    """Drop the characters that XML cannot hold; FMUs log what they like."""
    return "".join(c for c in text if c.isprintable() or c in "\n\t")
