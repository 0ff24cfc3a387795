"""What makes a check clean: no error, and every item tried to its end."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fmus.build import build
from orchestrator.checks import check_fmu
from orchestrator.checks.item import CannotRun, Finding, Item, NotApplicable, Said

STOPS: dict[str, Any] = {
    "nothing": None,
    "cannot run": CannotRun("the rest was not tried"),
    "a fault": ZeroDivisionError("x"),
    "not applicable": NotApplicable("no such thing"),
}
VERDICTS = {  # said before it stopped, why it stopped: verdict, clean
    ("", "nothing"): ("pass", True),
    ("", "cannot run"): ("could not be run", False),
    ("", "not applicable"): ("not applicable", True),
    ("advice", "nothing"): ("finding", True),
    ("advice", "cannot run"): ("could not be run", False),
    ("advice", "a fault"): ("could not be run", False),
    ("error", "nothing"): ("finding", False),
    ("error", "cannot run"): ("finding", False),
}


@pytest.mark.parametrize(("said", "stop"), VERDICTS)
def test_advice_does_not_hide_that_the_rest_was_not_tried(
    said: str, stop: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stage(_archive: Any) -> Iterator[Said]:
        if said:
            yield Finding("it could be better", said)  # type: ignore[arg-type]
        if STOPS[stop] is not None:
            raise STOPS[stop]

    item = Item(900, "static", "of this test", "FMI 2.0", "mend it", (stage,))
    monkeypatch.setattr("orchestrator.checks.engine.catalogue", lambda: [item])
    report = check_fmu(Path(build("plants.ball_screw.two_mass")), dynamic=False)
    (outcome,) = report.outcomes
    assert (outcome.verdict, report.clean) == VERDICTS[said, stop]
    told = report.to_json()["items"][0]
    assert bool(told["reason"]) == (stop != "nothing")
    assert told["reason"] in report.to_junit().decode()
