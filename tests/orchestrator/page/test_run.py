"""A run in the page: kept as on the command line, live, aborted; zoomed."""

import json
import sys
from types import SimpleNamespace

import pytest
from browsed import Page
from selenium.webdriver import ActionChains
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.result import Result

LONG = """
stop = 2000000
[components.controller]
fmu = "models/speed_pi.py"
step = "1/4000"
[components.motor]
fmu = "models/motor.py"
step = "1/4000"
[connections]
"controller.omega_r" = 100.0
"controller.omega" = "motor.omega"
"motor.i" = "controller.i"
[record]
"motor.omega" = "1 Hz"
"""


def test_a_run_is_kept_with_what_was_moved(
    browser: Page, site: SimpleNamespace
) -> None:
    browser.scenario("tests/speed_step.toml")
    browser.drag("controller.K_p", [0.75])
    browser.click("Run and keep")
    told = browser.until("#status", text="run kept in runs/").text
    folder = site.folder / told.removeprefix("run kept in ")
    metrics = json.loads((folder / "metrics.json").read_text())["metrics"]
    shown = browser.driver.find_elements("css selector", "[data-figure]")
    assert {
        row.get_attribute("data-figure"): float(row.get_attribute("data-value"))
        for row in shown
    } == {name: one["value"] for name, one in metrics.items()}
    browser.open()
    browser.until("td", text="controller.K_p=0.75")
    assert "report of speed_step/" in browser.until("tbody a").get_attribute(
        "aria-label"
    )


def test_runs_are_compared_by_ticking_them(
    browser: Page, site: SimpleNamespace
) -> None:
    for gain in (0.6, 0.9):
        browser.scenario("tests/speed_step.toml")
        browser.drag("controller.K_p", [gain])
        browser.click("Run and keep")
        browser.until("#status", text="run kept in runs/")
    browser.open()
    browser.until("tbody input[type=checkbox]")
    ticks = browser.driver.find_elements("css selector", "tbody input[type=checkbox]")
    for tick in ticks[:2]:
        tick.click()
    browser.click("Compare 2 runs")
    row = browser.until("tr", text="components.controller.parameters.K_p").text
    assert row.split()[-2:] == ["0.9", "0.6"]
    assert "%" in browser.until("tr", text="speed.overshoot").text
    names = [c.text for c in browser.driver.find_elements("css selector", ".u-title")]
    assert "motor.omega" in names
    assert any("motor.omega: difference to runs/" in name for name in names)


def test_a_run_shows_how_far_it_is_and_can_be_aborted(
    browser: Page, site: SimpleNamespace
) -> None:
    (site.folder / "long.toml").write_text(LONG)
    browser.open("scenario/long.toml")
    browser.until("p.soft", text="8,000,000,000 instants, too many to run whenever")
    browser.click("Run and keep")
    browser.until("#status", text="of 2000000 s")
    browser.until("figcaption")
    browser.click("Abort")
    browser.until("p.error", text="aborted at t = ")
    kept = [run for run in (site.folder / "runs/long").iterdir() if run.is_dir()]
    ended = json.loads((kept[-1] / "ended.json").read_text())
    assert ended["how"] == "interrupted"
    assert len(Result(kept[-1])["motor.omega"]) > 1


def test_a_run_is_held_to_the_clock(browser: Page) -> None:
    browser.scenario("tests/speed_step.toml")
    browser.put("pace", "0.2")
    browser.click("Run and keep")
    told = browser.until("p.warning", text="paced at 0.2 x real time: ").text
    assert "blocks, jitter " in told


def test_a_zoom_shows_every_recorded_point(browser: Page) -> None:
    browser.scenario("ball_screw_pole_placement/mc_ppc_track_500")
    browser.until("[role=status]", text="15013 recorded points, the least and")
    over = browser.until(".u-over")
    drag = ActionChains(browser.driver).move_to_element_with_offset(over, 0, 20)
    drag.click_and_hold().move_by_offset(30, 0).release().perform()
    told = browser.until("[role=status]", text="every one of ").text
    points = int(told.split()[3])
    assert 300 < points < 1000
    browser.click("Later")
    browser.until("[role=status]", text="every one of ")
    browser.click("Whole time")
    browser.until("[role=status]", text="15013 recorded points, the least and")


def test_without_its_packages_the_page_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delitem(sys.modules, "orchestrator.page.server", raising=False)
    monkeypatch.setitem(sys.modules, "starlette", None)
    done = CliRunner().invoke(app, ["serve", "--no-browser"])
    assert done.exit_code == 2
    assert "pip install 'feeddrive-cosim[page]'" in done.stderr
