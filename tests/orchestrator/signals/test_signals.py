"""Signals of files against exact fractions; what is refused of them, in words."""

from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from scipy.io import savemat

from orchestrator.errors import FeedDriveError, ScenarioError
from orchestrator.pytest_plugin import assert_fmu_conforms
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import scenario_from
from orchestrator.session import execute, run_earlier
from orchestrator.signals.columns import read_columns
from orchestrator.signals.recording import Recording, play
from orchestrator.signals.ticks import rows_of, ticks, values_at

PLANT = {"fmu": "plants.ball_screw.two_mass", "step": "1/10000"}


def csv(file: Path, times: list[str], values: list[float]) -> Path:
    rows = "".join(f"{t},{v!r}\n" for t, v in zip(times, values, strict=True))
    file.write_text(f"t [s],F [V]\n{rows}")
    return file


def exactly(
    times: list[str], values: list[float], tick: Fraction, linear: bool
) -> float:
    """The value at a tick by fractions alone, from the text of the cells."""
    exact = [Fraction(t) for t in times]
    i = max(k for k, t in enumerate(exact) if t <= tick)
    if not linear or exact[i] == tick or i == len(exact) - 1:
        return values[i]
    a, b = Fraction(values[i]), Fraction(values[i + 1])
    return float(a + (b - a) * (tick - exact[i]) / (exact[i + 1] - exact[i]))


