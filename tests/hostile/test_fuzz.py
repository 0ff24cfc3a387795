"""What readers are given is changed at random, from a kept corpus; they refuse or read.

``corpus/`` holds what was found, and the seeds; whatever is found joins it.  A minute
per reader with ``--hostile``, as long as one likes with ``--fuzz-seconds``.
"""

import contextlib
import json
import re
import subprocess
import time
import zipfile
from collections.abc import Callable, Iterable
from fractions import Fraction
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from draws import seed
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as seeded
from hypothesis import strategies as st
from tools import lacking, needed

from fmus.build import build
from orchestrator.errors import FeedDriveError
from orchestrator.fmu.archive import unpacked
from orchestrator.fmu.description import read_fmu
from orchestrator.instances.frames import Damaged, decode, encode
from orchestrator.instances.logs import LogMessage
from orchestrator.master.simulate import plan
from orchestrator.scenario.reading import scenario_from
from orchestrator.scenario.toml import toml
from orchestrator.system import Component, System

Fuzzed = Callable[..., None]
Damage = tuple[list[tuple[int, int]], int]  # bytes that are others, and a cut
CORPUS = Path(__file__).parent / "corpus"
FEWEST = 100  # examples, or the machine is too slow to find anything
GARBAGE = (
    *("", "abc", "nan", "inf", "-inf", "1e999", "1e999999999", "-1", "0", "1" * 2000),
    *("0x10", "1,5", "true", "\u0660", "1e-400", "1/0", "..", "a/b", "1 2 3", "\0"),
    *("[" * 200, "{" * 200, "'", '"', "=", "<", "&#x1b;", "99999999999999999999"),
)
QUIET = settings(
    deadline=None,
    database=None,
    phases=(Phase.explicit, Phase.generate, Phase.shrink),
    suppress_health_check=list(HealthCheck),
)


class TimeIsUp(BaseException):
    """Nothing that hypothesis would take for a finding."""


@pytest.fixture
def seconds(request: pytest.FixtureRequest) -> float:
    return float(request.config.getoption("--fuzz-seconds"))


@pytest.fixture
def fuzzed(seconds: float, record_property: Callable[[str, object], None]) -> Fuzzed:
    """Give a check what is known, then what a strategy draws, another sequence in every
    commit."""

    def fuzz(
        strategy: Any, check: Callable[[Any], None], known: Iterable[Any] = ()
    ) -> None:
        for one in known:
            check(one)
        until, count = time.monotonic() + seconds, 0

        @seeded(seed())
        @settings(QUIET, max_examples=10**9)
        @given(strategy)
        def tried(drawn: Any) -> None:
            nonlocal count
            if time.monotonic() > until:
                raise TimeIsUp
            check(drawn)
            count += 1

        with contextlib.suppress(TimeIsUp):
            tried()
        record_property("told", f"{check.__qualname__.split('.')[0]}: {count} examples")
        assert count >= FEWEST

    return fuzz


def texts(name: str) -> list[str]:
    return [f.read_text("utf-8") for f in sorted((CORPUS / name).iterdir())]


@st.composite
def changed(draw: st.DrawFn, seeds: list[str], spots: str) -> str:
    """Return a text of the corpus in which a few spots are something else."""
    text = draw(st.sampled_from(seeds))
    for _ in range(draw(st.integers(1, 4))):
        found = list(re.finditer(spots, text))
        if not found:
            break
        spot = found[draw(st.integers(0, len(found) - 1))]
        other = found[draw(st.integers(0, len(found) - 1))][0]
        new = draw(st.sampled_from([*GARBAGE, other, other + other]))
        text = text[: spot.start()] + new + text[spot.end() :]
    return text


def test_descriptions_are_read_or_refused(tmp_path: Path, fuzzed: Fuzzed) -> None:
    names = [build("plants.ball_screw.two_mass", fmi=fmi) for fmi in (2, 3)]
    names += [build("controllers.ball_screw.mc_ppc", fmi=fmi) for fmi in (2, 3)]
    seeds = texts("descriptions")
    for name in names:
        with zipfile.ZipFile(name) as archive:
            seeds.append(archive.read("modelDescription.xml").decode())
    fmu, T = tmp_path / "m.fmu", Fraction(1, 20_000)

    def check(text: str) -> None:
        with zipfile.ZipFile(fmu, "w") as archive:
            archive.writestr("modelDescription.xml", text)
        read_fmu.__globals__["_read"].cache_clear()
        try:
            found = read_fmu(fmu)
            record = {f"a.{name}": (T,) for name in found.outputs}
            plan(System("t", 100 * T, {"a": Component("a", fmu, T)}, {}, record))
        except FeedDriveError:
            pass

    fuzzed(changed(seeds, r'(?<==")[^"]*(?=")|\w+="[^"]*"|<\w+'), check, seeds)


def test_archives_are_unpacked_or_refused(tmp_path: Path, fuzzed: Fuzzed) -> None:
    whole = BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("modelDescription.xml", "resources/a/b.txt", "binaries/x/y.so"):
            archive.writestr(name, name * 20)
    data, fmu = whole.getvalue(), tmp_path / "m.fmu"
    byte = st.tuples(st.integers(0, len(data) - 1), st.integers(0, 255))
    changes = st.tuples(st.lists(byte, max_size=8), st.integers(0, len(data)))
    found: list[Damage] = json.loads((CORPUS / "archives.json").read_text())

    def check(drawn: Damage) -> None:
        content = bytearray(data)
        for place, value in drawn[0]:
            content[place] = value
        fmu.write_bytes(content[drawn[1] :] if drawn[1] % 3 == 0 else content)
        try:
            with unpacked(fmu) as folder:
                inside = [file.resolve() for file in folder.rglob("*")]
                assert all(file.is_relative_to(folder.resolve()) for file in inside)
        except FeedDriveError:
            pass

    fuzzed(changes, check, found)


