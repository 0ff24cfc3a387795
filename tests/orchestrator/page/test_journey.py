"""My FMU in place of yours, from nothing to a run, as a person does it."""

import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest
from browsed import Page

from fmus.build import build

THEIRS = '''"""A drive from somebody else.

J dn/dt = K_t i - B n
Source: none; with other names and the speed in turns per minute.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    w: Annotated[float, Var("rad/s", "speed inside")] = 0.0


class Input(NamedTuple):
    current: Annotated[float, Var("A", "current")] = 0.0


class Output(NamedTuple):
    speed: Annotated[float, Var("1/min", "speed")]


class Parameters(NamedTuple):
    inertia: Annotated[float, Var("kg.m2", "inertia")] = 1.2e-3
    torque: Annotated[float, Var("N.m/A", "torque constant")] = 0.5


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return the acceleration."""
    return State((p.torque * u.current - 1e-4 * x.w) / p.inertia)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return the speed."""
    return Output(x.w * 9.549296585513721)


model = Continuous("Theirs", derivative, output, State(), Input(), Parameters())
'''


@pytest.fixture
def theirs(tmp_path: Path) -> Path:
    (tmp_path / "theirs.py").write_text(THEIRS)
    shutil.copyfile(build(str(tmp_path / "theirs.py")), tmp_path / "theirs.fmu")
    return tmp_path / "theirs.fmu"


def connect(page: Page, source: str, sink: str) -> None:
    page.choose("from", source)
    page.choose("to", sink)
    page.click("Connect")


def test_my_fmu_in_place_of_yours(
    browser: Page, site: SimpleNamespace, theirs: Path
) -> None:
    browser.open()
    browser.press("summary", "Begin a scenario")
    browser.put("name", "mine")
    browser.put("component", "motor")
    browser.put("model", "models/motor.py")
    browser.put("step", "1/4000")
    browser.put("until", "0.1")
    browser.click("Begin")
    browser.put("new-name", "controller")
    browser.put("new-fmu", "models/speed_pi.py")
    browser.put("new-step", "1/4000")
    browser.click("Add")
    browser.until("td", text="controller")
    connect(browser, "motor.omega", "motor.i")
    browser.until("p.error", text="motor.omega -> motor.i: ")  # refused, not written
    connect(browser, "motor.omega", "controller.omega")
    browser.until("[aria-label='disconnect controller.omega']")
    connect(browser, "controller.i", "motor.i")
    browser.until("[aria-label='disconnect motor.i']")
    browser.put("latency of controller", "1\t")
    browser.until(".picture svg", text="latency 1 sample")
    browser.press("summary", "0 recorded signals")
    browser.press("label", "motor.omega")
    browser.until("summary", text="1 recorded signals")
    browser.put("p-controller.omega_r", "100\t")
    browser.click("Write into the scenario")
    file = site.folder / "mine.toml"
    browser.until(".parameter:not(.moved) [id='p-controller.omega_r'][value='100']")
    assert "omega_r = 100" in file.read_text()
    assert '"controller.omega" = "motor.omega"' in file.read_text()

    browser.click("replace motor")
    browser.until("#file").send_keys(str(theirs))
    browser.until("td", text="torque constant")
    browser.until("p.good", text="It fits in its place.")
    proposed = browser.until("#map").get_attribute("value")
    assert 'i = "current"' in proposed
    assert 'name = "speed"' in proposed
    browser.click("Put it in place")
    browser.until("td", text="theirs.fmu")
    text = file.read_text()
    assert 'fmu = "theirs.fmu"' in text
    assert "[components.motor.map]" in text
    browser.until("p.soft", text="The scenario defines no metrics.")
    browser.click("Run and keep")
    browser.until("#status", text="run kept in runs/mine/1")

    file.write_text(text.replace('stop = "0.1"', 'stop = "0.2"'))  # changed outside
    browser.until("[role=status]", text="every one of 801 recorded points")
    assert file.read_text().startswith('stop = "0.2"')


def test_a_name_that_is_code_is_refused_or_shown_as_text(
    browser: Page, site: SimpleNamespace, theirs: Path, tmp_path: Path
) -> None:
    code = "<img src=x onerror=window.hit=1>"
    model = tmp_path / "hit.py"
    model.write_text(THEIRS.replace('"speed"', f'"{code}"'))
    upload = """
        const response = await fetch("/api/upload?name=" + encodeURIComponent(given[0]),
          { method: "POST", body: new Uint8Array(given[1]) });
        return response.json();
    """
    content = list(build(str(model)).read_bytes())
    refused = browser.js(upload, "<script>.fmu", content)
    assert "cannot name a file here" in refused["error"]
    outside = browser.js(upload, "../../out.fmu", content)
    assert "cannot name a file here" in outside["error"]
    no_fmu = browser.js(upload, "hit.fmu", content[:500])
    assert "not a readable zip archive" in no_fmu["error"]
    assert not list(site.folder.glob("*partial*"))
    assert browser.js(upload, "hit.fmu", content)["name"] == "Theirs"
    browser.scenario("tests/speed_step.toml")
    browser.click("replace motor")
    browser.choose("choice", "hit.fmu")
    browser.until("td", text=code)
    assert browser.js("return window.hit ?? 0") == 0
