"""Slider to redrawn curve, in headless Chromium: median and worst of 100 drags.

python tests/benchmarks/page_drags.py [SCENARIO PARAMETER ...]
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from browsed import Page, chromium, served

DRAGS = 100
CASES = [
    ("ball_screw_pole_placement/mc_ppc_track_500", "plant.m_2"),
    ("gantry/circle_200", "trajectory.v_max"),
]


def main() -> None:
    given = sys.argv[1:]
    cases = list(zip(given[::2], given[1::2], strict=True)) or CASES
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "project"
        folder.mkdir()
        with served(folder) as address, chromium(Path(place) / "chromium") as driver:
            page = Page(driver, address.partition("?")[0])
            driver.get(address)
            for scenario, parameter in cases:
                page.scenario(scenario)
                slider = page.until(f"[data-parameter='{parameter}']")
                nominal = float(slider.get_attribute("value"))
                page.drag(parameter, [nominal * 1.001, nominal * 1.002])  # warmed up
                values = (nominal * np.linspace(0.9, 1.1, DRAGS)).tolist()
                ms = [one["ms"] for one in page.drag(parameter, values)]
                print(
                    f"{scenario} {parameter}: {DRAGS} drags, median "
                    f"{np.median(ms):.0f} ms, worst {max(ms):.0f} ms"
                )


if __name__ == "__main__":
    main()
