"""[responses], [expect] on them, the verb and its JSON, pytest."""

import csv
import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from lag_loop import lag_loop
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import ResponseError, ScenarioError
from orchestrator.report.responded import Curve, write_responded
from orchestrator.response.bench import bench
from orchestrator.response.margins import margins
from orchestrator.response.measure import measure
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.scenario.responses import response_of
from orchestrator.session import run, run_earlier

pytest_plugins = ["pytester"]

TABLE = "cascade_nppi/p_pi_0_4hz"
SCENARIO = f"""
base = "{TABLE}"
stop = "1/10"
metrics = {{ tracking = false, e = false }}

[responses]
loop = {{ break = "controller.u", from = "8 Hz" }}

[expect]
"loop.s_max" = {{ below = LIMIT }}
"u.peak" = {{ below = 10 }}
"""


def written(folder: Path, limit: float) -> Path:
    file = folder / "loop.toml"
    file.write_text(SCENARIO.replace("LIMIT", str(limit)))
    return file


def test_margins_of_a_loop_known_in_closed_form() -> None:
    """L = 2 e^(-jωτ)/(jω): crossover at 2 rad/s, 90° - 2τ left, gain margin π/(4τ)."""
    tau = 0.1
    hz = np.geomspace(0.01, 20, 20_000)
    w = 2 * np.pi * hz
    found = margins(hz, 2 * np.exp(-1j * w * tau) / (1j * w))
    assert found.crossover_hz == pytest.approx(2 / (2 * np.pi), rel=1e-6)
    assert found.phase_margin_deg == pytest.approx(90 - np.degrees(2 * tau), rel=1e-6)
    assert found.gain_margin_db == pytest.approx(
        20 * np.log10(np.pi / (4 * tau)), rel=1e-6
    )
    assert found.delay_margin_s == pytest.approx(np.pi / 4 - tau, rel=1e-6)
    fine = np.max(np.abs(1 / (1 + 2 * np.exp(-1j * w * tau) / (1j * w))))
    assert found.s_max == pytest.approx(fine, rel=1e-6)
    assert found.modulus_margin == pytest.approx(1 / fine, rel=1e-6)


