"""A run that begins at a kept checkpoint is the rest of the other, or is refused."""

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import tomli_w
from systems import SMALL, mixed, part, system
from typer.testing import CliRunner

from fmus.build import build
from orchestrator.cli import app
from orchestrator.errors import FeedDriveError
from orchestrator.fmu.description import read_fmu
from orchestrator.master.checkpoint import Checkpoints, Keeper
from orchestrator.master.simulate import simulate
from orchestrator.master.warm import Origin, origin
from orchestrator.result import Result, Signal
from orchestrator.system import Component, Fault, Isolation, Mapped, System

MS = Fraction(1, 1000)
KEPT = Checkpoints(MS, kept=True)


def changed(given: System, name: str, **fields: object) -> System:
    parts = {**given.components, name: replace(given.components[name], **fields)}  # type: ignore[arg-type]
    return replace(given, components=parts)


def since(signal: Signal, time: Fraction) -> tuple[np.ndarray, np.ndarray]:
    rest = signal.time >= float(time)
    return signal.time[rest], signal.values[rest]


def assert_rest_of(found: Result, whole: Result, time: Fraction) -> None:
    assert list(found) == list(whole)
    for name, signal in whole.items():
        for one, other in zip(since(found[name], Fraction(0)), since(signal, time)):  # noqa: B905
            np.testing.assert_array_equal(one.view(np.int64), other.view(np.int64))


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    """A run of several rates, a latency, a dead time, an offset, a delay fault."""
    folder = tmp_path_factory.mktemp("kept")
    return folder, simulate(mixed(), folder, checkpoints=KEPT)


@pytest.fixture
def begun(kept: tuple[Path, Result]) -> Callable[[int], Origin]:
    return lambda ms: origin("the run", kept[0], ms * MS)


@pytest.mark.parametrize("at", [4, 12])
@pytest.mark.parametrize(("executor", "isolated"), [("python", True), ("kernel", None)])
def test_without_a_difference_it_has_the_bits_of_the_rest(
    at: int,
    executor: str,
    isolated: bool | None,
    kept: tuple[Path, Result],
    begun: Callable[[int], Origin],
    tmp_path: Path,
) -> None:
    given = changed(mixed(), "pi", isolation=Isolation(process=isolated))
    options = {"executor": executor, "origin": begun(at)}
    found = simulate(given, tmp_path, **options)  # type: ignore[arg-type]
    assert_rest_of(found, kept[1], at * MS)
    assert found.timing is not None
    assert found.timing.simulated_s == pytest.approx(float(given.stop - at * MS))


def test_another_parameter_acts_from_then_on(
    begun: Callable[[int], Origin], tmp_path: Path
) -> None:
    """As in a whole run in which somebody turns it at that instant."""

    def turning(*arguments: object) -> None:
        real(*arguments)  # type: ignore[arg-type]
        keeper, instant = arguments[:2]
        assert isinstance(keeper, Keeper)
        if instant * keeper._schedule.tick == 6 * MS:  # type: ignore[operator]
            pi = keeper._instances["pi"]
            names = [pi.description["K_p"], pi.description["r"]]
            pi.write(names, [0.8, -0.3])

    real = Keeper.write
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Keeper, "write", turning)
        whole = simulate(mixed(), tmp_path / "whole", checkpoints=KEPT)
    given = changed(mixed(), "pi", parameters={"K_p": 0.8}, start={"r": -0.3})
    found = simulate(given, tmp_path / "warm", origin=begun(6))
    assert_rest_of(found, whole, 6 * MS)


def test_a_fault_that_begins_later_another_stop_and_other_rows_are_those_of_a_whole_run(
    begun: Callable[[int], Origin], tmp_path: Path
) -> None:
    first = mixed().faults["late.u"]
    later = [
        Fault("bias", 0.01, 0, 11 * MS, 15 * MS),
        Fault("stuck", 0.0, 0, 16 * MS, 17 * MS),
        Fault("delay", 0.0, 1, 13 * MS, None),
    ]
    given = replace(
        mixed(),
        stop=30 * MS,
        record={"late.y": (MS / 3,), "slow.u": (2 * MS,)},
        faults={
            "late.u": (*first, *later[:2]),
            "slow.y": (later[2],),
        },
    )
    whole = simulate(given, tmp_path / "whole")
    found = simulate(given, tmp_path / "warm", origin=begun(10))
    assert_rest_of(found, whole, 10 * MS)


