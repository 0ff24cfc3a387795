"""The faults of a composition as C, for a loop that runs without Python.

The same structures as ``orchestrator/master/faulty.py`` makes for the executors.
"""

from collections.abc import Iterator
from fractions import Fraction
from math import ceil

from orchestrator.master.faulty import FOR_EVER
from orchestrator.master.layout import Wiring
from orchestrator.native.library import LAWS


def faults_kept(wiring: Wiring) -> Iterator[str]:
    """Yield the members of the memory."""
    if not wiring.faulty:
        return
    yield f"    Faulty faults[{len(wiring.faulty)}];"
    for i, faulty in enumerate(wiring.faulty):
        yield f"    Fault chain_{i}[{len(faulty.faults)}];"
        for j, fault in enumerate(faulty.faults):
            yield f"    V past_{i}_{j}[{fault.samples + 1}];"


def faults_bound(wiring: Wiring) -> dict[str, str]:
    """Return where pointers of the memory lead."""
    found = {"e.faults": "m->faults"} if wiring.faulty else {}
    for i, faulty in enumerate(wiring.faulty):
        found[f"faults[{i}].place"] = f"m->vector + {faulty.place}"
        found[f"faults[{i}].faults"] = f"m->chain_{i}"
        for j, _ in enumerate(faulty.faults):
            found[f"chain_{i}[{j}].memory"] = f"m->past_{i}_{j}"
    return found


def faults_started(wiring: Wiring, tick: Fraction) -> Iterator[str]:
    """Yield the statements that fill the structures."""
    parts = list(wiring.parts)
    for i, faulty in enumerate(wiring.faulty):
        there, back = faulty.affine, faulty.affine.inverse()
        numbers: dict[str, object] = {
            "n": len(faulty.faults),
            "source": parts.index(faulty.edge.source),
            "converts": int(there.converts),
            "gain": there.gain.hex(),
            "offset": there.offset.hex(),
            "back_gain": back.gain.hex(),
            "back_offset": back.offset.hex(),
        }
        yield from (f"    m->faults[{i}].{n} = {v};" for n, v in numbers.items())
        for j, fault in enumerate(faulty.faults):
            end = FOR_EVER if fault.end is None else ceil(fault.end / tick)
            facts: dict[str, object] = {
                "kind": LAWS.index(fault.kind),
                "samples": fault.samples,
                "start": ceil(fault.start / tick),
                "end": end,
                "value": float(fault.value).hex(),
            }
            yield from (f"    m->chain_{i}[{j}].{n} = {v};" for n, v in facts.items())
