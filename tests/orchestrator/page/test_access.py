"""The page without a mouse and without eyes: axe finds nothing, keys reach all."""

import pytest
from axe import violations
from browsed import Page
from selenium.webdriver import Keys

OPEN = """
for (const one of document.querySelectorAll("main details")) one.open = true;
return document.querySelectorAll("main details").length;
"""


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_axe_finds_nothing_in_any_view(
    browser: Page, scheme: str, request: pytest.FixtureRequest
) -> None:
    if scheme == "light" and not request.config.getoption("--every-form"):
        pytest.skip("--every-form looks at light pages too")
    browser.scenario("tests/speed_step.toml")
    browser.until(".picture svg")
    browser.click("replace motor")
    browser.until("#file")
    assert browser.js(OPEN) > 5
    browser.until(".picture[aria-label^=timetable] svg")
    assert violations(browser, scheme) == []
    browser.click("Run and keep")
    browser.until("#status", text="run kept in runs/")
    browser.open()
    browser.until("tbody tr")
    assert violations(browser, scheme) == []
    browser.press("tbody input[type=checkbox]")
    browser.click("Show the ticked run")
    browser.until(".u-title")
    assert violations(browser, scheme) == []


def test_everything_is_reached_and_done_by_keys(browser: Page) -> None:
    """Tab from the top to the slider, move it, tab on to Connect."""
    browser.scenario("tests/speed_step.toml")
    active = browser.driver.switch_to
    browser.driver.find_element("css selector", "body").send_keys(Keys.TAB)
    assert active.active_element.text == "To the content"
    reached = []
    for _ in range(120):
        active.active_element.send_keys(Keys.TAB)
        one = active.active_element
        name = one.get_attribute("data-parameter") or one.get_attribute("aria-label")
        reached.append(name or one.get_attribute("id") or one.text)
        if one.get_attribute("data-parameter") == "controller.K_p":
            one.send_keys(Keys.ARROW_RIGHT)
        if reached[-1] == "replace motor":
            break
    assert "Run and keep" in reached
    assert "controller.K_p" in reached
    assert "Connect" in reached
    assert "disconnect motor.i" in reached
    assert reached[-1] == "replace motor"
    browser.until("code", text="--set controller.K_p=")