def test_what_is_not_as_it_was_is_refused_by_name(
    begun: Callable[[int], Origin], tmp_path: Path
) -> None:
    given = mixed()
    first = given.faults["late.u"]
    late = Fault("stuck", 0.0, 0, 10 * MS + MS / 2, None)
    more = {**given.components, "more": part("more", "counter", "1/1000")}
    shorter = build_slower(given.components["pi"])
    wrong = {
        r"is to stop at 0\.01 s; give a later": replace(given, stop=10 * MS),
        r"components pi, late, slow, the run pi, late, slow, more": replace(
            given, components=more
        ),
        r"components\.pi \(\w+\.fmu\): its FMU is another file": replace(
            given, components={**given.components, "pi": shorter}
        ),
        r"latency = 2 there, 1 here": changed(given, "pi", latency=1),
        r"split = True there, False here": changed(given, "late", split=False),
        r"other signals of it are connected or recorded": replace(
            given, record={"late.y": (MS,)}
        ),
        r"components\.late\.state\.x differs, and is a state": changed(
            given, "late", start={"state.x": 0.1}
        ),
        r"slow\.y differs, and is driven": changed(given, "slow", start={"y": 1}),
        r"faults\.late\.u: what begins up to 0\.01 s": replace(
            given, faults={"late.u": (replace(first[0], samples=3),)}
        ),
        r"faults\.late\.u|a fault \(delay\) that had begun": replace(given, faults={}),
        r"new fault \(stuck\) knows .* from 0\.011 s on": replace(
            given, faults={"late.u": (*first, late)}
        ),
    }
    for words, system_ in wrong.items():
        with pytest.raises(FeedDriveError, match=words):
            simulate(system_, tmp_path, origin=begun(10))
    assert not list(tmp_path.iterdir())
    for options, words in (
        ({"executor": "fused"}, "leave --executor out"),
        ({"pace": 1.0}, "either a pace"),
    ):
        with pytest.raises(FeedDriveError, match=words):
            simulate(given, tmp_path, origin=begun(10), **options)  # type: ignore[arg-type]


DELAY = Fault("delay", samples=3)
CHAINS = {  # what is there and what is to go on: with the bits of the rest, or not
    "equal delays": ((DELAY, DELAY), (DELAY, DELAY), True),
    "a bias before what is late": (
        (Fault("bias", 0.3), Fault("delay", samples=2, start=13 * MS)),
        (Fault("delay", samples=2, start=13 * MS), Fault("bias", 0.3)),
        False,
    ),
}


@pytest.mark.parametrize("case", CHAINS)
def test_a_fault_goes_on_with_what_it_remembered_in_its_place_of_the_chain(
    case: str, tmp_path: Path
) -> None:
    before, after, same = CHAINS[case]
    sine = part("sine", "controllers.references.sine", "1/1000", sampled=True)
    y = {"y": Mapped("y", 100.0, unit="m")}
    pi = Component("pi", build(str(SMALL / "pi.py"), period=MS), MS, map=y)
    rows = {"pi.u": "1/1000", "pi.y": "1/1000"}
    given = system("1/20", [sine, pi], {"pi.y": "sine.x_r"}, rows)
    given = replace(given, faults={"pi.y": before})
    whole = simulate(given, tmp_path / "a", checkpoints=KEPT)
    there = origin("the run", tmp_path / "a", 12 * MS)
    given = replace(given, faults={"pi.y": after})
    if same:
        rest = simulate(given, tmp_path / "b", origin=there)
        assert_rest_of(rest, whole, 12 * MS)
    else:
        with pytest.raises(FeedDriveError, match="a new fault"):
            simulate(given, tmp_path / "b", origin=there)


def build_slower(component: Component) -> Component:
    file = build(str(SMALL / "pi.py"), period=Fraction(1, 500))
    return replace(component, fmu=file, period=Fraction(1, 500))


def test_a_fixed_parameter_stays(tmp_path: Path) -> None:
    file = build(str(SMALL / "spring_mass.py"))
    given = system("1/50", [Component("m", file, MS)], {}, {"m.state.x": "1/1000"})
    simulate(given, tmp_path / "kept", checkpoints=KEPT)
    begun = origin("it", tmp_path / "kept", 5 * MS)
    for v in read_fmu(file).variables.values():
        if v.causality == "parameter" and v.variability == "fixed":
            turned = changed(given, "m", parameters={v.name: (1.5,) * v.size})
            with pytest.raises(FeedDriveError, match=f"m.{v.name} differs, and is fix"):
                simulate(turned, tmp_path / "warm", origin=begun)
            return
    pytest.fail("the model has no fixed parameter")