@pytest.mark.parametrize(("limit", "code"), [(3.5, 0), (2.0, 1)])
def test_a_response_is_told_as_json_with_its_table(
    limit: float, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(
        app, ["response", str(written(tmp_path, limit)), "--json"]
    )
    assert done.exit_code == code
    assert ("loop.s_max = 3.0" in done.stderr) == bool(code)
    told = json.loads(done.stdout)
    loop = told["responses"]["loop"]
    assert loop["break"] == "controller.u"
    assert loop["s_max"] == pytest.approx(3.09, rel=0.01)
    assert loop["modulus_margin"] == pytest.approx(1 / loop["s_max"])
    assert loop["crossovers"][0].keys() == {"hz", "phase_margin_deg"}
    assert loop["gain_margins"][0].keys() == {"hz", "db"}
    assert told["figures"]["loop.s_max"]["value"] == loop["s_max"]
    with Path(loop["table"]).open() as file:
        rows = list(csv.DictReader(file))
    L = np.array([complex(float(r["L_re"]), float(r["L_im"])) for r in rows])
    S = np.array([complex(float(r["S_re"]), float(r["S_im"])) for r in rows])
    T = np.array([complex(float(r["T_re"]), float(r["T_im"])) for r in rows])
    assert np.allclose(S, 1 / (1 + L))
    assert np.allclose(S + T, 1)
    assert all(float(r["coherence"]) > 0.999999 for r in rows)


def test_one_break_is_asked_for_on_the_command_line_and_its_page_has_three_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    asked = [TABLE, "--break", "controller.u", "--from", "8 Hz"]
    asked += ["--table", "lines.parquet", "-o", "out", "--json"]
    done = CliRunner().invoke(app, ["response", *asked])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["break"] == "controller.u"
    assert told["s_max_hz"] == pytest.approx(110, abs=20)
    names = pq.read_table("lines.parquet").column_names
    parts = [
        f"{of}_{part}" for of in ("L", "S", "T", "L_traced") for part in ("re", "im")
    ]
    assert names == ["hz", *parts, "coherence"]
    page = Path("out/response.html").read_text()
    assert page.count('class="plotly-graph-div"') == 3
    assert "equations, controller.u" in page
    table = pq.read_table("lines.parquet").to_pydict()
    for part in ("re", "im"):  # L of the equations is the measured one
        measured, exact = (np.array(table[f"{of}_{part}"]) for of in ("L", "L_traced"))
        assert np.allclose(measured, exact, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("lowest", ["1/4", "0.25", "0.25 Hz", "4 s", "250 mHz"])
def test_a_lowest_line_without_unit_is_in_hertz_as_the_option_says(lowest: str) -> None:
    if lowest == "250 mHz":
        with pytest.raises(ScenarioError, match=r"--from: .*'mHz' is no unit of time"):
            response_of(["c.u"], [], [], "auto", lowest, "multisine")
    else:
        asked = response_of(["c.u"], [], [], "auto", lowest, "multisine")
        assert asked.lowest == 4


def test_a_number_without_unit_is_no_lowest_line_of_a_file(tmp_path: Path) -> None:
    file = written(tmp_path, 2.0)
    file.write_text(file.read_text().replace('"8 Hz"', "0.125"))
    with pytest.raises(ScenarioError, match=r'write "0\.125 Hz" .* or "0\.125 s"'):
        load_scenario(file)


def test_several_responses_have_a_table_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    lag_loop(tmp_path)
    with Path("loop.toml").open("a") as file:
        file.write(
            '[responses]\nloop = { break = "controller.u", from = "16 Hz" }\n'
            'way = { excite = "plant.u", observe = "plant.y", from = "16 Hz" }\n'
        )
    asked = ["response", "loop.toml", "--table", "lines.csv", "-o", "out", "--json"]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)["responses"]
    for name, of in (("loop", "L_re"), ("way", "G_re")):
        assert told[name]["table"] == f"lines_{name}.csv"
        assert of in Path(f"lines_{name}.csv").read_text().splitlines()[0].split(",")


def test_a_run_says_that_it_does_not_measure_responses(tmp_path: Path) -> None:
    done = run(written(tmp_path, 2.0), tmp_path / "run")
    assert any("feeddrive response" in text for text in done.warnings)
    assert [c.figure for c in done.checks] == ["u.peak"]


@pytest.mark.parametrize(("limit", "failed"), [(3.5, 0), (2.0, 1)])
def test_pytest_holds_a_scenario_to_what_its_responses_are_expected_to_be(
    limit: float, failed: int, pytester: pytest.Pytester
) -> None:
    written(pytester.path, limit)
    done = pytester.runpytest_inprocess("loop.toml")
    done.assert_outcomes(passed=1 - failed, failed=failed)
    if failed:
        done.stdout.fnmatch_lines(["*loop.s_max = 3.0*expected below 2*"])


@pytest.mark.parametrize(
    ("broken", "complaint"),
    [
        ("controller.no", "no"),
        ("nobody.u", "no such output"),
        ("reference.x_r", "no connection leads back"),
        ("controller.e", "drives nothing"),
    ],
)
def test_what_is_no_output_of_a_loop_is_refused(broken: str, complaint: str) -> None:
    composition = compose(load_scenario(TABLE), run_earlier)
    with pytest.raises(Exception, match=complaint), bench(composition, [broken]):
        pass


def test_expectations_name_figures_that_responses_have(tmp_path: Path) -> None:
    file = written(tmp_path, 2.0)
    file.write_text(file.read_text().replace('"loop.s_max"', '"loop.s_mx"'))
    with pytest.raises(ScenarioError, match="did you mean 's_max'"):
        load_scenario(file)


def test_an_unstable_loop_is_refused() -> None:
    sets = ["controller.k_v=2000", "controller.k_p=0.05"]
    composition = compose(load_scenario(TABLE, sets), run_earlier)
    with pytest.raises(ResponseError, match="unstable"):
        measure(composition, ["controller.u"], lowest=Fraction(16))


def test_several_loops_share_a_page(tmp_path: Path) -> None:
    hz = np.array([1.0, 10.0, 100.0])
    L = 10 / (1j * hz)
    curves = [
        Curve(name, hz, L, 1 / (1 + L), L / (1 + L), other)
        for name, other in (("after", False), ("before", True))
    ]
    page = write_responded("two", [], [], curves, {"s_max 2": 2.0}, tmp_path / "p.html")
    assert page.read_text().count("before") >= 3