@pytest.mark.parametrize("interpolation", ["hold", "linear"])
@pytest.mark.parametrize("step", ["1/20000", "1/3000", "7/11000"])
def test_every_tick_has_the_bits_of_the_exact_interpolation(
    tmp_path: Path, interpolation: str, step: str
) -> None:
    """Uneven decimal times, values over twenty decades, a run of the scenario."""
    random = np.random.default_rng(17)
    numbers = np.cumsum(random.integers(1, 400, size=300)) - 1
    times = ["0", *(f"{n / 1e6:.6f}" for n in numbers)]
    values = (random.normal(size=301) * 10.0 ** random.integers(-10, 10, 301)).tolist()
    file = csv(tmp_path / "force.csv", times, values)
    period, linear = Fraction(step), interpolation == "linear"
    last = Fraction(times[-1])
    stop = (last // period) * period
    tables = {
        "stop": str(stop),
        "components": {
            "force": {"data": file.name, "step": step, "interpolation": interpolation}
        },
        "record": {"force.F": True},
    }
    scenario = scenario_from(tables, tmp_path / "s.toml")
    done = execute(compose(scenario, run_earlier), tmp_path / "run", report=False)
    found = done["force.F"].values
    assert len(found) == stop / period + 1
    for k in range(len(found)):
        assert found[k] == exactly(times, values, k * period, linear), k


def test_a_million_rows_play_back_unchanged_and_halfway(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    """What was recorded at 10 kHz is what runs at 10 kHz, at 20 kHz with midpoints."""
    n = 1_000_000 if request.config.getoption("--every-form") else 20_000
    values = np.random.default_rng(4).normal(size=n).tolist()
    times = [f"{k / 10_000:.4f}" for k in range(n)]
    file = csv(tmp_path / "force.csv", times, values)
    columns = read_columns(file)
    rows = rows_of(columns)
    assert rows.period == Fraction(1, 10_000)
    for rate, count in ((10_000, n), (20_000, 2 * n - 1)):
        places = ticks(rows, Fraction(1, rate), Fraction(0), count)
        found = values_at(columns.values["F"], places, "linear").tolist()
        assert found[:: rate // 10_000] == values
    halves = [float((Fraction(a) + Fraction(b)) / 2) for a, b in pairwise(values)]
    assert found[1::2] == halves


def test_a_third_of_a_kilohertz_is_exact_only_if_its_rate_is_said(
    tmp_path: Path,
) -> None:
    """Truncated decimals are other instants; ``rate`` says which are meant."""
    times, values = [f"{k / 3000:.6f}" for k in range(7)], [float(k) for k in range(7)]
    file = csv(tmp_path / "force.csv", times, values)
    period = Fraction(1, 3000)
    for rate, expected in ((None, [0, 1, 1, 3, 4, 4, 6]), (period, range(7))):
        rows = rows_of(columns := read_columns(file), rate)
        places = ticks(rows, period, Fraction(0), 7)
        held = values_at(columns.values["F"], places, "hold")
        assert held.tolist() == list(map(float, expected)), rate


def test_parquet_and_mat_give_what_csv_gives(tmp_path: Path) -> None:
    times, values = [k / 1000 for k in range(50)], np.sin(np.arange(50.0)).tolist()
    from_csv = read_columns(csv(tmp_path / "a.csv", list(map(str, times)), values))
    fields = [pa.field("time", pa.float64(), metadata={"unit": "s"})]
    fields.append(pa.field("F", pa.float64(), metadata={"unit": "V"}))
    arrays = [pa.array(times), pa.array(values)]
    table = pa.Table.from_arrays(arrays, schema=pa.schema(fields))
    pyarrow.parquet.write_table(table, tmp_path / "a.parquet")
    savemat(tmp_path / "a.mat", {"t": times, "F": values})
    for name, unit in (("a.parquet", "V"), ("a.mat", "1")):
        found = read_columns(tmp_path / name)
        assert found.units == {"F": unit}
        assert found.values["F"].tolist() == from_csv.values["F"].tolist()
        same = rows_of(found).numbers == rows_of(from_csv).numbers
        assert same.all()


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_fmu_of_a_file_keeps_to_the_standard(tmp_path: Path, fmi: int) -> None:
    file = csv(tmp_path / "force.csv", ["0", "0.001", "0.002"], [1.0, 2.0, 4.0])
    fmu = play(Recording(file), fmi=fmi, folder=tmp_path / "built").fmu
    assert_fmu_conforms(fmu)


def test_an_fmu_without_its_resources_says_so(tmp_path: Path, slave) -> None:  # type: ignore[no-untyped-def]
    from zipfile import ZipFile

    file = csv(tmp_path / "force.csv", ["0", "0.001"], [1.0, 2.0])
    fmu = play(Recording(file)).fmu
    bare = tmp_path / "bare.fmu"
    with ZipFile(fmu) as whole, ZipFile(bare, "w") as archive:
        for name in whole.namelist():
            if not name.startswith("resources/"):
                archive.writestr(name, whole.read(name))
    with pytest.raises(Exception, match="instantiate"):
        slave(bare)


EVERY_S = {"rate": "1"}
SAID = {
    "at_end": ("t [s],F [V]\n0,1\n1,2\n", {}, 'say at_end = "hold"'),
    "begin": ("t [s],F [V]\n1,1\n9,2\n", {}, 'begin = "1"'),
    "uneven": ("t [s],F [V]\n0,1\n1,2\n3,3\n", {}, "not evenly spaced"),
    "back": ("t [s],F [V]\n0,1\n2,2\n1,3\n", {}, "does not increase from row 2 to 3"),
    "no number": (
        "t [s],F [V]\n0,1\n1,\n2,3\n",
        {},
        "F is nan in row 2, which is no finite number",
    ),
    "text": ("t [s],F [V]\n0,1\n1,on\n", {}, "cannot be read"),
    "no time": ("F [V]\n0\n1\n", {}, 'rate = "10 kHz"'),
    "digits": (
        "t [s],F [V]\n0,1\n0.10000000000000003,2\n",
        {},
        "more than 15 digits",
    ),
    "beside": ("t [s],F [V]\n0,1\n1.2,2\n", {"rate": "1"}, "row 2 is at 1.2 s"),
    "empty line": ("F [V]\n0\n1\n\n3\n\n", EVERY_S, "line 4 is empty, a missing cell"),
    "empty lines": ("F,G\r\n0,1\r\n\r\n\r\n3,4\r\n", EVERY_S, "line 3 is empty"),
    "kilohertz": ("t [kHz],F [V]\n0,1\n9,2\n", {}, "'kHz' is no unit of time"),
    "two times": ("t,T,F [V]\n0,1,1\n9,2,2\n", {}, "t and T may each be the time"),
    "two units": ("t [s],time [ms],F\n0,1,1\n9,2,2\n", {}, "t and time may each"),
    "unit": ("t [s],F [Vx]\n0,1\n1,2\n", {}, "F [Vx]"),
    "twice": ("t [s],F [V],F [V]\n0,1,1\n1,2,2\n", {}, "heads two columns"),
    "name": ("t [s],motor force [V]\n0,1\n9,2\n", {}, "cannot name a signal"),
    "key": ("t [s],F [V]\n0,1\n9,2\n", {"fmu": "plants.x"}, "give fmu"),
}


@pytest.mark.parametrize("case", SAID)
def test_what_is_not_sure_is_refused_in_words(case: str, tmp_path: Path) -> None:
    text, options, expected = SAID[case]
    (tmp_path / "force.csv").write_text(text)
    tables = {
        "stop": "5",
        "components": {"force": {"data": "force.csv", **options}},
        "record": {"force.F": True},
    }
    with pytest.raises((ScenarioError, FeedDriveError)) as refused:
        compose(scenario_from(tables, tmp_path / "s.toml"), run_earlier)
    assert expected in str(refused.value)


@pytest.mark.parametrize(("at_end", "stop"), [("hold", 5), ("end", 1)])
def test_the_end_of_a_file_is_held_or_ends_the_run_and_is_said(
    at_end: str, stop: int, tmp_path: Path
) -> None:
    file = csv(tmp_path / "force.csv", ["0", "1"], [1.0, 2.0])
    force = {"data": file.name, "at_end": at_end}
    tables = {"stop": "5", "components": {"force": force}, "record": {"force.F": True}}
    composition = compose(scenario_from(tables, tmp_path / "s.toml"), run_earlier)
    assert composition.system.stop == stop
    assert "force.csv ends at t = 1 s" in composition.warnings[0]
    done = execute(composition, tmp_path / "run", report=False)
    assert done["force.F"].values.tolist() == [1.0] + [2.0] * stop
    lock = (tmp_path / "run" / "scenario.lock.toml").read_text()
    assert composition.contents["force"] in lock


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"offset": "2 ms"}, [20, 20, 20, 30, 40, 50, 60, 70, 80, 90, 100]),
        ({"offset": "1/2000"}, [5, 5, 15, 25, 35, 45, 55, 65, 75, 85, 95]),
        (
            {"offset": "2 ms", "begin": "3 ms", "at_end": "hold"},
            [50, 50, 50, 60, 70, 80, 90, 100, 100, 100, 100],
        ),
    ],
)
def test_an_offset_shifts_the_ticks_and_not_the_data(
    options: dict[str, str], expected: list[float], tmp_path: Path
) -> None:
    times = [f"{k / 1000:.3f}" for k in range(11)]
    file = csv(tmp_path / "force.csv", times, [10.0 * k for k in range(11)])
    force = {"data": file.name, "interpolation": "linear", **options}
    tables = {
        "stop": "0.01",
        "components": {"force": force},
        "record": {"force.F": "1/1000"},
    }
    composition = compose(scenario_from(tables, tmp_path / "s.toml"), run_earlier)
    assert ["ends at t = 0.007 s" in w for w in composition.warnings] == (
        [True] if "begin" in options else []
    )
    done = execute(composition, tmp_path / "run", report=False)
    assert done["force.F"].values == pytest.approx(expected)


