"""My FMU in place of yours, from an empty folder to two runs compared: what it takes.

``python tests/benchmarks/journey.py`` does it in the page, in headless Chromium as a
person does, and on the command line, and prints clicks, commands and seconds, which
docs/swap-my-plant.md has.  A person's own seconds, to read and to think, are not in it.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from browsed import Page, chromium, served

SCENARIO = "ball_screw_pole_placement/mc_ppc_track_500"
COMMANDS = (
    f"run {SCENARIO} --swap plant=their/ball_screw.fmu --map-out map.toml",
    f"run {SCENARIO} --swap plant=their/ball_screw.fmu --map map.toml",
)


class Person(Page):
    """Counts what is clicked and typed."""

    clicks = fields = 0

    def click(self, name: str, within: str = "main") -> None:
        super().click(name, within)
        self.clicks += 1

    def press(self, selector: str, text: str = "") -> None:
        super().press(selector, text)
        self.clicks += 1

    def put(self, field: str, text: str) -> None:
        super().put(field, text)
        self.fields += 1


def their_fmu(folder: Path) -> None:
    """Put the FMU that comes along where a supplier's would be."""
    build = ["build", "supplied.ball_screw", "-o", str(folder / "their")]
    subprocess.run([sys.executable, "-m", "orchestrator", *build], check=True)


def in_the_page(folder: Path) -> Person:
    """Copy a scenario, run it, put the FMU in, run it, compare; tell the seconds."""
    their_fmu(folder)
    project = folder / "project"
    project.mkdir()
    with served(project) as address, chromium(folder / "chromium") as driver:
        person = Person(driver, address.partition("?")[0])
        begun = last = perf_counter()

        def done(what: str) -> None:
            nonlocal last
            now = perf_counter()
            print(f"  {now - last:6.1f} s  {what}")
            last = now

        driver.get(address)
        person.press("summary", "ball_screw_pole_placement")
        person.press("li a", SCENARIO)
        person.until("[data-figure]", seconds=300)
        done("opened: FMUs built, first curves")
        person.put("copy", "mine")
        person.click("Copy to change it")
        person.until("h1", text="500 mm/s", seconds=60)
        person.until("[aria-label='replace plant']", seconds=60)
        done("copied into the project")
        person.click("Run and keep")
        person.until("#status", text="run kept in runs/", seconds=120)
        done("original run, kept")
        person.click("replace plant")
        person.until("#file").send_keys(str(folder / "their" / "ball_screw.fmu"))
        person.clicks += 1  # the file is chosen, or dropped
        person.until("p.good", text="It fits in its place.", seconds=120)
        print(person.until("#map").get_attribute("value"))
        done("checked, map proposed and measured")
        person.click("Put it in place")
        person.until("td", text="ball_screw.fmu", seconds=60)
        person.until("[data-figure]", seconds=120)
        done("put in place, drawn")
        person.click("Run and keep")
        person.until("#status", text="run kept in runs/", seconds=120)
        done("swapped run, kept")
        person.click("feeddrive", "header")
        person.until("tbody input[type=checkbox]")
        for tick in driver.find_elements("css selector", "tbody input[type=checkbox]"):
            tick.click()
            person.clicks += 1
        person.click("Compare 2 runs")
        person.until(".u-title", text="difference", seconds=60)
        done("compared")
        print(person.until("tr", text="tracking.peak").text)
        print(f"page: {perf_counter() - begun:.0f} s, {person.clicks} clicks, ", end="")
        print(f"{person.fields} field filled in")
    return person


def on_the_command_line(folder: Path) -> None:
    """Propose the map, run both with it; tell the seconds."""
    their_fmu(folder)
    begun = perf_counter()
    for command in COMMANDS:
        last = perf_counter()
        whole = [sys.executable, "-m", "orchestrator", *command.split()]
        code = subprocess.run(whole, cwd=folder, capture_output=True).returncode
        print(f"  {perf_counter() - last:6.1f} s  feeddrive {command} (exit {code})")
    took = perf_counter() - begun
    print(f"command line: {took:.0f} s, {len(COMMANDS)} commands")


def main() -> None:
    """Measure both."""
    for measured in (in_the_page, on_the_command_line):
        with tempfile.TemporaryDirectory() as folder:
            measured(Path(folder))


if __name__ == "__main__":
    main()
