"""The page in headless Chromium: one server and one browser for all tests."""

import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep
from typing import Any
from urllib.parse import quote

from selenium.common.exceptions import (
    ElementNotInteractableException,
    NoSuchElementException,
    StaleElementReferenceException,
)
from selenium.webdriver import Keys
from selenium.webdriver.support.select import Select

FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
    "--disable-background-networking --disable-component-update --disable-sync "
    "--force-prefers-reduced-motion --window-size=1400,1000"
)
RENEWED = (
    ElementNotInteractableException,
    NoSuchElementException,
    StaleElementReferenceException,
)


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve a project; give the address with its token."""
    command = [sys.executable, "-m", "orchestrator", "serve", str(folder)]
    process = subprocess.Popen(
        [*command, "--no-browser"], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        line = process.stdout.readline()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[\w-]+\n", line), line
        yield line.strip()
    finally:
        process.terminate()
        process.wait(20)
        process.stdout.close()


@contextmanager
def chromium(place: Path) -> Iterator[Any]:
    """Start Debian's browser with a profile of its own."""
    from selenium.webdriver import Chrome, ChromeOptions
    from selenium.webdriver.chrome.service import Service

    options = ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for flag in (*FLAGS.split(), f"--user-data-dir={place}"):
        options.add_argument(flag)
    driver = Chrome(options, Service("/usr/bin/chromedriver"))
    try:
        yield driver
    finally:
        driver.quit()


class Page:
    """What a person does with the page."""

    def __init__(self, driver: Any, home: str) -> None:
        self.driver, self.home = driver, home
        driver.set_script_timeout(120)

    def complaints(self) -> list[str]:
        """Return what the browser's console complains of, refused requests aside."""
        log = self.driver.get_log("browser")
        told = (one["message"] for one in log if one["level"] == "SEVERE")
        return [text for text in told if "/api/" not in text]

    def open(self, view: str = "") -> None:
        """Open a view by what stands after ``#/``; reload it if it is open."""
        self.driver.get("about:blank")
        self.driver.get(f"{self.home}#/{view}")

    def scenario(self, name: str) -> None:
        """Open a scenario and wait until its first curves are drawn."""
        self.open(f"scenario/{quote(name, safe='')}")
        self.until("[data-figure]")

    def until(self, selector: str, *, text: str = "", seconds: float = 40) -> Any:
        """Wait for an element, one that holds a text; return it."""
        end = monotonic() + seconds
        while monotonic() < end:
            for found in self.driver.find_elements("css selector", selector):
                with suppress(StaleElementReferenceException):
                    if text in found.text:
                        return found
            sleep(0.05)
        body = self.driver.find_element("css selector", "body").text
        raise AssertionError(
            f"no {selector} with {text!r} in:\n{body[:3000]}\n"
            f"no {selector} with {text!r}"
        )

    def click(self, name: str, within: str = "main") -> None:
        """Click a button, link or summary by its name."""
        where = f"//{within}//*[self::button or self::a or self::summary]"
        path = f"{where}[normalize-space()={name!r} or @aria-label={name!r}]"
        self.again(lambda: self.driver.find_element("xpath", path).click())

    def put(self, field: str, text: str) -> None:
        """Type a text in place of what stands in the field of an id or label."""
        where = f"[id='{field}'], [aria-label='{field}']"
        keys = (Keys.CONTROL, "a", Keys.NULL, text)
        self.again(lambda: self.until(where).send_keys(*keys))

    def choose(self, field: str, value: str) -> None:
        """Choose a value of a list by its id."""
        self.until(f"[id='{field}'] option[value='{value}']")
        self.again(lambda: Select(self.until(f"#{field}")).select_by_value(value))

    def press(self, selector: str, text: str = "") -> None:
        """Click an element that holds a text, once it can be."""
        self.again(lambda: self.until(selector, text=text).click())

    def again(self, do: Callable[[], None]) -> None:
        """Do something, once more where the page is just being shown anew."""
        for _ in range(20):
            with suppress(*RENEWED):
                return do()
            sleep(0.2)
        return do()

    def js(self, script: str, *arguments: Any) -> Any:
        """Return what an async function answers."""
        wrapped = (
            "const done = arguments[arguments.length - 1], given = [...arguments];"
            f"(async () => {{ {script} }})()"
            ".then((found) => done({ found }), (error) => done({ error: `${error}` }));"
        )
        answer = self.driver.execute_async_script(wrapped, *arguments)
        assert "error" not in answer, answer["error"]
        return answer["found"]

    def drag(self, parameter: str, values: list[float]) -> list[dict[str, Any]]:
        """Drag a slider to values; of each return when and what was drawn."""
        found: list[dict[str, Any]] = self.js(DRAG, parameter, values)
        return found


DRAG = """
const slider = document.querySelector(`[data-parameter="${given[0]}"]`);
slider.step = "any";
const told = [];
for (const value of given[1]) {
  const begun = performance.now();
  const drawn = new Promise((done) => document.addEventListener("drawn",
    ({ detail }) => done(detail), { once: true }));
  slider.value = value;
  slider.dispatchEvent(new Event("input"));
  const { settings, frame, error } = await drawn;
  if (error) throw error;
  await new Promise(requestAnimationFrame);
  const peak = ({ y }) => y.reduce((most, v) => Math.max(most, Math.abs(v)), 0);
  const curves = (panel) => panel.curves.map(
    (c) => ({ label: c.label, peak: peak(c) }));
  told.push({ ms: performance.now() - begun, settings, figures: frame.figures,
    panels: frame.panels.map((p) => ({ title: p.title, curves: curves(p) })) });
}
return told;
"""
