"""A report in a browser: what is folded is drawn when it is opened, nothing fails."""

from pathlib import Path
from time import sleep

import numpy as np
import pytest
from tools import needed

from orchestrator.report.figure import drawn
from orchestrator.report.panels import Curve, Panel
from orchestrator.report.shell import folded, signals, written

ZOOMED = """
const done = arguments[0];
(async () => {
  const plot = document.getElementById("signals");
  await Plotly.relayout(plot, { "xaxis.range": [5, 5.02] });
  await new Promise((ready) => setTimeout(ready, 300));
  const inside = (x) => x > 5 - 1e-9 && x < 5.02 + 1e-9;
  done(plot.data.map((trace) => [...trace.x].filter(inside).length));
})().catch((error) => done(String(error)));
"""
OPENED = """
document.querySelector("details.folded").open = true;
"""


def test_denormal_numbers_are_zoomed_and_folds_open_in_light_and_dark(
    tmp_path: Path,
) -> None:
    needed("chromium", "chromedriver")
    browsed = pytest.importorskip("browsed")
    time = np.arange(200_001) / 20_000
    tiny, wave = np.full(len(time), 1e-322), np.sin(time)
    panels = [
        Panel("tiny", "V", [Curve("tiny", time, tiny, 0)]),
        Panel("wave", "m", [Curve("wave", time, wave, 0)]),
    ]
    plot = {"data": [{"x": [0, 1], "y": [0, 1]}], "layout": {}}
    parts = [signals(drawn(panels, overlaid=False)), folded("more", plot)]
    page = written("x", parts, tmp_path / "x.html")
    with browsed.chromium(tmp_path / "profile") as driver:
        driver.get(page.as_uri())
        while not _told(driver).startswith("Drawn"):
            sleep(0.05)
        assert driver.execute_async_script(ZOOMED) == [401, 401]
        assert "Every point" in _told(driver)
        driver.execute_script(OPENED)
        while not driver.execute_script(
            "return document.querySelectorAll('.folded .main-svg').length"
        ):
            sleep(0.05)
        for scheme, paper in (("light", "255, 255, 255"), ("dark", "23, 26, 30")):
            features = [{"name": "prefers-color-scheme", "value": scheme}]
            driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
            colour = "return getComputedStyle(document.body).backgroundColor"
            assert driver.execute_script(colour) == f"rgb({paper})"
        severe = [e for e in driver.get_log("browser") if e["level"] == "SEVERE"]
        assert severe == []


def _told(driver: object) -> str:
    text: str = driver.execute_script(  # type: ignore[attr-defined]
        "return document.getElementById('drawn').textContent"
    )
    return text
