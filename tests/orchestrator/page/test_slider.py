"""A slider that is dragged runs what ``run --set`` runs."""

from browsed import Page

from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

DEMO = "ball_screw_pole_placement/mc_ppc_track_500"


def test_the_drawn_peak_is_that_of_a_run_with_the_same_set(
    browser: Page, tmp_path
) -> None:
    browser.scenario(DEMO)
    nominal = 0.000382
    told = browser.drag("plant.m_2", [nominal * (1 + i / 40) for i in range(8)])
    peaks = [
        {f["name"]: f["value"] for f in one["figures"]}["tracking.peak"] for one in told
    ]
    assert len(set(peaks)) == len(peaks)
    drawn = [
        curve["peak"]
        for curve in told[-1]["panels"][1]["curves"]
        if curve["label"] == "error"
    ]
    (setting,) = told[-1]["settings"].items()
    done = run(load_scenario(DEMO, [f"{setting[0]}={setting[1]!r}"]), tmp_path / "run")
    assert drawn == [done.metrics["tracking.peak"].value] == [peaks[-1]]


def test_an_error_stands_where_it_belongs_and_the_next_position_is_drawn(
    browser: Page,
) -> None:
    browser.scenario("tests/speed_step.toml")
    browser.put("p-controller.K_p", "1e9\t")
    said = "controller (SpeedPI.fmu): i is -inf at t = 0.01825 s; finite values"
    browser.until("p.error", text=said)
    (one,) = browser.drag("controller.K_p", [1.0])
    assert one["settings"] == {"controller.K_p": 1.0}
    assert not browser.driver.find_elements("css selector", "p.error")


def test_a_value_beyond_its_bound_is_refused_at_its_field(browser: Page) -> None:
    browser.scenario("tests/speed_step.toml")
    browser.put("p-motor.J", "-1\t")
    browser.until(".parameter .error", text="at least ")
    field = browser.until("[id='p-motor.J']")
    assert field.get_attribute("aria-invalid") == "true"
