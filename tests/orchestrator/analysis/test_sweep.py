"""Every member of a sweep has the figures of ``run`` with its values."""

import json
import shlex
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from foreign import foreign
from typer.testing import CliRunner

from orchestrator.analysis import members
from orchestrator.analysis import width as measured
from orchestrator.analysis.breaks import until_breaks
from orchestrator.analysis.members import Job, Workers
from orchestrator.analysis.sweep import sweep
from orchestrator.analysis.variations import Axis, Tolerance, grid, parse_axis, sample
from orchestrator.cli import app
from orchestrator.errors import ScenarioError
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run, run_earlier

EXAMPLE = Path(__file__).parents[3] / "docs" / "examples" / "does_it_hold"
DRIVE = EXAMPLE / "drive.toml"
SHORT = ["stop=0.05"]
HELD = """
base = "ball_screw_pole_placement/mc_ppc_track_500"
[expect]
"tracking.peak" = { below = 4, unit = "um" }
"""


def nominal(_: str) -> float:
    return 2.0


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a.b=1:2:3", (1.0, 1.5, 2.0)),
        ("a.b=+-50%:3", (1.0, 2.0, 3.0)),
        ("a.b=0,1,2", ("0", "1", "2")),
        ("a.b=0.5,1.5", (0.5, 1.5)),
        ("rates.c=5 kHz,10 kHz", ("5 kHz", "10 kHz")),
        ("a.b=1 kg:2 kg:2", ("1.0 kg", "2.0 kg")),
    ],
)
def test_an_axis_is_read_as_written(text: str, values: tuple[object, ...]) -> None:
    assert parse_axis(text, nominal).values == values


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("a.b", "key=a:b:n"),
        ("a.b=1:2:1", "at least 2"),
        ("a.b=1:2:x", "at least 2"),
        ("a.b=x:2:3", "no range"),
        ("a.b=1 kg:2 m:3", "two units"),
    ],
)
def test_what_is_no_axis_is_refused(text: str, word: str) -> None:
    with pytest.raises(ScenarioError, match=word):
        parse_axis(text, nominal)


def test_a_key_is_varied_once() -> None:
    with pytest.raises(ScenarioError, match="twice"):
        list(grid([Axis("a.b", (1.0,)), Axis("a.b", (2.0,))]))


def test_a_sample_has_its_distributions() -> None:
    tolerances = [Tolerance("u", "uniform", 1, 3), Tolerance("n", "normal", 5, 0.5)]
    for method in ("sobol", "lhs", "normal"):
        drawn = sample(tolerances, method, 512, seed=3)  # type: ignore[arg-type]
        u = np.array([float(a["u"]) for a in drawn])
        n = np.array([float(a["n"]) for a in drawn])
        assert u.min() >= 1
        assert u.max() <= 3
        assert u.mean() == pytest.approx(2, abs=0.1)
        assert (n.mean(), n.std()) == pytest.approx((5, 0.5), abs=0.1)
        assert drawn == sample(tolerances, method, 512, seed=3)  # type: ignore[arg-type]


