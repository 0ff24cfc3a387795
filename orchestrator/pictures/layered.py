"""Layered layout of a graph by ELK, the layout library of elkjs.

``elkjs/elk.bundled.js`` (Eclipse Public License 2.0) is the file of elkjs 0.12.1 as
it is published.  It is carried out by QuickJS, which has neither timers nor threads:
the library's single message is passed here.  What was laid out is kept in the cache.
"""

import json
from collections.abc import Mapping
from functools import cache
from hashlib import sha256
from pathlib import Path
from threading import Lock
from typing import Any

from fmus.cache import building, cache_folder, digest, entry, publish

LIBRARY = Path(__file__).parent / "elkjs" / "elk.bundled.js"
LAID_OUT = "graph.json"
SECONDS = 60  # CPU time after which a layout is given up
_ONE_AT_A_TIME = Lock()  # a context belongs to one thread at a time

_HOST = """
var window = globalThis, waiting = [], found = null, failed = null;
var console = { log() {}, warn() {}, error() {} };
function setTimeout(call) { waiting.push(call); return waiting.length; }
function clearTimeout() {}
function layOut(text) {
  found = failed = null;
  new ELK().layout(JSON.parse(text)).then(
    (graph) => { found = JSON.stringify(graph); },
    (error) => { failed = String(error); });
}
"""


def laid_out(graph: Mapping[str, Any]) -> dict[str, Any]:
    """Return an ELK graph with the places of its boxes, edges and labels.

    Raises:
        RuntimeError: ELK cannot lay it out.
    """
    text = json.dumps(graph, sort_keys=True)
    key = sha256((digest(LIBRARY) + text).encode()).hexdigest()[:32]
    place = cache_folder() / "layouts" / key
    for file in entry(place).values():
        kept: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        return kept
    from quickjs import JSException

    try:
        found = _asked(text)
    except JSException as error:
        raise RuntimeError(f"ELK: {error}") from None
    with building(place.parent) as folder:
        (folder / LAID_OUT).write_text(found, encoding="utf-8")
        publish([folder / LAID_OUT], place)
    placed: dict[str, Any] = json.loads(found)
    return placed


def _asked(text: str) -> str:
    with _ONE_AT_A_TIME:
        context = _context()
        context.get("layOut")(text)
        while context.get("found") is None and context.get("failed") is None:
            if not context.execute_pending_job() and not context.eval(
                "waiting.length ? (waiting.shift()(), true) : false"
            ):
                raise RuntimeError("ELK ends without an answer")
        if context.get("failed") is not None:
            raise RuntimeError(f"ELK: {context.get('failed')}")
        return str(context.get("found"))


@cache
def _context() -> Any:
    """Return an interpreter that has read the library (0.4 s)."""
    import quickjs

    context = quickjs.Context()
    context.set_max_stack_size(0)  # that of the calling thread is not known
    context.set_time_limit(SECONDS)
    context.eval(_HOST)
    context.eval(LIBRARY.read_text(encoding="utf-8"))
    return context
