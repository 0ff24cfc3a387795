"""What can be saved is; what cannot is refused in words before the run."""

import shutil
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from broken import ball, pack
from foreign import foreign
from systems import part, system
from typer.testing import CliRunner

from orchestrator.cli import app
from orchestrator.errors import FeedDriveError
from orchestrator.master.checkpoint import NAME, Checkpoints, Keeper
from orchestrator.master.simulate import simulate
from orchestrator.system import Component, Fault, Isolation, System

MS = Fraction(1, 1000)
EVERY = Checkpoints(2 * MS)
PI = Path(__file__).parents[2] / "fmus" / "small_models" / "pi.py"
SHORT = 'stop = "1/100"\ncomponents.pi.fmu = "pi.py"\nrecord = { "pi.u" = true }\n'


def pair(**options: object) -> System:
    parts = [
        part("a", "counter", "1/1000"),
        replace(part("b", "counter", "1/1000"), latency=2, **options),
    ]
    late = Fault("delay", 0.0, 3, Fraction(0), None)
    made = system("1/50", parts, {"b.u": "a.k"}, {"b.seen": "1/1000"})
    return replace(made, faults={"b.u": (late,)})


def cut_off(given: System, folder: Path, executor: str = "kernel") -> None:
    """Run until the fifth checkpoint is there."""
    written = []

    def write(*arguments: object) -> None:
        real(*arguments)  # type: ignore[arg-type]
        written.append(arguments)
        if len(written) == 5:
            raise KeyboardInterrupt

    real = Keeper.write
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Keeper, "write", write)
        with pytest.raises(KeyboardInterrupt):
            simulate(given, folder, executor=executor, checkpoints=EVERY)  # type: ignore[arg-type]


@pytest.mark.parametrize("isolated", [None, True])
@pytest.mark.parametrize(
    ("first", "second"), [("python", "kernel"), ("kernel", "python")]
)
def test_another_executor_goes_on_with_the_same_bits(
    first: str, second: str, isolated: bool | None, tmp_path: Path
) -> None:
    given = pair(isolation=Isolation(process=isolated))
    whole = simulate(given, tmp_path / "whole")["b.seen"]
    cut_off(given, tmp_path / "run", first)
    resumed = replace(EVERY, resumed=True)
    kind = {"executor": second, "checkpoints": resumed}
    found = simulate(given, tmp_path / "run", **kind)["b.seen"]  # type: ignore[arg-type]
    np.testing.assert_array_equal(found.values, whole.values)
    np.testing.assert_array_equal(found.time, whole.time)
    assert not (tmp_path / "run" / NAME).exists()


def test_a_damaged_checkpoint_and_one_of_another_system_are_refused(
    tmp_path: Path,
) -> None:
    cut_off(pair(), tmp_path)
    resumed, file = replace(EVERY, resumed=True), tmp_path / NAME
    with pytest.raises(FeedDriveError, match="is of another system"):
        simulate(pair(offset=MS / 2), tmp_path, checkpoints=resumed)
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)
    with pytest.raises(FeedDriveError, match="is damaged; delete it"):
        simulate(pair(), tmp_path, checkpoints=resumed)


def test_rows_that_are_shorter_than_the_checkpoint_says_are_refused(
    tmp_path: Path,
) -> None:
    cut_off(pair(), tmp_path)
    (stream,) = (tmp_path / "result").glob("*.arrows")
    stream.write_bytes(stream.read_bytes()[:-400])
    with pytest.raises(FeedDriveError, match="is shorter than it was"):
        simulate(pair(), tmp_path, checkpoints=replace(EVERY, resumed=True))


def alone(component: Component, recorded: str) -> System:
    return system("1/100", [component], {}, {recorded: "1/1000"})


def test_fmus_that_cannot_are_named_before_the_run(tmp_path: Path) -> None:
    file = pack("ball", ball(2), tmp_path)
    bouncing = Component("ball", file, MS, isolation=Isolation())
    with pytest.raises(FeedDriveError, match=r"ball \(ball.fmu\) is for model exch"):
        simulate(alone(bouncing, "ball.h"), tmp_path / "1", checkpoints=EVERY)
    alien = Component("alien", foreign(2, tmp_path), MS)
    with pytest.raises(FeedDriveError, match=r"alien .* does not serialise its state"):
        simulate(alone(alien, "alien.out_Real"), tmp_path / "2", checkpoints=EVERY)
    with pytest.raises(FeedDriveError, match="leave --executor out"):
        simulate(pair(), tmp_path / "3", executor="fused", checkpoints=EVERY)
    assert not (tmp_path / "1").exists()


def test_the_verb_says_what_cannot_be_resumed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copyfile(PI, tmp_path / "pi.py")
    Path("s.toml").write_text(SHORT)
    short = ["run", "s.toml"]

    def said(*words: str) -> str:
        done = CliRunner().invoke(app, list(words))
        assert done.exit_code == 2, done.output
        return " ".join(done.stderr.split())

    assert CliRunner().invoke(app, short).exit_code in (0, 1)
    assert "is complete; there is nothing to resume" in said("resume", "1")
    (tmp_path / "runs" / "s" / "1" / "metrics.json").unlink()
    assert "has no checkpoints to go on from" in said("resume", "1")
    assert "there is no run '7'" in said("resume", "7")
    assert "two runs" in said(*short, "--checkpoint", "1", "--swap", "pi=x.fmu")
    like = f'{SHORT}expect_like = {{ folder = "b/", relative = 1e-3, time = "1 ms" }}\n'
    Path("like.toml").write_text(like)
    assert "is not compared with a baseline" in said(
        "run", "like.toml", "--checkpoint", "1/1000"
    )
    assert not Path("runs/like").exists()
