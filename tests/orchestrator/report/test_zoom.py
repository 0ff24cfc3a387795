"""A page opened from disk shows every recorded point, however far it is zoomed."""

import json
import re
import subprocess
import zlib
from base64 import b64decode
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tools import needed

from orchestrator.report.embedded import embedded, encoded, recorded, share
from orchestrator.report.panels import Curve
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

TONE = """
title = "A tone of 700 Hz over 5 s"
stop = "5"
[components.tone]
fmu = "controllers.references.sine"
step = "20 kHz"
parameters = { frequency_hz = 700 }
[record]
"tone.x_r" = "20 kHz"
"tone.v_r" = "1 kHz"
[metrics]
x = { kind = "peak", of = "tone.x_r", unit = "mm", window = [1, 2] }
v = { kind = "max", of = "tone.v_r" }
[expect]
"x.peak" = { below = 6, unit = "mm" }
"v.max" = { below = 1e6 }
"""
ASK = """
<script>
const found = [], ranges = [[2.0, 2.004], [0.5, 0.51], [4.9999, 5.1], [1, 4], null];
const wait = (ms) => new Promise((done) => setTimeout(done, ms));
(async () => {
  const told = document.getElementById("drawn");
  while (!told.textContent.startsWith("Drawn")) await wait(50);
  for (const range of ranges) {
    await Plotly.relayout("signals", range
      ? { "xaxis.range": range } : { "xaxis2.autorange": true });
    await wait(500);
    const { data, layout } = document.getElementById("signals");
    const curves = data.filter((t) => t.showlegend !== false);
    found.push({
      range: layout.xaxis.range, told: told.textContent,
      curves: curves.map((t) => ({ name: t.name, x: [...t.x], y: [...t.y] })),
    });
  }
  const answer = document.createElement("pre");
  answer.id = "answer";
  answer.textContent = JSON.stringify(found);
  document.body.append(answer);
})();
</script></body>
"""


def decoded(text: str, n: int) -> np.ndarray:
    planes = np.frombuffer(zlib.decompress(b64decode(text)), np.uint8).reshape(8, n)
    bits = planes.T.copy().view("<u8").ravel()
    return np.bitwise_xor.accumulate(bits).view("<f8")


@given(st.lists(st.floats(allow_nan=False), min_size=1, max_size=50))
def test_what_is_embedded_are_the_bits_that_were_recorded(values: list[float]) -> None:
    given_values = np.array(values)
    found = decoded(encoded(given_values), len(values))
    assert found.tobytes() == given_values.tobytes()


def test_times_that_are_not_even_are_embedded_too() -> None:
    y = np.zeros(4)
    assert embedded(np.arange(4) / 20_000, y)["step"] == pytest.approx(5e-5)
    uneven = np.array([0, 1, 2, 4.0])
    assert decoded(embedded(uneven, y)["x"], 4).tolist() == uneven.tolist()


def test_a_page_that_cannot_hold_every_point_says_down_to_where_it_is_honest() -> None:
    assert share([10, 10, 1000], 520) == 500
    assert share([10, 20], 100) >= 20
    time = np.arange(100_000) / 1e4
    curve = Curve("plant.x", time, np.sin(time), 0)
    page = recorded({0: curve}, most=1000)
    found = json.loads(re.search(r'json" id="recorded">(.*?)</', page)[1])
    assert found["curves"][0]["n"] == pytest.approx(1000, abs=4)
    assert "not all 100,000 of plant.x: of each stretch of 0.02 s" in found["coarse"]
    assert '"coarse": ""' in recorded({0: curve})


@pytest.fixture(scope="module")
def tone(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    folder = tmp_path_factory.mktemp("tone")
    (folder / "tone.toml").write_text(TONE)
    done = run(load_scenario(folder / "tone.toml"), folder / "run")
    return SimpleNamespace(run=done, page=(folder / "run/report.html").read_text())


def test_windows_and_limits_of_the_scenario_are_drawn(tone: SimpleNamespace) -> None:
    assert "window of x" in tone.page
    assert "x.peak below 6 mm" in tone.page
    assert re.search(r"v\.max below 1e\+06 m.{1,6}s: beyond the picture", tone.page)


def test_zooming_draws_every_recorded_point(
    tone: SimpleNamespace, tmp_path: Path
) -> None:
    needed("chromium")
    file = tmp_path / "report.html"
    file.write_text(tone.page.replace("</body>", ASK))
    for found in asked(file, tmp_path):
        start, end = found["range"]
        for curve in found["curves"]:
            signal = tone.run[curve["name"]]
            inside = (signal.time >= start) & (signal.time <= end)
            if np.sum(inside) > 2500:
                drawn, whole = np.array(curve["y"]), signal.values[inside]
                assert len(drawn) <= 3002
                assert (drawn.min(), drawn.max()) == (whole.min(), whole.max())
                assert "zoom in to see every one" in found["told"]
                continue
            seen = [
                (x, y)
                for x, y in zip(curve["x"], curve["y"], strict=True)
                if start <= x <= end
            ]
            assert [y for _, y in seen] == signal.values[inside].tolist()
            np.testing.assert_allclose(
                [x for x, _ in seen], signal.time[inside], atol=1e-12
            )
    assert (start, end) == (0, 5)


def asked(file: Path, place: Path) -> list[dict]:
    """Return what the page answers in a browser without network."""
    flags = (
        "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
        "--disable-background-networking --disable-component-update --disable-sync "
        "--virtual-time-budget=60000 --dump-dom"
    )
    command = ["chromium", *flags.split(), f"--user-data-dir={place / 'chromium'}"]
    done = subprocess.run(
        [*command, file.as_uri()],
        capture_output=True,
        text=True,
        check=True,
        timeout=180,
    )
    answer = re.search(r'<pre id="answer">(.*?)</pre>', done.stdout, re.DOTALL)
    assert answer, done.stderr[-2000:]
    found: list[dict] = json.loads(answer[1])
    assert len(found) == 5
    return found