def test_scenarios_are_read_or_refused(tmp_path: Path, fuzzed: Fuzzed) -> None:
    file = tmp_path / "s.toml"

    def check(text: str) -> None:
        try:
            tables = toml(text)
        except ValueError:
            return
        with contextlib.suppress(FeedDriveError):
            scenario_from(tables, file)

    spots = r'"[^"\n]*"|\b[\w.]+\b|[=\[\]{}]|\n'
    fuzzed(changed(texts("scenarios"), spots), check, texts("scenarios"))


def test_frames_are_read_or_damaged(fuzzed: Fuzzed) -> None:
    seeds = texts("frames")
    seeds += [encode("log", LogMessage("Error", "a", "b", 0.5)).decode()]
    seeds += [encode("done", [1.5, True, "x", b"\0"]).decode()]

    def check(text: str) -> None:
        try:
            kind, _ = decode(text.encode("utf-8", "surrogatepass"))
        except Damaged:
            return
        assert isinstance(kind, str)
        json.loads(text)

    fuzzed(
        changed(seeds, r'"[^"]*"|[\d.]+|[\[\]{},:]|null|true') | st.text(), check, seeds
    )


def states(model: str, tmp_path: Path, compiler: list[str]) -> Path | None:
    """Return a model's C and states.c as a program; None if it cannot be linked."""
    fmu = build(str(CORPUS.parents[1] / "fmus" / "small_models" / f"{model}.py"))
    described = read_fmu(fmu)
    with unpacked(fmu) as folder:
        sources = [*folder.glob("sources/*.c"), CORPUS.parent / "states.c"]
        command = [*compiler, "-g", "-O1", "-std=gnu11"]
        command += ["-fno-sanitize-recover=all", f"-I{folder / 'sources'}"]
        command += [f'-DTOKEN="{described.token}"']
        command += [f"-DINPUT_REFERENCE={described[described.inputs[0]].reference}"]
        command += [str(file) for file in sources if file.stem != "all"]
        program = tmp_path / "states"
        done = subprocess.run([*command, "-lm", "-o", str(program)], check=False)
    return program if done.returncode == 0 else None


def libfuzzer(program: Path, seconds: float, longest: int) -> str:
    """Let libFuzzer look for as long; return what it says at the end."""
    number = int(sha256(seed().encode()).hexdigest()[:7], 16)
    options = [f"-max_total_time={seconds:.0f}", f"-seed={number}", "-timeout=20"]
    options += [f"-max_len={longest}", f"-artifact_prefix={program.parent}/"]
    command = [program, *options, "-detect_leaks=1"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return next(line for line in done.stderr.splitlines() if line.startswith("Done "))


@pytest.mark.parametrize("model", ["pi", "late", "spring_mass"])
def test_states_that_libfuzzer_finds_are_taken_or_refused(
    model: str,
    tmp_path: Path,
    seconds: float,
    record_property: Callable[[str, object], None],
) -> None:
    needed("clang")
    sanitizers = "-fsanitize=fuzzer,address,undefined"
    program = states(model, tmp_path, ["clang", sanitizers, "-DLIBFUZZER"])
    if program is None:
        lacking("libFuzzer (libclang-rt-14-dev)")
    told = libfuzzer(program, seconds, longest=96)
    record_property("told", f"states of {model}, libFuzzer: {told}")


@pytest.mark.parametrize("what", ["kernel", "channel"])
def test_whatever_an_fmu_returns_the_c_of_the_master_stays_sound(
    what: str,
    tmp_path: Path,
    seconds: float,
    record_property: Callable[[str, object], None],
) -> None:
    """Without this a Boolean of 255 is a number, and a count beyond its type."""
    needed("clang")
    command = ["clang", "-fsanitize=fuzzer,address,undefined", "-g", "-O1"]
    command += ["-std=gnu11", "-Wall", "-Werror", "-fno-sanitize-recover=all"]
    command += [str(CORPUS.with_name(f"{what}.c")), "-lm", "-o", str(tmp_path / what)]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    if made.returncode and "libclang_rt" in made.stderr:
        lacking("libFuzzer (libclang-rt-14-dev)")
    assert made.returncode == 0, made.stderr[-3000:]
    told = libfuzzer(tmp_path / what, seconds, longest=400)
    record_property("told", f"{what}, libFuzzer: {told}")


@pytest.mark.parametrize("model", ["pi", "late", "spring_mass"])
def test_serialised_states_are_taken_or_refused(
    model: str,
    tmp_path: Path,
    seconds: float,
    record_property: Callable[[str, object], None],
) -> None:
    needed("gcc")  # which brings the sanitizers
    program = states(model, tmp_path, ["gcc", "-fsanitize=address,undefined"])
    assert program
    until = time.monotonic() + seconds
    number = int(sha256(seed().encode()).hexdigest()[:8], 16)
    tries = taken = 0
    while time.monotonic() < until or not tries:
        done = subprocess.run(
            [program, "50000", str(number + tries)],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr[:3000]
        told, took = (int(word.split()[0]) for word in done.stdout.split(","))
        tries, taken = tries + told, taken + took
    record_property("told", f"states of {model}: {tries} tries, {taken} taken")
    assert 0 < taken < tries
