"""Sweep and response asked in the page; refusals of the verbs shown where asked."""

from types import SimpleNamespace

from browsed import Page


def test_a_sweep_is_asked_and_its_report_shown(
    browser: Page, site: SimpleNamespace
) -> None:
    browser.scenario("tests/speed_step.toml")
    browser.press("summary", "Sweep: ")
    browser.put("Sweep-vary", "motor.nothing")
    browser.click("ask Sweep")
    browser.until("p.error", text="has no variable 'nothing'")
    browser.put("Sweep-vary", "motor.J")
    browser.put("Sweep-values", "+-20%:3")
    browser.click("ask Sweep")
    told = browser.until("p.good", text="sweep is done, kept in runs/").text
    folder = site.folder / told.removesuffix(".").rpartition(" ")[2]
    assert (folder / "report.html").is_file()
    frame = browser.until("iframe")
    browser.driver.switch_to.frame(frame)
    try:
        assert "motor.J" in browser.until("body", text="motor.J").text
        # a page of anybody's run sees nothing of ours
        assert browser.driver.execute_script("return window.origin") == "null"
    finally:
        browser.driver.switch_to.default_content()


def test_a_response_is_asked_of_models_beside_the_scenario(
    browser: Page, site: SimpleNamespace
) -> None:
    browser.scenario("tests/speed_step.toml")
    browser.press("summary", "Response: ")
    browser.put("Response-break", "controller.i")
    browser.click("ask Response")
    told = browser.until("p.good", text="response is done, kept in runs/").text
    folder = site.folder / told.removesuffix(".").rpartition(" ")[2]
    assert (folder / "response.html").is_file()
