"""The timetable picture follows values as the ages of the schedule say."""

from dataclasses import replace
from fractions import Fraction
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from random_systems import systems
from systems import part, system

from orchestrator.errors import FeedDriveError
from orchestrator.master.ages import explained
from orchestrator.master.simulate import plan
from orchestrator.pictures.passing import passing
from orchestrator.pictures.timetable import timetable_picture
from orchestrator.system import System


@settings(max_examples=50, deadline=None)
@given(systems())
def test_the_least_and_greatest_ages_seen_are_those_of_the_schedule(
    given_system: System,
) -> None:
    try:
        timetable = plan(replace(given_system, stop=Fraction(1, 5)))
    except FeedDriveError:
        return
    shown, tick = passing(timetable), timetable.schedule.tick
    assert shown.whole
    for edge, age in zip(
        timetable.wiring.edges, explained(timetable).ages, strict=True
    ):
        seen = [
            (taken.at - taken.stems) * tick
            for taken in shown.taken
            if (taken.source, taken.sink) == (edge.source, edge.sink)
        ]
        assert (min(seen), max(seen)) == (age.youngest, age.oldest)


def two_rates(controller: str, plant: str, latency: int = 0) -> System:
    parts = [
        part("controller", "counter", controller, latency=latency),
        part("plant", "integrator", plant),
    ]
    return system("1/20", parts, {"plant.u": "controller.rate"})


def test_125_and_200_us_split_steps_and_repeat_after_1_ms() -> None:
    timetable = plan(two_rates("1/5000", "1/8000", latency=1))
    shown = passing(timetable)
    tick = timetable.schedule.tick
    assert shown.pattern * tick == Fraction(1, 1000)
    ends = sorted(
        (s.ends - shown.first) * tick * 10**6
        for s in shown.steps
        if s.component == "plant"
    )
    assert ends == [125, 200, 250, 375, 400, 500, 600, 625, 750, 800, 875, 1000]
    published = [p for p in shown.published if p.component == "controller"]
    assert {(p.at - p.stems) * tick for p in published} == {Fraction(1, 5000)}
    picture = timetable_picture(timetable)
    assert "everything repeats every 1000 us" in picture
    assert "2 us" not in picture.partition("</style>")[2].split("age when")[0]


@pytest.mark.parametrize("stop", ["0", "1/8000", "1/20"])
def test_pictures_are_xml_however_short_the_run(stop: str) -> None:
    given_system = replace(two_rates("1/4000", "1/8000"), stop=Fraction(stop))
    ElementTree.fromstring(timetable_picture(plan(given_system)))


def test_rates_that_repeat_late_are_drawn_in_part() -> None:
    timetable = plan(two_rates("1/4001", "1/3999"))
    shown = passing(timetable)
    assert not shown.whole
    assert len(shown.steps) < 200
    assert "only the first part" in timetable_picture(timetable)
