"""FMUs of others inside a composition that is one FMU, carried along and called."""

import zipfile
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from coupled import coupled
from foreign import foreign
from rewritten import rewritten
from third_party import fmus_in
from walking import RUNNERS, Walk, place_of, walks
from wholes import SMALL, THREE_RATES, Slave, composed, exported

from fmus.build import build
from fmus.compile import PLATFORMS, host_platform
from fmus.subject import Fmi
from orchestrator.errors import ScenarioError
from orchestrator.exchange.whole.export import export_whole
from orchestrator.fmu.archive import unpacked
from orchestrator.fmu.description import read_fmu
from orchestrator.pytest_plugin import assert_fmu_conforms
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

STEP = Fraction(1, 12000)
LATE = f'fmu = "{SMALL / "late.py"}"'


def theirs(
    folder: Path, name: str, fmi: Fmi = 2, platforms: tuple[str, ...] | None = None
) -> Path:
    """Return an FMU nobody here vouches for: one of ours with a file added."""
    ours = build(str(SMALL / f"{name}.py"), fmi=fmi, platforms=platforms)
    made = folder / f"{name}{fmi}.fmu"
    made.write_bytes(ours.read_bytes())
    with zipfile.ZipFile(made, "a") as archive:
        archive.writestr("documentation/notes.txt", "not ours")
    return made


@pytest.mark.parametrize("fmi", [2, 3])
def test_rows_are_those_of_the_run(fmi: Fmi, tmp_path: Path) -> None:
    text = THREE_RATES.replace(LATE, f'fmu = "{theirs(tmp_path, "late", fmi)}"')
    whole = exported(text, tmp_path)
    whole.begin(**{"late.T": 0.004})
    found = np.array(whole.rows(STEP, 1200)).T
    scenario = load_scenario(tmp_path / "scenario.toml", ["late.T=0.004"])
    done = run(scenario, tmp_path / "run", report=False)
    for name, values in zip(whole.outputs, found, strict=True):
        np.testing.assert_array_equal(values, done[name].values)
    whole.fmu.reset()
    whole.begin(**{"late.T": 0.004})
    np.testing.assert_array_equal(np.array(whole.rows(STEP, 100)).T, found[:, :101])


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_state_with_theirs_inside_is_taken_back_and_goes_on_elsewhere(
    fmi: Fmi, tmp_path: Path
) -> None:
    """In this instance, and as bytes in one that was never initialised."""
    text = THREE_RATES.replace(LATE, f'fmu = "{theirs(tmp_path, "late", fmi)}"')
    whole = exported(text, tmp_path, fmi=fmi)
    assert whole.description.coSimulation.canSerializeFMUstate
    whole.begin(**{"late.T": 0.004})
    whole.rows(STEP, 500)
    word = "state" if fmi == 2 else "State"
    names = [f"{verb}FMU{word}" for verb in ("get", "set", "free", "serialize")]
    take, put, drop, write = (getattr(whole.fmu, name) for name in names)
    of_bytes = "deSerializeFMUstate" if fmi == 2 else "deserializeFMUState"
    read = getattr(whole.fmu, of_bytes)
    state = take()
    bytes_ = write(state)
    first = whole.rows(STEP, 900, 500)
    put(state)
    assert whole.rows(STEP, 900, 500) == first
    drop(state)
    put(read(bytes_))
    assert whole.rows(STEP, 900, 500) == first
    other = Slave(tmp_path / "whole.fmu", tmp_path / "other")
    back = getattr(other.fmu, of_bytes)(bytes_)
    getattr(other.fmu, names[1])(back)
    assert other.rows(STEP, 900, 500) == first
    damaged = bytearray(bytes_)
    damaged[-9] ^= 1
    with pytest.raises(Exception, match=r"(?i)deserialize"):
        getattr(other.fmu, of_bytes)(bytes(damaged))


