"""What is said of a response: figures, sentences, JSON, a table, python-control."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator.errors import ResponseError
from orchestrator.quantities.quantity import Quantity
from orchestrator.report.responded import Curve
from orchestrator.response.margins import Margins, delayed, margins
from orchestrator.response.measure import Response
from orchestrator.scenario.responses import FIGURES

if TYPE_CHECKING:
    import control

LINEAR = 0.01  # of S, at half the amplitude


def figures(name: str, found: Response) -> dict[str, Quantity]:
    """Return ``<name>.phase_margin_deg`` and the like, the worst of several loops."""
    values = {
        key: min((float(getattr(loop, key)) for loop in found.loops), key=abs)
        for key in FIGURES
    }
    values["s_max"] = found.s_max[0]
    values["modulus_margin"] = 1 / found.s_max[0]
    return {
        f"{name}.{key}": Quantity(values[key], unit) for key, unit in FIGURES.items()
    }


def as_json(found: Response, table: Path) -> dict[str, Any]:
    """Return what ``response --json`` prints of one response."""
    size, hz = found.s_max
    told: dict[str, Any] = {
        "break": found.breaks[0] if len(found.breaks) == 1 else list(found.breaks),
        **_loop(found.loops[0]),
        "modulus_margin": 1 / size,
        "s_max": size,
        "s_max_hz": hz,
        "table": str(table),
        "amplitude": list(found.amplitude),
        "distortion": found.distortion,
        "alias": found.alias,
        "half_amplitude_change": found.half,
        "slowest_connection": found.slower,
        "latency": latencies(found) if len(found.breaks) == 1 else [],
        "words": list(words(found)),
    }
    if len(found.breaks) > 1:
        told["loops"] = [
            {"break": name, **_loop(loop)}
            for name, loop in zip(found.breaks, found.loops, strict=True)
        ]
    return told


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


def words(found: Response) -> Iterator[str]:
    """Yield what must be known of how the response was found."""
    where = ", ".join(found.breaks)
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
    yield f"distortion {100 * found.distortion:.2g} % of what answers"
    if not found.resolved:
        yield (
            f"the largest |S| is between two lines: give a --from below "
            f"{found.hz[0] / 2:g} Hz"
        )
    if found.half > LINEAR:
        yield (
            f"not linear: at half the amplitude S differs by up to "
            f"{20 * np.log10(1 + found.half):.2g} dB; the margins are those of this "
            f"amplitude and operating point"
        )
    if found.slower:
        yield (
            f"{where} is faster than its loop: S is the fundamental of each line, "
            f"{100 * found.alias:.2g} % appears at others, and its margins prove "
            f"nothing; break {found.slower} instead"
        )
    if min(loop.crossover_hz for loop in found.loops) < 4 * found.hz[0]:
        yield (
            f"crossovers are near the lowest line: give a --from below "
            f"{found.hz[0]:g} Hz"
        )


def curves(found: Response, label: str = "", *, other: bool = False) -> list[Curve]:
    """Return the loops of a response as they are drawn; ``other`` ones are grey."""
    return [
        Curve(
            f"{label}{broken}",
            found.hz,
            1 / found.S[:, i, i] - 1,
            found.S[:, i, i],
            1 - found.S[:, i, i],
            other,
        )
        for i, broken in enumerate(found.breaks)
    ]


def write_table(found: Response, file: Path) -> Path:
    """Write hz, real and imaginary parts of L, S and T, and coherence.

    Raises:
        ResponseError: the suffix is neither .csv nor .parquet.
    """
    columns = {"hz": found.hz}
    m = len(found.breaks)
    for name, values in (("L", found.L), ("S", found.S), ("T", found.T)):
        for i, j in np.ndindex(m, m):
            ending = f"[{i + 1},{j + 1}]" if m > 1 else ""
            columns[f"{name}_re{ending}"] = values[:, i, j].real
            columns[f"{name}_im{ending}"] = values[:, i, j].imag
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


def to_frd(found: Response) -> "control.FrequencyResponseData":
    """Return L for python-control, frequencies in rad/s."""
    import control

    return control.frd(
        np.moveaxis(found.L, 0, 2), 2 * np.pi * found.hz, dt=float(found.sample)
    )
