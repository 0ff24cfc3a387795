"""The faults of a system as the structures of faults.h, for one run or W lanes."""

from collections.abc import Callable, Iterator, Sequence
from ctypes import addressof, c_int64
from fractions import Fraction
from math import ceil
from typing import Any

import numpy as np

from orchestrator.master.layout import Faulty, Wiring
from orchestrator.master.remembered import Words
from orchestrator.native import library as c
from orchestrator.system import Fault

FOR_EVER = 2**63 - 1
Rooms = Callable[[int], int]  # address of so many numbers, which the caller keeps
Arrays = Callable[[Any, Sequence[Any]], Any]


def faulty_places(
    wiring: Wiring,
    tick: Fraction,
    vector: int,
    rooms: Rooms,
    arrays: Arrays,
    lanes: int = 1,
) -> Iterator[Any]:
    """Yield a structure for every number that has faults.

    ``vector`` is the address of the master's, ``arrays`` returns a C array of
    structures that the caller keeps.
    """
    kind, parts = c.faulty_structure(lanes), list(wiring.parts)
    for faulty in wiring.faulty:
        chain = arrays(c.Fault, [_fault(f, faulty, tick, rooms) for f in faulty.faults])
        back = faulty.affine.inverse()
        yield kind(
            place=vector + 8 * lanes * faulty.place,
            faults=addressof(chain),
            n=len(faulty.faults),
            source=parts.index(faulty.edge.source),
            converts=faulty.affine.converts,
            gain=faulty.affine.gain,
            offset=faulty.affine.offset,
            back_gain=back.gain,
            back_offset=back.offset,
        )


def memories(faulty: Sequence[Any], n: int) -> list[Words]:
    """Return views of what the first n of these structures remember, for one run."""
    found: list[Words] = []
    for one in faulty[:n]:
        places = [(addressof(one), 1)]  # of clean, which comes first
        for fault in (c.Fault * one.n).from_address(one.faults):
            places.append((fault.memory, fault.samples + 1))
        for at, size in places:
            memory: Any = (c_int64 * size).from_address(at)
            found.append(np.frombuffer(memory, np.int64))
    return found


def _fault(fault: Fault, faulty: Faulty, tick: Fraction, rooms: Rooms) -> c.Fault:
    value = fault.value
    if faulty.dtype != "float64":
        bits = np.array(int(value), dtype=faulty.dtype).view(np.float64)
        value = float(bits)
    return c.Fault(
        kind=c.LAWS.index(fault.kind),
        samples=fault.samples,
        start=ceil(fault.start / tick),
        end=FOR_EVER if fault.end is None else ceil(fault.end / tick),
        value=value,
        memory=rooms(fault.samples + 1),
    )
