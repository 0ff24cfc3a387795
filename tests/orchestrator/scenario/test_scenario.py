"""What a scenario file says, how it inherits, and what ``--set`` changes."""

from fractions import Fraction
from pathlib import Path

import pytest

from orchestrator.errors import ScenarioError
from orchestrator.scenario.reading import (
    STUDIES,
    find_scenario,
    load_scenario,
    scenario_name,
    scenarios,
)

DRIVE = """
stop = "1/2"
[rates]
control = "20 kHz"
[components.plant]
fmu = "plants.ball_screw.two_mass"
step = "control"
parameters = { m_2 = 0.379e-3 }
[components.controller]
fmu = "controllers.ball_screw.mc_ppc"
step = "control"
latency = 1
[connections]
"plant.u" = "controller.u"
"controller.y_*" = "plant.x_*"
[design.gains]
call = "controllers.synthesis.ball_screw.pole_placement:design"
arguments = { m_2 = "plant.m_2", beta = 4 }
sets = "controller"
[record]
"plant.x_2" = "control"
"controller.u" = true
[metrics]
lag = { kind = "error", of = "plant.x_2", against = "plant.x_1", window = [0, 0.1] }
[expect]
"lag.peak" = { below = 4, unit = "um" }
"""


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    file = tmp_path / "drive.toml"
    file.write_text(DRIVE)
    return file


def test_times_rates_and_rows_are_exact(drive):
    spec = load_scenario(drive).spec
    assert spec.stop == Fraction(1, 2)
    assert spec.components["plant"].step == Fraction(1, 20_000)
    assert spec.record == {
        "plant.x_2": (Fraction(1, 20_000),),
        "controller.u": (None,),
    }
    assert spec.metrics["lag"].window == (0, Fraction(1, 10))


@pytest.mark.parametrize(
    ("old", "new", "place", "remedy"),
    [
        ("latency = 1", "latncy = 1", "components.controller", "'latency'"),
        ("latency = 1", "latency = -1", "components.controller.latency", "at least 0"),
        ("latency = 1", "latency = 1.5", "components.controller.latency", "whole"),
        ("latency = 1", "kind = 'smpled'", "components.controller.kind", "'sampled'"),
        ("latency = 1", "map = 3", "components.controller.map", "table"),
        ("stop =", "stpo =", "'stpo'", "'stop'"),
        ('stop = "1/2"', "", "stop", "missing"),
        ('stop = "1/2"', "stop = -1", "stop", "greater than zero"),
        ('step = "control"', 'step = "contrl"', "components.plant.step", "'control'"),
        ('"20 kHz"', '"20 kXz"', "rates.control", "kHz"),
        ("0.379e-3", "nan", "components.plant.parameters.m_2", "finite"),
        ("0.379e-3", "[1.0, inf]", "components.plant.parameters.m_2", "finite"),
        ('"plant.u"', '"plnt.u"', 'connections."plnt.u"', "'plant'"),
        ('"plant.u"', '"plant"', 'connections."plant"', "plant.<variable>"),
        ('"controller.u"', '"1 mm"', 'connections."plant.u"', "without quotes"),
        ('"plant.x_*"', '"plant.*_*"', "plant.*_*", "several"),
        ('"error"', '"eror"', "metrics.lag", "no kind 'eror'; did you mean 'error'"),
        ('"error"', '"error", scale = []', "metrics.lag.scale", "number or a text"),
        ("window = [0, 0.1]", "window = [1, 0]", "metrics.lag.window", "before"),
        ('"plant.x_1"', '"plan.x_1"', "metrics.lag.against", "'plant'"),
        ('"lag.peak"', '"leg.peak"', 'expect."leg.peak"', "'lag'"),
        ("below = 4,", "", 'expect."lag.peak"', "below, above"),
        ('"controller"', '"controler"', "design.gains.sets", "'controller'"),
        ("mc_ppc", 'mc_ppc"\nfmu = "', "drive.toml", "TOML"),
        ('sets = "controller"', "sets = 3", "design.gains.sets", "list"),
        ("call =", 'from_run = "x"\ncall =', "design.gains", "signals"),
    ],
)
def test_a_wrong_entry_is_named_with_file_key_and_remedy(
    drive, old, new, place, remedy
):
    assert old in DRIVE
    drive.write_text(DRIVE.replace(old, new, 1))
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(drive)
    for part in (str(drive), place, remedy):
        assert part in str(refusal.value)


