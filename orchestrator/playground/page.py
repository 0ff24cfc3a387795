"""The HTML of a page that runs by itself: module, values and script lie in it."""

import json
import zlib
from base64 import b64encode
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path
from typing import Any

from orchestrator.playground.compiled import Playable

STATIC = Path(__file__).parent / "static"


def page(playable: Playable, home: str | None = None) -> str:
    """Return the page; ``home`` is where a link back leads.

    Raises:
        FeedDriveError, CompileError: as ``Playable``.
    """
    spec, told = playable.spec, playable.told()
    style, script = (
        (STATIC / f"playground.{kind}").read_text(encoding="utf-8")
        for kind in ("css", "js")
    )
    packed = b64encode(zlib.compress(playable.module, 9)).decode()
    data = json.dumps(told, allow_nan=False, separators=(",", ":"))
    data = data.replace("<", "\\u003c")
    back = f'<p><a href="{escape(home)}">feeddrive</a></p>' if home else ""
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(spec.title)}</title><style>{style}</style></head>
<body><main>{back}
<h1>{escape(spec.title)}</h1>
<p>{escape(spec.about)}</p>
<p class="soft">Move something: it runs anew. Dashed is how it began.</p>
<div class="two">
<form id="controls" autocomplete="off">{"".join(_controls(told))}
<button type="button" id="back">As it was</button></form>
<div>
<p class="error" id="error" role="alert"></p>
<p class="soft" id="status" role="status"></p>
<table><thead><tr><th scope="col">figure</th><th scope="col">now</th>
<th scope="col">at first</th></tr></thead><tbody id="figures"></tbody></table>
<div id="panels">{"".join(_panels(told))}</div>
<p class="soft" id="took"></p>
<p>The same on your machine:</p>
<code id="command"></code>
</div></div></main>
<script type="application/json" id="told">{data}</script>
<script type="text/plain" id="module">{packed}</script>
<script type="module">{script}</script>
</body></html>
"""


def _controls(told: Mapping[str, Any]) -> Iterator[str]:
    start = told["variants"][told["start"]]
    rate, latency = told["rates"], told["latencies"]
    yield "<fieldset><legend>Time</legend>"
    at = rate.index(start["rate"])
    yield _slider("rate", "rate of the control", 0, len(rate) - 1, 1, at)
    at = latency.index(start["latency"])
    yield _slider("latency", "delay", 0, len(latency) - 1, 1, at)
    yield "</fieldset><fieldset><legend>Values</legend>"
    for i, slider in enumerate(told["sliders"]):
        first = slider["parameters"][0]
        label = slider["label"] or _about(first)
        yield _slider(f"slider-{i}", label, slider["low"], slider["high"], 0.01, 1)
    for i, switch in enumerate(told["switches"]):
        checked = " checked" if switch["value"] else ""
        yield (
            f'<label class="switch"><input type="checkbox" id="switch-{i}"{checked}> '
            f"{escape(_about(switch))}</label>"
        )
    yield "</fieldset>"


def _about(parameter: Mapping[str, Any]) -> str:
    return f"{parameter['name']}: {parameter['about']}"


def _slider(
    name: str, label: str, low: float, high: float, step: float, value: float
) -> str:
    return (
        f'<div class="slider"><label for="{name}">{escape(label)}</label>'
        f'<span id="{name}-is"></span><input type="range" id="{name}" '
        f'min="{low}" max="{high}" step="{step}" value="{value}"></div>'
    )


def _panels(told: Mapping[str, Any]) -> Iterator[str]:
    for i, panel in enumerate(told["panels"]):
        title = {
            "error": "{name}: {against} less {of}, in {unit}",
            "peak": "{of} in {unit}",
            "contour": "{name}",
        }[panel["kind"]].format(**panel)
        yield (
            f'<div id="panel-{i}"><h2 id="panel-{i}-is">{escape(title)}</h2>'
            f'<svg role="img" aria-labelledby="panel-{i}-is"></svg></div>'
        )
