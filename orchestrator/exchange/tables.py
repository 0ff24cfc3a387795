"""A run as one file that other tools read: CSV, MAT or HDF5, by the suffix.

``.csv``   a column per signal, headed ``name [unit]``, numbers that read back to
           the same bits; one rate per file, so that a run of several says ``at``
``.mat``   MATLAB level 4 as Dymola and OpenModelica write trajectories: matrices
           Aclass, name, description, dataInfo, data_1 (what does not change) and
           data_2, data_3, ... with time first, one per rate, the highest first
``.h5``    a group per rate with ``time`` and a dataset per signal; ``unit`` and
           ``published`` are attributes

A signal recorded at several rates is written at the highest.  Nothing is
interpolated.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from orchestrator.errors import ScenarioError
from orchestrator.plugins import load, named
from orchestrator.quantities.quantity import rate
from orchestrator.result import Result, Signal

Table: TypeAlias = dict[str, Signal]
Tables: TypeAlias = Mapping[Fraction, Table]
Writer: TypeAlias = Callable[[Tables, Path], None]


def export(folder: Path, target: Path, at: Fraction | None = None) -> Path:
    """Write the rows of a run into a file of the form that its suffix says.

    ``at`` (s) takes the rows of one period only.

    Raises:
        ScenarioError: an unknown suffix, no rows, or several rates for one CSV file.
    """
    form = _form(target.suffix.lower())
    if form is None:
        known = ", ".join([*_FORMS, *named("writers")])
        raise ScenarioError(f"{target}: write a file that ends in one of {known}")
    tables = _tables(Result(folder), at)
    target.parent.mkdir(parents=True, exist_ok=True)
    form(tables, target)
    return target


def _tables(result: Result, at: Fraction | None) -> Tables:
    """Return the signals by row period, each at its highest rate alone."""
    periods = [at] if at is not None else result.periods
    tables: dict[Fraction, Table] = {}
    seen: set[str] = set()
    for period in periods:
        of_period = result.at(period)
        table = {name: of_period[name] for name in of_period if name not in seen}
        seen.update(table)
        if table:
            tables[period] = table
    if not tables:
        rates = ", ".join(map(rate, result.periods)) or "no rate at all"
        wanted = "" if at is None else f" at {rate(at)}"
        raise ScenarioError(f"{result.folder}: has no rows{wanted}; it has {rates}")
    return tables


def _csv(tables: Tables, target: Path) -> None:
    if len(tables) > 1:
        rates = " or ".join(f'"{period}"' for period in tables)
        raise ScenarioError(
            f"{target}: the run has rows of {len(tables)} rates, which do not go into "
            f"one CSV file; choose one with --at {rates}, or write .mat or .h5"
        )
    ((_, table),) = tables.items()
    head = ["time [s]", *(_headed(signal) for signal in table.values())]
    first = next(iter(table.values()))
    columns = [first.time, *(signal.values for signal in table.values())]
    with target.open("w", encoding="utf-8", newline="") as file:
        file.write(",".join(map(_quoted, head)) + "\r\n")
        for row in zip(*(column.tolist() for column in columns), strict=True):
            file.write(",".join(map(repr, row)) + "\r\n")


def _headed(signal: Signal) -> str:
    return signal.name if signal.unit == "1" else f"{signal.name} [{signal.unit}]"


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"') else text


def _mat(tables: Tables, target: Path) -> None:
    from scipy.io import savemat

    names, told, info = ["time"], ["[s]"], [(0, 1, 0, -1)]
    data: dict[str, NDArray[np.float64]] = {}
    ends = [
        t for table in tables.values() for s in table.values() for t in s.time[[0, -1]]
    ]
    data["data_1"] = np.array([[min(ends), max(ends)]])
    for number, table in enumerate(tables.values(), start=2):
        rows = [next(iter(table.values())).time]
        for signal in table.values():
            rows.append(np.asarray(signal.values, dtype=float))
            names.append(signal.name)
            told.append("" if signal.unit == "1" else f"[{signal.unit}]")
            info.append((number, len(rows), 0, -1))  # linear between, nothing beyond
        data[f"data_{number}"] = np.array(rows)
    content: dict[str, Any] = {
        "Aclass": _letters(["Atrajectory", "1.1", "", "binTrans"]),
        "name": np.ascontiguousarray(_letters(names).T),
        "description": np.ascontiguousarray(_letters(told).T),
        "dataInfo": np.array(info, dtype=np.int32).T,
        **data,
    }
    savemat(target, content, format="4")


def _letters(texts: list[str]) -> NDArray[np.str_]:
    """Return texts as a matrix of letters, one row each."""
    plain = [text.encode("ascii", "backslashreplace").decode() for text in texts]
    width = max(1, *map(len, plain))
    return np.array([list(text.ljust(width)) for text in plain])


def _hdf5(tables: Tables, target: Path) -> None:
    import h5py

    with h5py.File(target, "w") as file:
        file.attrs["format"] = 1
        for period, table in tables.items():
            group = file.create_group(
                f"every_{period.numerator}_{period.denominator}_s"
            )
            group.attrs["period"] = str(period)
            first = next(iter(table.values()))
            group.create_dataset("time", data=first.time, **_PACKED).attrs["unit"] = "s"
            for name, signal in table.items():
                made = group.create_dataset(name, data=signal.values, **_PACKED)
                made.attrs["unit"] = str(signal.unit)
                if signal.published is not None:
                    made.attrs["published"] = str(signal.published)


_PACKED: dict[str, Any] = {"compression": "gzip", "shuffle": True}


def _form(suffix: str) -> Writer | None:
    if suffix in named("writers"):
        writer: Writer = load("writers", suffix)
        return writer
    return _FORMS.get(suffix)


_FORMS: dict[str, Writer] = {".csv": _csv, ".mat": _mat, ".h5": _hdf5}