@pytest.mark.parametrize("rate", ["0", "-10 kHz", "10 MHzz", "[]"])
def test_a_wrong_rate_is_the_only_complaint(drive, rate):
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(drive, [f"rates.control={rate}"])
    assert "rates.control: " in str(refusal.value)
    assert "there is no rate" not in str(refusal.value)


def test_overrides_reach_parameters_times_rates_and_designs(drive):
    changed = load_scenario(
        drive,
        [
            "plant.m_2=0.5e-3",
            "plant.state.x_1=1e-3",
            "controller.inversion.on=false",
            "controller.latency=2",
            "plant.step=1/40000",
            "rates.control=10 kHz",
            "stop=50 ms",
            "design.gains.beta=5",
            "fmi=3",
        ],
    )
    plant, controller = (changed.spec.components[n] for n in ("plant", "controller"))
    assert plant.parameters["m_2"] == 0.5e-3
    assert plant.start["state.x_1"] == 1e-3
    assert plant.step == Fraction(1, 40_000)
    assert controller.parameters["inversion.on"] is False
    assert controller.latency == 2
    assert controller.step == Fraction(1, 10_000)
    assert changed.spec.stop == Fraction(1, 20)
    assert changed.spec.design["gains"].arguments["beta"] == 5
    assert changed.spec.fmi == 3


def test_overrides_reach_metrics_records_and_connections(drive):
    spec = load_scenario(
        drive,
        [
            "record.plant.x_1=2 kHz",
            'record.plant.x_2=["20 kHz", "1 kHz"]',
            "record.controller.u=false",
            "connections.plant.u=0.5",
            'metrics.x_1={kind = "peak", of = "plant.x_1"}',
            "metrics.x_1.unit=deg",
        ],
    ).spec
    assert spec.record == {
        "plant.x_2": (Fraction(1, 20_000), Fraction(1, 1000)),
        "plant.x_1": (Fraction(1, 2000),),
    }
    assert spec.connections["plant.u"] == 0.5
    assert spec.metrics["x_1"].unit == "deg"
    left = load_scenario(drive, ["connections.plant.u=false"]).spec
    assert "plant.u" not in left.connections
    name = next(iter(left.metrics))
    less = load_scenario(drive, [f"metrics.{name}=false"]).spec
    assert name not in less.metrics
    assert not [figure for figure in less.expect if figure.startswith(f"{name}.")]


def test_design_steps_are_told_the_file_and_not_what_set_changed(drive):
    changed = load_scenario(drive, ["plant.m_2=0.5e-3", "rates.control=10 kHz"])
    assert changed.nominal.components["plant"].parameters["m_2"] == 0.379e-3
    assert changed.nominal.components["plant"].step == Fraction(1, 10_000)


def test_a_design_step_can_be_left_out(drive):
    assert load_scenario(drive, ["design.gains=false"]).spec.design == {}


@pytest.mark.parametrize(
    ("override", "remedy"),
    [
        ("plant.m_2", "component.parameter=value"),
        ("plnt.m_2=1", "'plant'"),
        ("stp=1", "'stop'"),
        ("plant.m_2=nan", "finite"),
        ("rates.contrl=1 kHz", "'control'"),
        ("design.gans.beta=1", "'gains'"),
        ("design.gains=3", "false"),
        ("stop=soon", "not a time"),
    ],
)
def test_a_wrong_override_is_refused_with_a_remedy(drive, override, remedy):
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(drive, [override])
    assert remedy in str(refusal.value)


def test_a_scenario_inherits_and_can_remove(drive, tmp_path):
    child = tmp_path / "child.toml"
    child.write_text(
        'base = "drive.toml"\nstop = 1\n'
        "components.plant.parameters.m_1 = 2e-3\n"
        "components.controller = false\n"
        "design.gains = false\n"
        '[connections]\n"plant.u" = 0.5\n'
    )
    spec = load_scenario(child).spec
    assert spec.stop == 1
    assert set(spec.components) == {"plant"}
    assert spec.components["plant"].parameters == {"m_1": 2e-3, "m_2": 0.379e-3}
    assert spec.connections == {"plant.u": 0.5}
    assert set(spec.record) == {"plant.x_2"}
    assert set(spec.metrics) == {"lag"}