@pytest.mark.parametrize("many", [1, 10**9], ids=["lanes", "loaded"])
def test_members_have_the_figures_of_runs(
    many: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(members, "MANY", many)
    axes = [Axis("plant.m_2", (3e-4, 4e-4)), Axis("controller.latency", ("1", "2"))]
    found = sweep(DRIVE, axes, sets=SHORT, folder=tmp_path)
    assert found.executors == ("lanes" if many == 1 else "kernel",)
    table = pq.read_table(tmp_path / "figures.parquet").to_pylist()
    for row, kept in zip(found.rows, table, strict=True):
        sets = [*SHORT, *(f"{key}={row[key]}" for key in found.keys)]
        alone = run(load_scenario(DRIVE, sets), tmp_path / str(row["member"]))
        for name, figure in alone.metrics.items():
            assert row[name] == figure.value == kept[name]
        assert row["met"] == all(c.met for c in alone.checks)


def test_a_design_does_not_follow_a_varied_plant(tmp_path: Path) -> None:
    axis = Axis("plant.m_2", (3e-4, 5e-4))
    plain = sweep(DRIVE, [axis], sets=SHORT)
    for row in plain.rows:
        alone = run(
            load_scenario(DRIVE, [*SHORT, f"plant.m_2={row['plant.m_2']}"]),
            tmp_path / str(row["member"]),
        )
        assert row["tracking.peak"] == alone.metrics["tracking.peak"].value
    varied = Axis("design.gains.m_2", (3e-4, 5e-4))
    designed = sweep(DRIVE, [varied], sets=SHORT)
    assert designed.rows[0]["tracking.peak"] != designed.rows[1]["tracking.peak"]


FOREIGN = """
stop = "1/100"
[components.source]
fmu = "controllers.references.stair"
step = "1/1000"
[components.alien]
fmu = "{fmu}"
step = "1/1000"
[connections]
"alien.in_Real" = "source.x_r"
[record]
"alien.out_Real" = true
[metrics]
y = {{ kind = "peak", of = "alien.out_Real" }}
"""


def test_foreign_fmus_stay_loaded_and_a_failing_member_is_named(
    tmp_path: Path,
) -> None:
    file = tmp_path / "loop.toml"
    file.write_text(FOREIGN.format(fmu=foreign(2, tmp_path)))
    heights = (1e-3, float("inf"), 3e-3)
    composition = compose(load_scenario(file), run_earlier)
    jobs = [Job(i, {"source": {"height": h}}) for i, h in enumerate(heights)]
    with closing(Workers()) as workers:
        found = list(workers(composition, 3).run(jobs))
    first, second, third = sorted(found, key=lambda outcome: outcome.index)
    assert first.failure is None
    assert "finite" in str(second.failure)
    assert third.failure is None
    for height, outcome in ((1e-3, first), (3e-3, third)):
        changed = load_scenario(file, [f"source.height={height}"])
        alone = run(changed, tmp_path / repr(height))
        assert outcome.figures["y.peak"] == alone.metrics["y.peak"]


WEIGHED = """\
from typing import Annotated, NamedTuple
from fmus.model import Continuous, Var
class State(NamedTuple):
    v: Annotated[float, Var("m/s", "speed")] = 0.0
class Input(NamedTuple):
    f: Annotated[float, Var("N", "force")] = 1.0
class Output(NamedTuple):
    v: Annotated[float, Var("m/s", "speed")]
class Parameters(NamedTuple):
    m: Annotated[float, Var("{unit}", "mass")] = {one}
def derivative(x: State, u: Input, p: Parameters) -> State:
    return State(u.f / (p.m / {one}))
def output(x: State, u: Input, p: Parameters) -> Output:
    return Output(x.v)
model = Continuous("Mass", derivative, output, State(), Input(), Parameters())
"""
PUSHED = """
stop = "1"
[components.plant]
fmu = "kg.py"
step = "1/100"
[record]
"plant.v" = true
[metrics]
v = { kind = "final", of = "plant.v" }
"""


def test_a_value_is_converted_to_the_unit_of_the_fmu_that_takes_it(
    tmp_path: Path,
) -> None:
    """One mass in kilogram, the same in gram."""
    for unit, one in (("kg", 1.0), ("g", 1000.0)):
        (tmp_path / f"{unit}.py").write_text(WEIGHED.format(unit=unit, one=one))
    file = tmp_path / "mass.toml"
    file.write_text(PUSHED)
    fmus = Axis("plant.fmu", (str(tmp_path / "kg.py"), str(tmp_path / "g.py")))
    found = sweep(file, [fmus, Axis("plant.m", ("2 kg", "4 kg"))])
    speeds = [row["v.final"] for row in found.rows]
    assert speeds == pytest.approx([0.5, 0.25, 0.5, 0.25])
    plain = sweep(file, [fmus, Axis("plant.m", (2.0, 4.0))])  # kg, as in the scenario
    assert [row["v.final"] for row in plain.rows] == speeds


def test_the_command_for_a_member_in_full_runs_that_member(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = Path("held.toml")
    file.write_text(HELD)
    given = ["--vary", "plant.m_2=8e-4", "--set", "stop=0.05"]
    done = CliRunner().invoke(app, ["sweep", str(file), *given])
    (line,) = (x for x in done.stdout.splitlines() if " in full: " in x)
    command = shlex.split(line.partition("feeddrive ")[2])
    assert command[:4] == ["run", "held.toml", "--set", "stop=0.05"]
    alone = CliRunner().invoke(app, [*command, "--json"])
    assert json.loads(alone.stdout)["stop"] == 0.05


def test_the_border_is_that_of_a_fine_grid() -> None:
    value, (down, up) = until_breaks(DRIVE, "plant.m_2")
    assert value == 0.379e-3
    assert down.breaks is not None
    assert up.breaks is not None
    assert 0 < up.breaks - up.holds <= 1e-4 * up.holds
    near = [Axis("plant.m_2", (down.breaks, down.holds, up.holds, up.breaks))]
    met = [row["met"] for row in sweep(DRIVE, near).rows]
    assert met == [False, True, True, False]
    grid_of = np.linspace(up.holds * 0.98, up.holds * 1.02, 41)
    rows = sweep(DRIVE, [Axis("plant.m_2", tuple(grid_of.tolist()))]).rows
    first = next(row["plant.m_2"] for row in rows if not row["met"])
    assert first - up.breaks == pytest.approx(0, abs=grid_of[1] - grid_of[0])


def test_the_command_prints_its_interface(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    command = ["sweep", str(DRIVE), "--vary", "plant.m_2=3e-4,8e-4", "--json"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert (told["members"], told["failed"], told["yield"]) == (2, 0, 0.5)
    assert told["broken"] == {"tracking.peak": 1, "u.peak": 1}
    table = pq.read_table(told["figures"])
    assert table.schema.field("tracking.peak").metadata[b"unit"] == b"um"
    assert "tracking.peak" in (Path(told["result"]) / "report.html").read_text()
    listed = CliRunner().invoke(app, ["runs"])
    assert listed.exit_code == 0, listed.output
    assert "2 members, 0 failed, yield 50 %" in listed.stdout
    for wrong in (
        ["--vary", "plant.m_2=1:2"],
        ["--vary", "plnt.m_2=1,2"],
        [],
        ["--sample", "dice"],
    ):
        refused = CliRunner().invoke(app, ["sweep", str(DRIVE), *wrong])
        assert refused.exit_code == 2, refused.output


def test_sensitivity_of_a_mass_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    command = ["sweep", str(DRIVE), "--sensitivity", "16", "--set", "stop=0.05"]
    done = CliRunner().invoke(app, [*command, "--json"])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["members"] == 16 * 5
    assert set(told["sensitivity"]["tracking.peak"]) == {
        "plant.m_2",
        "plant.k",
        "plant.b_1",
    }


CLUSTER = """
import json, os, signal, sys
from distributed import LocalCluster
from orchestrator.analysis import cluster as room
from orchestrator.analysis.sweep import sweep
from orchestrator.analysis.variations import Axis
if __name__ == "__main__":
    axes = [Axis("plant.m_2", (3e-4, 3.5e-4, 4e-4)), Axis("controller.latency", (0, 1))]
    room.BATCH = 1  # so that there is something left to do when one is killed
    with LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None) as c:
        cluster = room.Cluster(c.scheduler_address)
        workers = [w.process.pid for w in c.workers.values()]
        def kill(done):
            if done == 1:
                os.kill(workers[0], signal.SIGKILL)
        far = sweep(
            sys.argv[1], axes, sets=["stop=0.05"], making=cluster, progress=kill
        )
        cluster.close()
    here = sweep(sys.argv[1], axes, sets=["stop=0.05"])
    print(json.dumps([far.rows == here.rows, len(far.rows), far.executors]))
"""


def test_three_workers_of_which_one_is_killed_give_the_same_members(
    tmp_path: Path,
) -> None:
    script = tmp_path / "far.py"
    script.write_text(CLUSTER)
    done = subprocess.run(
        [sys.executable, str(script), str(DRIVE)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout.splitlines()[-1]) == [True, 6, ["cluster"]]


def test_the_width_is_measured_once_and_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measured, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(measured, "WIDTHS", (2, 4))
    measured.width.cache_clear()
    found = measured.width()
    assert found in (2, 4)
    (kept,) = (tmp_path / "fused").iterdir()
    assert kept.read_text() == str(found)
    kept.write_text("8")
    measured.width.cache_clear()
    assert measured.width() == 8
    measured.width.cache_clear()