def test_where_one_inside_has_no_states_none_are_offered(tmp_path: Path) -> None:
    text = f"""
stop = "1/10"
[components.one]
fmu = "{coupled(2, tmp_path)}"
step = "1/1000"
[record]
"one.y" = true
"""
    whole = exported(text, tmp_path)
    assert not whole.description.coSimulation.canGetAndSetFMUstate
    whole.begin()
    with pytest.raises(Exception, match="fmi2GetFMUstate"):
        whole.fmu.getFMUstate()


def test_compositions_nest(tmp_path: Path) -> None:
    """One in one in one, the innermost with an FMU of others inside."""
    text = THREE_RATES.replace(LATE, f'fmu = "{theirs(tmp_path, "late")}"')
    rows, name = [], "late.y"
    for depth in range(3):
        folder = tmp_path / str(depth)
        folder.mkdir()
        whole = exported(text, folder, outputs=[name])
        whole.begin()
        rows.append(whole.rows(STEP, 300))
        text = (
            f'stop = "1/10"\n[components.inner]\nfmu = "{folder / "whole.fmu"}"\n'
            f'step = "{STEP}"\n[record]\n"inner.{name}" = true\n'
        )
        name = f"inner.{name}"
    assert rows[0] == rows[1] == rows[2]


def test_an_outside_input_reaches_one_of_them(tmp_path: Path) -> None:
    """As it does where the same model is compiled in."""
    text = THREE_RATES.replace('step = "1/4000"', 'step = "1 kHz"')
    ends = {"inputs": ["late.u"], "outputs": ["late.y"]}
    rows = []
    for fmu in (LATE, f'fmu = "{theirs(tmp_path, "late")}"'):
        without = text.replace(LATE, fmu).replace('"late.u" = "tone.x_r"\n', "")
        folder = tmp_path / str(len(rows))
        folder.mkdir()
        whole = exported(without, folder, **ends)
        whole.begin(**{"late.u": 3.0})
        found = [whole.row()]
        for k in range(50):
            whole.set("late.u", k % 7)
            whole.step(k, Fraction(1, 1000))
            found.append(whole.row())
        rows.append(found)
    assert rows[0] == rows[1]


def test_an_outside_input_begins_with_what_the_scenario_says(tmp_path: Path) -> None:
    text = THREE_RATES.replace('"late.u" = "tone.x_r"\n', "")
    rows = []
    for fmu in (LATE, f'fmu = "{theirs(tmp_path, "late")}"'):
        with_start = text.replace(LATE, f"{fmu}\nstart = {{ u = 3.0 }}")
        folder = tmp_path / str(len(rows))
        folder.mkdir()
        whole = exported(with_start, folder, inputs=["late.u"])
        variables = whole.description.modelVariables
        assert [v.start for v in variables if v.causality == "input"] == ["3.0"]
        whole.begin()
        rows.append(whole.rows(STEP, 100))
    assert rows[0] == rows[1]
    done = run(tmp_path / "1" / "scenario.toml", tmp_path / "run", report=False)
    k = whole.outputs.index("late.y")
    assert [row[k] for row in rows[1]] == list(done["late.y"].values[:101])


def test_every_type_of_theirs_is_read_whatever_is_recorded_beside(
    tmp_path: Path,
) -> None:
    """A local of the type of the outputs comes behind outputs of other types."""

    def edit(root: Any) -> None:
        steps = root.find("ModelVariables/*[@name='steps']")
        steps.set("causality", "local")
        last = str(list(root.find("ModelVariables")).index(steps) + 1)
        for unknown in root.findall(f"ModelStructure/*/Unknown[@index='{last}']"):
            unknown.getparent().remove(unknown)

    fmu = rewritten(foreign(2, tmp_path), tmp_path, edit)
    names = ("out_Real", "out_Integer", "steps")
    rows = "\n".join(f'"one.{name}" = true' for name in names)
    text = (
        f'stop = "0.01"\n[components.one]\nfmu = "{fmu}"\nstep = "1 kHz"\n'
        f"start = {{ in_Real = 5.0, in_Integer = 3 }}\n[record]\n{rows}\n"
    )
    whole = exported(text, tmp_path)
    whole.begin()
    found = np.array(whole.rows(Fraction(1, 1000), 5)).T
    done = run(tmp_path / "scenario.toml", tmp_path / "run", report=False)
    for name, values in zip(whole.outputs, found, strict=True):
        np.testing.assert_array_equal(values, done[name].values[:6])
    assert list(done["one.steps"].values[:3]) == [0, 1, 2]


