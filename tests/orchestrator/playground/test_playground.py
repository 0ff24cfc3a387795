"""A page that runs in the browser gives the bits of ``run``, and can be used by all."""

import json
import subprocess
from base64 import b64decode
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from axe import violations
from browsed import Page
from selenium.webdriver import Keys
from tools import needed

from orchestrator.errors import SimulationError
from orchestrator.master.simulate import plan
from orchestrator.page.kept import Kept
from orchestrator.playground.compiled import Playable
from orchestrator.playground.page import page
from orchestrator.playground.schema import pages
from orchestrator.playground.source import Variant
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

PLAYED = Path(__file__).parents[2] / "support" / "played.mjs"
MOVED: tuple[dict[str, float], ...] = (  # factors; friction acts in all of them
    {},
    {"plant.m_2": 1.3, "controller.K_x1": 0.9, "plant.friction.d_s_minus": 1.7},
)
ROWS = """
const { told, run } = played, [variant, moved] = given;
const all = [...told.sliders.flatMap((s) => s.parameters), ...told.switches];
const set = Object.entries(moved).map(([name, times]) => {
  const found = all.find((p) => p.name === name);
  return { ...found, to: found.value * times };
});
const { signals, error } = run({ variant, set });
if (error) throw error;
return Object.fromEntries(Object.entries(signals).map(([name, values]) => {
  const bytes = new Uint8Array(values.buffer);
  let text = "";
  for (let i = 0; i < bytes.length; i += 32768)
    text += String.fromCharCode(...bytes.subarray(i, i + 32768));
  return [name, btoa(text)];
}));
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """The ball screw at one rate and two latencies."""
    spec = pages()["ball_screw"]
    playable = Playable(spec, ["20 kHz"], [1, 2])
    folder = tmp_path_factory.mktemp("playground")
    (folder / "module.wasm").write_bytes(playable.module)
    (folder / "page.html").write_text(page(playable), encoding="utf-8")
    kept = Kept(spec.scenario)  # as the page begins: 20 kHz, a delay of one sample
    return SimpleNamespace(spec=spec, playable=playable, folder=folder, kept=kept)


@pytest.fixture(scope="module")
def shown(made: SimpleNamespace, driver: Any) -> Iterator[Page]:
    """The page, opened from the disk."""
    found = Page(driver, "")
    found.complaints()  # of pages that others have shown before
    driver.get((made.folder / "page.html").as_uri())
    found.until("#figures tr")
    yield found
    assert found.complaints() == []


def ran(
    kept: Kept, playable: Playable, number: int, moved: Mapping[str, float]
) -> dict[str, Any]:
    """Return the rows of the fused loop, with parameters moved by factors."""
    choice = playable.choices[number]
    assert kept.executor == "fused"
    values: dict[str, dict[str, float]] = {}
    for name, times in moved.items():
        component, _, variable = name.partition(".")
        nominal = float(choice.composition.parameter(name).value)
        values.setdefault(component, {})[variable] = nominal * times
    done = kept.run(values)
    assert done.metrics
    return {name: done[name].values for name in done}


def node(
    playable: Playable, module: Path, number: int, moved: Mapping[str, float]
) -> dict[str, Any]:
    """Return the rows of the module in node."""
    told = playable.told()
    one = told["variants"][number]
    values = dict(enumerate(one["values"]))
    for name, times in moved.items():
        component, _, variable = name.partition(".")
        choice = playable.choices[number]
        place = choice.composition.fmus[component].variables[variable].reference
        nominal = float(choice.composition.parameter(name).value)
        values[told["components"][component]][place] = nominal * times
    columns = told["columns"]
    out = module.with_name("rows")
    count = one["rows"] * len(columns)
    command = ["node", str(PLAYED), str(module), str(number), json.dumps(values)]
    subprocess.run([*command, str(out), str(count)], check=True)
    rows = np.fromfile(out).reshape(one["rows"], len(columns))
    return {
        c["name"]: c["gain"] * rows[:, i] + c["offset"]
        if (c["gain"], c["offset"]) != (1, 0)
        else rows[:, i]
        for i, c in enumerate(columns)
    }


def same_bits(ours: Mapping[str, Any], there: Mapping[str, Any], least: int) -> None:
    assert set(ours) == set(there)
    for name, values in ours.items():
        assert len(values) >= least
        assert np.ptp(values) > 0, name
        assert values.tobytes() == np.ascontiguousarray(there[name]).tobytes(), name


@pytest.mark.parametrize("moved", MOVED)
def test_node_and_chromium_give_the_bits_of_the_whole_move(
    made: SimpleNamespace, shown: Page, moved: dict[str, float]
) -> None:
    needed("node")
    told = made.playable.told()["switches"]
    assert next(s for s in told if s["name"] == "plant.friction.on")["value"] == 1
    ours = ran(made.kept, made.playable, 0, moved)
    module = made.folder / "module.wasm"
    same_bits(ours, node(made.playable, module, 0, moved), 19_401)
    answer = shown.js(ROWS, 0, moved)
    there = {n: np.frombuffer(b64decode(text)) for n, text in answer.items()}
    same_bits(ours, there, 19_401)


@pytest.mark.parametrize("name", ["ball_screw", "gantry"])
def test_every_rate_and_latency_gives_the_bits_in_node(
    name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    if not request.config.getoption("--every-form"):
        pytest.skip("--every-form composes every variant")
    needed("node")
    playable = Playable(pages()[name])
    module = tmp_path / "module.wasm"
    module.write_bytes(playable.module)
    first = playable.spec.sliders[0].parameters[0]
    for number, choice in enumerate(playable.choices):
        moved = {} if number % 2 else {first: 1.25}
        try:
            kept = Kept(playable.spec.scenario, choice.sets)
            ours = ran(kept, playable, number, moved)
        except SimulationError:
            with pytest.raises(subprocess.CalledProcessError):
                node(playable, module, number, moved)
            continue
        assert len(next(iter(ours.values()))) > 1000, choice.sets
        same_bits(ours, node(playable, module, number, moved), 1000)


def test_the_page_fetches_nothing_and_shows_the_figures_of_the_run(
    made: SimpleNamespace, shown: Page
) -> None:
    assert shown.js("return performance.getEntriesByType('resource').length") == 0
    peak = made.kept.run({}).metrics["tracking.peak"].value
    row = shown.until("#figures tr", text="tracking.peak").text
    assert float(row.split()[1]) == float(f"{peak:.4g}")
    # a module of two variants; the page of all twenty has about 70 kB
    assert (made.folder / "page.html").stat().st_size < 80_000


def as_it_was(shown: Page) -> None:
    """Press the button; wait until the run with nothing set is drawn."""
    shown.js(
        "const drawn = new Promise((done) => document.addEventListener("
        "'played', done, { once: true })); document.getElementById('back').click();"
        "await drawn;"
    )
    assert "--set" not in shown.until("#command").text


def test_keys_move_a_slider_and_the_command_says_what_was_set(shown: Page) -> None:
    slider = shown.until("#slider-0")
    slider.send_keys(*[Keys.ARROW_RIGHT] * 5)
    command = shown.until("#command", text="--set plant.m_2=").text
    value = float(command.rpartition("=")[2])
    assert value == pytest.approx(1.05 * 0.000379)
    assert "× 1.05" in slider.get_attribute("aria-valuetext")
    assert "tracking.peak" in shown.until("#status", text="tracking").text
    shown.until("#latency").send_keys(Keys.ARROW_RIGHT)
    shown.until("#command", text="--set controller.latency=2")
    as_it_was(shown)


def test_what_fails_is_said_where_it_is_seen(shown: Page) -> None:
    shown.js(
        "const s = document.getElementById('slider-5'); s.max = 1e9; s.value = 1e9;"
        "s.dispatchEvent(new Event('input'));"
    )
    told = shown.until("#error", text="at t = ").text
    assert told.endswith("s: a value is no longer finite")
    as_it_was(shown)
    assert shown.until("#error").text == ""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing(shown: Page, scheme: str) -> None:
    assert violations(shown, scheme) == []


def test_what_a_page_cannot_run_is_refused_in_words(
    made: SimpleNamespace, tmp_path: Path
) -> None:
    file = tmp_path / "faulty.toml"
    fault = '{ kind = "bias", value = 0.05 }'
    file.write_text(f'base = "{made.spec.scenario}"\n[faults]\n"plant.u" = {fault}\n')
    composition = compose(load_scenario(file), run_earlier)
    with pytest.raises(SimulationError, match="a page cannot run this: it has faults"):
        Variant(plan(composition.system))
