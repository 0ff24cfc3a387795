"""How many members a vector of this machine holds best.

Measured once per machine, on two plants and a controller, and kept in
the cache.  No bit of a result depends on it.
"""

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from time import thread_time

from fmus.build import build
from fmus.cache import cache_folder
from orchestrator.master.fused.lanes import Lanes
from orchestrator.master.fused.library import processor
from orchestrator.master.simulate import plan
from orchestrator.system import Component, System

WIDTHS = (4, 8, 16, 32)
WIDER = 0.8  # of a member's time, at most, for which rows twice as wide are taken
MODELS = (
    "plants.ball_screw.two_mass",
    "controllers.ball_screw.mc_ppc",
    "plants.leadscrew.axis",
)
PERIOD, INSTANTS, ROUNDS = Fraction(1, 20_000), 10_000, 5


@cache
def width() -> int:
    """Return the width that this machine was found to be fastest with.

    Raises:
        CompileError: it is not known yet, and there is no compiler.
    """
    kept = cache_folder() / "fused" / f"width-{processor()}"
    if kept.is_file() and (text := kept.read_text(encoding="ascii")).isdigit():
        return int(text)
    found = fastest(WIDTHS)
    kept.parent.mkdir(parents=True, exist_ok=True)
    fresh = Path(mkdtemp(dir=kept.parent, prefix=".width-")) / kept.name
    fresh.write_text(str(found), encoding="ascii")
    fresh.replace(kept)
    fresh.parent.rmdir()
    return found


def fastest(widths: Sequence[int]) -> int:
    """Return the one of some widths at which a member takes least time."""
    best, least = widths[0], float("inf")
    for one in widths:
        took = _per_member(one)
        if took < WIDER * least:
            best, least = one, took
    return best


def _per_member(lanes: int) -> float:
    """Return the least time (s of the processor) of a member in some rounds."""
    parts = [Component(f"c{i}", build(m), PERIOD) for i, m in enumerate(MODELS)]
    stop = INSTANTS * PERIOD
    given = System("width", stop, {p.name: p for p in parts}, {}, {"c0.x_2": (stop,)})
    loop = Lanes(plan(given), frozenset(given.record), lanes)
    times = []
    for _ in range(ROUNDS + 1):  # the first compiles
        begun = thread_time()
        list(loop.run([{}] * lanes))
        times.append(thread_time() - begun)
    return min(times[1:]) / lanes
