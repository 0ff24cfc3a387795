"""What is said of a response: figures, sentences, JSON, a table, python-control."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ResponseError
from orchestrator.quantities.quantity import Quantity
from orchestrator.response.margins import Margins, delayed, margins
from orchestrator.response.measured import Measured, Response, Transfer
from orchestrator.response.traced import Traced
from orchestrator.scenario.responses import FIGURES

if TYPE_CHECKING:
    import control

LINEAR = 0.01  # of S, at half the amplitude


def figures(name: str, found: Measured) -> dict[str, Quantity]:
    """Return ``<name>.phase_margin_deg`` and the like.

    Of several breaks they are the worst: of one loop with the others closed, and of
    what changes at all breaks alike.

    From one input to one output they are ``peak`` and the like; between several
    there are none, since each has a unit of its own.
    """
    if isinstance(found, Transfer):
        return _of_transfer(name, found) if found.G[0].size == 1 else {}
    assert isinstance(found, Response)
    together = found.together if len(found.breaks) > 1 else ()
    values = worst(found.loops, together, found.s_max[0])
    return {
        f"{name}.{key}": Quantity(values[key], unit) for key, unit in FIGURES.items()
    }


def worst(
    loops: Sequence[Margins], together: Sequence[Margins], s_max: float
) -> dict[str, float]:
    """Return each of ``FIGURES``: of the loop, or of the eigenvalue of L, with the
    least; ``s_max`` and its inverse are of all together, crossovers of the loops."""
    values = {
        key: min((float(getattr(m, key)) for m in (*loops, *together)), key=abs)
        for key in FIGURES
    }
    values["crossover_hz"] = min(loop.crossover_hz for loop in loops)
    return {**values, "s_max": s_max, "modulus_margin": 1 / s_max}


def _of_transfer(name: str, found: Transfer) -> dict[str, Quantity]:
    size, hz = found.peak()
    unit = found.unit(0, 0)
    return {
        f"{name}.peak": Quantity(size, unit),
        f"{name}.peak_hz": Quantity(hz, "Hz"),
        f"{name}.bandwidth_hz": Quantity(found.bandwidth_hz(), "Hz"),
    }


def as_json(found: Measured, table: Path) -> dict[str, Any]:
    """Return what ``response --json`` prints of one response."""
    if isinstance(found, Transfer):
        return {**_ways(found), **_how(found, table)}
    assert isinstance(found, Response)
    size, hz = found.s_max
    told: dict[str, Any] = {
        "break": _one(found.breaks),
        **_loop(found.loops[0]),
        "modulus_margin": 1 / size,
        "s_max": size,
        "s_max_hz": hz,
        "latency": latencies(found) if len(found.breaks) == 1 else [],
        **_how(found, table),
    }
    if len(found.breaks) > 1:
        told["loops"] = [
            {"break": name, **_loop(loop)}
            for name, loop in zip(found.breaks, found.loops, strict=True)
        ]
        told["together"] = [_loop(locus) for locus in found.together]
    return told


def _how(found: Measured, table: Path) -> dict[str, Any]:
    return {
        "table": str(table),
        "amplitude": list(found.amplitude),
        "distortion": found.distortion,
        "alias": found.alias,
        "half_amplitude_change": found.half,
        "slowest_connection": found.slower,
        "words": list(words(found)),
    }


def _ways(found: Transfer) -> dict[str, Any]:
    ways = []
    for i, j in np.ndindex(*found.G.shape[1:]):
        size, hz = found.peak(i, j)
        bandwidth = found.bandwidth_hz(i, j)
        ways.append(
            {
                "excite": found.breaks[j],
                "observe": found.observed[i],
                "unit": str(found.unit(i, j)),
                "peak": size,
                "peak_hz": hz,
                "bandwidth_hz": bandwidth,
            }
        )
    if len(ways) == 1:
        return ways[0]
    whole = {"excite": _one(found.breaks), "observe": _one(found.observed)}
    return {**whole, "ways": ways}


def _one(names: tuple[str, ...]) -> str | list[str]:
    return names[0] if len(names) == 1 else list(names)


def _loop(loop: Margins) -> dict[str, Any]:
    return {
        "crossovers": [
            {"hz": c.hz, "phase_margin_deg": c.phase_margin_deg}
            for c in loop.crossovers
        ],
        "gain_margins": [{"hz": g.hz, "db": g.db} for g in loop.gain_margins],
        "delay_margin_s": loop.delay_margin_s,
    }


def latencies(found: Response) -> list[dict[str, float]]:
    """Return what the loop has left with one sample less, as it is, and with more."""
    L, T = found.L[:, 0, 0], float(found.sample)
    limit = found.loops[0].delay_margin_s
    rows = []
    for samples in range(-1, 4):
        late = margins(found.hz, delayed(found.hz, L, samples * T))
        held = samples * T < limit
        rows.append(
            {
                "samples": samples,
                "phase_margin_deg": late.phase_margin_deg,
                "gain_margin_db": late.gain_margin_db,
                "s_max": late.s_max if held else np.inf,
            }
        )
    return rows


def words(found: Measured) -> Iterator[str]:
    """Yield what must be known of how the response was found."""
    for name, unit, rms, (low, high) in zip(
        found.breaks, found.units, found.amplitude, found.range, strict=True
    ):
        yield (
            f"{name}: {rms:.3g} {unit} rms injected; without it between {low:.3g} and "
            f"{high:.3g} {unit} from {found.measured[0]:g} to {found.measured[1]:g} s, "
            f"{'in motion' if high - low > 1e-3 * rms else 'at rest'}"
        )
    yield (
        f"{len(found.hz)} lines from {found.hz[0]:.3g} to {found.hz[-1]:.5g} Hz, "
        f"{found.settled} periods of {float(found.period):g} s settling, realisations: "
        f"{found.realisations}"
    )
    yield from found.silent
    yield f"distortion {100 * found.distortion:.2g} % of what answers"
    if isinstance(found, Transfer):
        yield from _of_ways(found)
    if isinstance(found, Response):
        yield from _of_loops(found)


def _of_ways(found: Transfer) -> Iterator[str]:
    if not found.resolved:
        yield _unresolved(found, "|G|")
    if found.half > LINEAR:
        yield (
            f"not linear: at half the amplitude G differs by up to "
            f"{20 * np.log10(1 + found.half):.2g} dB; it is that of this amplitude and "
            f"operating point"
        )
    if found.slower:
        yield (
            f"{found.slower} is slower than {', '.join(found.breaks)}: G is the "
            f"fundamental of each line, {100 * found.alias:.2g} % appears at others"
        )


def _of_loops(found: Response) -> Iterator[str]:
    if not found.resolved:
        yield _unresolved(found, "|S|")
    if found.half > LINEAR:
        yield (
            f"not linear: at half the amplitude S differs by up to "
            f"{20 * np.log10(1 + found.half):.2g} dB; the margins are those of this "
            f"amplitude and operating point"
        )
    if found.slower:
        yield (
            f"{', '.join(found.breaks)} is faster than its loop: S is the fundamental "
            f"of each line, {100 * found.alias:.2g} % appears at others, and its "
            f"margins prove nothing; break {found.slower} instead"
        )
    if len(set(found.units)) > 1:
        yield (
            f"s_max and modulus_margin are of breaks in {', '.join(found.units)} "
            f"together, and change with these units; the loops' own margins do not"
        )
    if min(loop.crossover_hz for loop in found.loops) < 4 * found.hz[0]:
        yield (
            f"crossovers are near the lowest line: give a --from below "
            f"{found.hz[0]:g} Hz"
        )


def _unresolved(found: Measured, what: str) -> str:
    return (
        f"the largest {what} is between two lines: give a --from below "
        f"{found.hz[0] / 2:g} Hz"
    )


def write_table(found: Measured, file: Path, traced: Traced | None = None) -> Path:
    """Write hz, real and imaginary parts of L, S and T (or G), and coherence.

    Of several breaks also the singular values of S and the eigenvalues of L; with
    ``traced`` what the linearised equations give, ``L_traced_re`` or ``G_traced_re``.

    Raises:
        ResponseError: the suffix is neither .csv nor .parquet.
    """
    columns = {"hz": found.hz}
    m = len(found.breaks)
    for name, values in _matrices(found, traced):
        for i, j in np.ndindex(*values.shape[1:]):
            ending = f"[{i + 1},{j + 1}]" if values[0].size > 1 else ""
            columns[f"{name}_re{ending}"] = values[:, i, j].real
            columns[f"{name}_im{ending}"] = values[:, i, j].imag
    if isinstance(found, Response) and m > 1:
        for i in range(m):
            columns[f"sigma_S[{i + 1}]"] = found.singular[:, i]
            columns[f"lambda_L_re[{i + 1}]"] = found.loci[:, i].real
            columns[f"lambda_L_im[{i + 1}]"] = found.loci[:, i].imag
    for i in range(m):
        columns["coherence" + (f"[{i + 1}]" if m > 1 else "")] = found.coherence[:, i]
    if file.suffix == ".parquet":
        import pyarrow as pa
        import pyarrow.parquet as pq

        pq.write_table(pa.table(columns), file)
    elif file.suffix == ".csv":
        head = ",".join(f'"{c}"' if "," in c else c for c in columns)
        rows = np.column_stack(list(columns.values()))
        np.savetxt(file, rows, fmt="%.17g", delimiter=",", header=head, comments="")
    else:
        raise ResponseError(f"{file}: a table is written as .csv or .parquet")
    return file


def _matrices(
    found: Measured, traced: Traced | None
) -> Iterator[tuple[str, NDArray[np.complex128]]]:
    if isinstance(found, Transfer):
        yield "G", found.G
        if traced:
            yield "G_traced", traced.G
    if isinstance(found, Response):
        yield from (("L", found.L), ("S", found.S), ("T", found.T))
        if traced:
            yield "L_traced", traced.L


def to_frd(found: Response | Transfer) -> "control.FrequencyResponseData":
    """Return L, or G of a transfer, for python-control, frequencies in rad/s."""
    import control

    values = found.G if isinstance(found, Transfer) else found.L
    return control.frd(
        np.moveaxis(values, 0, 2), 2 * np.pi * found.hz, dt=float(found.sample)
    )