def test_of_several_bases_the_later_wins_and_a_common_one_counts_once(drive, tmp_path):
    texts = {
        "one": 'base = "drive.toml"\nstop = 1\ntitle = "one"\n',
        "two": 'base = "drive.toml"\ntitle = "two"\ndesign.gains = false\n',
        "both": 'base = ["one.toml", "two.toml"]\n',
    }
    for name, text in texts.items():
        (tmp_path / f"{name}.toml").write_text(text)
    spec = load_scenario(tmp_path / "both.toml").spec
    assert (spec.stop, spec.title, spec.design) == (1, "two", {})


def test_an_heir_in_another_folder_finds_the_files_of_its_base(tmp_path):
    home, away = tmp_path / "home", tmp_path / "away"
    home.mkdir()
    away.mkdir()
    (home / "drive.toml").write_text(
        'stop = 1\nexpect_like = "kept"\n'
        'components.plant = { fmu = "plant.py", step = "1 ms" }\n'
        'components.load = { fmu = "sub/load.fmu", step = "1 ms" }\n'
        'components.force = { data = "force.csv", step = "1 ms" }\n'
        'components.path = { fmu = "controllers.references.stair", step = "1 ms" }\n'
        'design.gains = { call = "m:f", from_run = "open", signals = { u = "a.b" } }\n'
        'design.more = { call = "m:f", from_run = "a/b", signals = { u = "a.b" } }\n'
    )
    (away / "heir.toml").write_text(
        'base = "../home/drive.toml"\ncomponents.load.fmu = "mine.fmu"\n'
    )
    spec = load_scenario(away / "heir.toml").spec
    parts, steps = spec.components, spec.design
    assert parts["plant"].fmu == str(home / "plant.py")
    assert parts["load"].fmu == "mine.fmu"
    assert parts["force"].data == str(home / "force.csv")
    assert parts["path"].fmu == "controllers.references.stair"
    assert steps["gains"].from_run == str(home / "open.toml")
    assert steps["more"].from_run == "a/b"
    assert spec.expect_like is not None
    assert spec.expect_like.folder == str(home / "kept")


def test_an_heir_of_a_published_scenario_finds_the_run_its_design_takes(tmp_path):
    heir = tmp_path / "heir.toml"
    heir.write_text('base = "leadscrew_nctf/step"\n')
    spec = load_scenario(heir).spec
    runs = {step.from_run for step in spec.design.values()} - {None}
    assert runs
    assert all(Path(run).is_file() for run in runs)


def test_inheriting_from_itself_or_from_nothing_is_refused(drive, tmp_path):
    child = tmp_path / "child.toml"
    child.write_text('base = "child.toml"')
    with pytest.raises(ScenarioError, match="inherits from itself"):
        load_scenario(child)
    child.write_text('base = "drve.toml"')
    with pytest.raises(ScenarioError, match=r"drive\.toml"):
        load_scenario(child)


def test_unknown_scenarios_and_studies_name_the_nearest():
    with pytest.raises(ScenarioError, match="ball_screw_pole_placement"):
        find_scenario("ball_screw_pole_placment/mc_ppc_track_500")
    with pytest.raises(ScenarioError, match="mc_ppc_track_500"):
        find_scenario("ball_screw_pole_placement/mc_ppc_trak_500")
    with pytest.raises(ScenarioError, match="no such scenario file"):
        find_scenario("nowhere.toml")


@pytest.mark.parametrize(
    "study", sorted(f.name for f in STUDIES.iterdir() if f.is_dir())
)
def test_every_scenario_of_a_study_is_valid(study):
    for name, file in scenarios(STUDIES / study).items():
        assert load_scenario(f"{study}/{name}").file == file
        assert scenario_name(file) == f"{study}/{name}"


def test_a_swap_takes_times_and_values_and_a_map_may_set_some(drive):
    mass = {"name": "mass", "value": 3.0}
    swapped = load_scenario(
        drive,
        ["plant.theta=1"],
        {"plant": {"fmu": "/their.fmu", "map": {"u": "voltage", "m_1": mass}}},
    )
    plant = swapped.spec.components["plant"]
    assert plant.fmu == "/their.fmu"
    assert plant.step == Fraction(1, 20_000)
    assert plant.parameters == {"theta": 1, "m_1": 3.0, "m_2": 0.379e-3}
    assert swapped.carried == {"plant": {"parameters": ("m_2",), "start": ()}}
    assert plant.map["u"].name == "voltage"
    assert swapped.nominal.components["plant"].fmu == "plants.ball_screw.two_mass"