def test_a_file_that_ends_before_the_first_tick_is_refused(tmp_path: Path) -> None:
    file = csv(tmp_path / "force.csv", ["0", "0.001"], [1.0, 2.0])
    with pytest.raises(ScenarioError, match=r"before its first tick at 0\.002 s"):
        play(Recording(file, offset=Fraction(2, 1000)))


def test_empty_lines_behind_the_last_row_are_no_rows(tmp_path: Path) -> None:
    (tmp_path / "force.csv").write_text("\nF [V]\n0\n1\n3\n\n\n")
    assert read_columns(tmp_path / "force.csv").values["F"].tolist() == [0, 1, 3]


@pytest.mark.parametrize(
    ("head", "signals", "time"),
    [
        ("T,t [s],F", ["F", "T"], [0, 1]),
        ("T [degC],time,F", ["F", "T"], [0, 1]),
        ("t [ms],Time [s],F", ["F", "Time"], [20, 30]),
        ("T,G,F", ["F", "G"], [20, 30]),
    ],
)
def test_the_time_is_what_is_called_so_and_has_its_unit(
    tmp_path: Path, head: str, signals: list[str], time: list[float]
) -> None:
    (tmp_path / "force.csv").write_text(f"{head}\n20,0,1\n30,1,2\n")
    found = read_columns(tmp_path / "force.csv")
    assert found.time is not None
    assert (sorted(found.values), found.time.tolist()) == (signals, time)


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        (np.array([1, 2 + 3j]), "F is (2+3j) in row 2, which is complex"),
        (np.array([0, 2**53 + 1], np.int64), "F is 9007199254740993 in row 2"),
        (np.array([0, 2**64 - 1], np.uint64), "more digits than a double"),
    ],
)
def test_a_cell_of_mat_that_would_lose_a_part_is_refused(
    tmp_path: Path, cells: np.ndarray, said: str
) -> None:
    savemat(tmp_path / "force.mat", {"t": [0.0, 1.0], "F": cells})
    with pytest.raises(ScenarioError) as refused:
        read_columns(tmp_path / "force.mat")
    assert said in str(refused.value)


def test_whole_and_complex_cells_that_lose_nothing_are_read(tmp_path: Path) -> None:
    cells = {"F": np.array([0, -(2**62)]), "G": np.array([1 + 0j, 2])}
    savemat(tmp_path / "force.mat", {"t": [0.0, 1.0], **cells})
    found = read_columns(tmp_path / "force.mat").values
    assert found["F"].tolist() == [0, -(2.0**62)]
    assert found["G"].tolist() == [1, 2]