def test_what_cannot_go_along_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "scenario.toml"
    late, pi = theirs(tmp_path, "late"), theirs(tmp_path, "pi")
    foreign = THREE_RATES.replace(LATE, f'fmu = "{late}"')
    end = "[components.pi]"
    apart = foreign.replace(end, f'isolation = "process"\n{end}')
    told = foreign.replace(end, f"experiment = {{ stop = true }}\n{end}")
    sampled = THREE_RATES.replace(f"{SMALL / 'pi.py'}", str(pi))
    sampled = sampled.replace("1/1500", "1/2000")
    for text, why in (
        (sampled, "pi is sampled and not ours"),
        (apart, "late is to run in a process of its own"),
        (told, "late is to be told a stop time"),
    ):
        file.write_text(text)
        with pytest.raises(ScenarioError, match=why):
            export_whole(composed(file), tmp_path / "x.fmu")
    file.write_text(foreign)
    with pytest.raises(ScenarioError, match=r"late .* has no binary for it; it has"):
        export_whole(composed(file), tmp_path / "x.fmu", platforms=["macos-arm64"])


@pytest.mark.skipif(host_platform() != "linux-x86_64", reason="linux64 binaries")
def test_a_pair_by_openmodelica_runs_inside(tmp_path: Path) -> None:
    pair = fmus_in("gemseo-fmu==3.1.1", "linux", tmp_path)
    text = f"""
stop = "1/2"
[components.one]
fmu = "{pair["MassSpringSubSystem1"]}"
step = "1/1000"
[components.two]
fmu = "{pair["MassSpringSubSystem2"]}"
step = "1/1000"
[connections]
"one.x2" = "two.x2"
"two.x1" = "one.x1"
[record]
"one.x1" = true
"two.x2" = true
"""
    wholes = exported(text, tmp_path), exported(text, tmp_path, fmi=3)
    done = run(tmp_path / "scenario.toml", tmp_path / "run", report=False)
    for whole in wholes:
        whole.begin()
        found = np.array(whole.rows(Fraction(1, 1000), 500)).T
        for name, values in zip(whole.outputs, found, strict=True):
            np.testing.assert_array_equal(values, done[name].values)


@pytest.mark.skipif(host_platform() != "linux-x86_64", reason="emulates from there")
def test_other_processors_and_systems_give_the_same_bits(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    if not request.config.getoption("--every-form"):
        pytest.skip("compiles for three platforms: --every-form")
    platforms = tuple(RUNNERS)
    text = THREE_RATES.replace(
        LATE, f'fmu = "{theirs(tmp_path, "late", 2, platforms)}"'
    )
    file = tmp_path / "scenario.toml"
    file.write_text(text)
    whole = tmp_path / "whole.fmu"
    ends = {"inputs": ["pi.r"], "outputs": ["pi.u", "late.y"]}
    export_whole(composed(file), whole, **ends, platforms=platforms)
    assert_fmu_conforms(whole)
    described = read_fmu(whole)
    refs = [described[n].reference for n in ("pi.r", "pi.u", "late.y")]
    groups = f"1 {refs[0]} 1 2 {refs[1]} 1 {refs[2]} 1"
    found: list[list[Walk]] = []
    with unpacked(whole) as place:
        for platform in platforms:
            kind = PLATFORMS[platform]
            name = f"{described.model_identifier}{kind.suffix}"
            library = place_of(place / "binaries" / kind.fmi2_folder / name, platform)
            head = f"{library} {described.token}"
            lines = [f"{head} {v}cs {float(STEP)!r} 1 0 {groups} 0.0" for v in "23"]
            found += walks(platform, {"whole": lines}, tmp_path).values()
    assert found == [found[0]] * 3