def test_a_time_without_a_checkpoint_is_told_the_nearest(
    kept: tuple[Path, Result], tmp_path: Path
) -> None:
    with pytest.raises(FeedDriveError, match=r"of 19 are at 0\.004 s and 0\.005 s"):
        origin("r", kept[0], MS * 9 / 2)
    with pytest.raises(FeedDriveError, match=r"at 1 s; the nearest of 19 is at 0\.019"):
        origin("r", kept[0], Fraction(1))
    with pytest.raises(FeedDriveError, match="keeps no checkpoints; run it with"):
        origin("r", tmp_path, Fraction(1))


SCENARIO = {
    "stop": "1/20",
    "components": {
        "pi": {"fmu": "pi.py", "start": {"r": 0.1}},
        "late": {
            "fmu": "late.py",
            "step": "1/1000",
            "map": {
                "u": {"name": "u", "gain": 2.0, "unit": "N.m"},
                "y": {"name": "y", "gain": 1.0, "unit": "rad/s"},
            },
        },
    },
    "connections": {"late.u": "pi.u", "pi.y": "late.y"},
    "record": {"late.y": "1/1000"},
    "metrics": {
        "top": {"kind": "max", "of": "late.y"},
        "early": {"kind": "max", "of": "late.y", "window": ["0", "1/50"]},
    },
}


def test_the_verb_begins_where_a_run_was_goes_on_after_a_kill_and_is_not_run_from_0(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for model in ("pi.py", "late.py"):
        shutil.copyfile(SMALL / model, tmp_path / model)
    Path("s.toml").write_text(tomli_w.dumps(SCENARIO))

    def said(code: int, *words: str) -> str:
        done = CliRunner().invoke(app, list(words))
        assert done.exit_code == code, done.output
        return " ".join(done.output.split())

    assert "give --checkpoint S besides" in said(
        2, "run", "s.toml", "--keep-checkpoints"
    )
    said(0, "run", "s.toml", "--checkpoint", "1/100", "--keep-checkpoints")
    assert not Path("runs/s/1/checkpoint").exists()
    assert "write RUN@S" in said(2, "run", "s.toml", "--from", "1")
    assert "there is no run '7'" in said(2, "run", "s.toml", "--from", "7@0.01")
    assert "are at 0.02 s and 0.03 s" in said(2, "run", "s.toml", "--from", "1@0.025")
    begin = ["run", "s.toml", "--from", "1@20 ms", "--set", "pi.K_p=0.7"]
    told = said(0, *begin, "-o", "warm")
    assert (
        "begins with the state of runs/s/1 at 0.02 s; from then on pi.K_p = 0.7" in told
    )
    assert "its window begins at 0 s, the run at 0.02 s" in told
    whole = Result(Path("warm"))["late.y"]
    assert whole.time[0] == 0.02
    real = Keeper.write

    def cut(*arguments: object) -> None:
        real(*arguments)  # type: ignore[arg-type]
        if len(list(Path("cut/checkpoints").glob("*"))) == 2:
            raise KeyboardInterrupt

    again = ["--checkpoint", "1/200", "--keep-checkpoints", "-o", "cut"]
    with monkeypatch.context() as patch:
        patch.setattr(Keeper, "write", cut)
        CliRunner().invoke(app, [*begin, *again])
    assert Path("cut/checkpoint").is_file()
    assert "from then on" in said(0, "resume", "cut")
    np.testing.assert_array_equal(Result(Path("cut"))["late.y"].values, whole.values)
    said(0, *begin[:-1], "pi.K_p=0.7", "--from", "cut@0.03", "-o", "further")
    further = Result(Path("further"))["late.y"]
    np.testing.assert_array_equal(further.values, whole.values[whole.time >= 0.03])
    Path("cut2").mkdir()
    lock = "warm/scenario.lock.toml"
    refused = said(2, "run", lock)
    assert re.search(
        r"began with the state of runs/s/1 at 0\.02 s; give --from", refused
    )
    said(0, "run", lock, "--from", "1@0.02", "-o", "anew")
    np.testing.assert_array_equal(Result(Path("anew"))["late.y"].values, whole.values)
    for name, words in {"schedule": (), "response": ()}.items():
        assert "give --from" in said(2, name, lock, *words)
