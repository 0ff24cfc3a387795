"""The pytest plugin finds scenarios, runs them, and says where they fail."""

import re
import shutil
import subprocess
import sys
import zipfile
from functools import partial
from pathlib import Path

import pytest

from fmus.build import build
from orchestrator.checks import check_fmu
from orchestrator.pytest_plugin import assert_fmu_conforms
from orchestrator.supplied import PROJECT as EXAMPLE

pytest_plugins = ["pytester"]
IGNORED = shutil.ignore_patterns("__pycache__", ".*", "runs")
FILES_ALONE = partial(check_fmu, dynamic=False)
FAILING = ("weak_gain", "weaker", "wrong_sign", "mistake")
WEAK = """\
base = "speed_step.toml"

[components.controller]
parameters = { K_p = 0.5 }
"""


@pytest.fixture
def example(pytester: pytest.Pytester) -> pytest.Pytester:
    """A repository laid out as the docs say."""
    shutil.copytree(EXAMPLE, pytester.path, ignore=IGNORED, dirs_exist_ok=True)
    return pytester


def test_the_example_of_the_docs_passes(example: pytest.Pytester) -> None:
    options = ("-p", "no:cacheprovider", "--feeddrive-runs", "kept")
    example.runpytest_subprocess(*options).assert_outcomes(passed=5)
    kept = {folder.name for folder in (example.path / "kept").iterdir()}
    assert "tests-speed_step.toml--expect" in kept
    assert len(kept) == 3  # the test that compares two runs keeps both


@pytest.fixture(scope="module")
def failed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, str]]:
    """Four scenarios that fail, in one session; its folder, and what it says of each.

    In a process of its own, as everything of ours is imported late there.
    """
    place = tmp_path_factory.mktemp("failing")
    shutil.copytree(EXAMPLE, place, ignore=IGNORED, dirs_exist_ok=True)
    tests = place / "tests"
    for name, gain in (("weak_gain", "0.5"), ("weaker", "0.02"), ("wrong_sign", "-50")):
        (tests / f"{name}.toml").write_text(WEAK.replace("0.5", gain))
    right = (tests / "speed_step.toml").read_text()
    (tests / "mistake.toml").write_text(right.replace("motor.i", "motor.current"))
    names = [f"tests/{name}.toml" for name in FAILING]
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *names]
    done = subprocess.run(
        [*command, "--feeddrive-runs", "kept"],
        cwd=place,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "4 failed" in done.stdout, done.stdout + done.stderr
    heads = re.split(r"(?m)^_+ scenario (\w+) _+$", done.stdout.partition("= short")[0])
    return place, dict(zip(heads[1::2], heads[2::2], strict=True))


def test_a_composition_that_misses_its_bounds_fails_and_says_where(
    failed: tuple[Path, dict[str, str]],
) -> None:
    place, said = failed
    text = said["weak_gain"]
    overshoot = re.search(
        r"speed.overshoot = ([\d.]+) %, expected below 10 %\n"
        r" +motor.omega - 100 rad/s: worst from ([\d.]+) s to ([\d.]+) s, "
        r"([\d.]+) rad/s at ([\d.]+) s\n",
        text,
    )
    assert overshoot is not None, text
    percent, start, end, peak, at = map(float, overshoot.groups())
    assert peak == pytest.approx(percent)  # of a step to 100 rad/s
    assert 0 < start < at < end < 0.1
    report = re.search(r"report: (.*report.html)", text)
    assert report is not None
    assert Path(report[1]).is_relative_to(place / "kept")
    assert Path(report[1]).is_file()
    assert "Traceback" not in text


def test_a_figure_the_run_does_not_have_fails_with_reason_stretch_and_report(
    failed: tuple[Path, dict[str, str]],
) -> None:
    text = failed[1]["weaker"]
    lost = re.search(
        r"speed.settling: not settled: the error is -198.\d+ rad/s at 0.1 s, outside "
        r"the band of 2 rad/s; expected below 30 ms\n"
        r" +motor.omega - 100 rad/s: worst from ([\d.]+) s to 0.1 s",
        text,
    )
    assert lost is not None, text
    assert "speed.overshoot = 207" in text
    assert "report: " in text


def test_a_run_that_diverges_fails_with_that_before_all_else(
    failed: tuple[Path, dict[str, str]],
) -> None:
    text = failed[1]["wrong_sign"]
    named = "diverged: motor.omega passes 1e+08 rad/s at t = 0.003 s"
    lines = text.splitlines()
    assert lines[lines.index(named) + 1].startswith("speed.settling: not settled")
    assert "Warning" not in text


def test_a_scenario_with_a_mistake_fails_with_one_paragraph(
    failed: tuple[Path, dict[str, str]],
) -> None:
    text = failed[1]["mistake"]
    assert "motor.current" in text
    assert "pytest_plugin.py" not in text
    assert "\n\n" not in text.strip()


@pytest.mark.parametrize(
    ("name", "text", "collected"),
    [
        ("inherits.toml", 'base = "speed_step.toml"', 1),
        ("without.toml", 'base = "speed_step.toml"\n[expect]\n"a.b" = false', 1),
        ("_base.toml", 'base = "speed_step.toml"', 0),
        ("again.lock.toml", 'base = "speed_step.toml"', 0),
        ("circle.toml", 'base = "circle.toml"', 0),
        ("settings.toml", "[expect]\nnothing = 1", 0),
        ("broken.toml", "[expect]\na = = 1", 1),
        ("other.toml", "a = = 1", 0),
        ("dotted.toml", 'base = "x.toml"\nexpect."a.b" = = 1', 1),
        ("heir.toml", 'base = "lost.toml"', 1),
        ("of_broken.toml", 'base = "_broken.toml"', 1),
        ("misspelled.toml", 'base = "speed_step.toml"\n[expected]\na = 1', 1),
        ("foreign.toml", 'base = "main"\nlevel = 3', 0),
    ],
)
def test_only_scenarios_with_expectations_are_collected(
    example: pytest.Pytester, name: str, text: str, collected: int
) -> None:
    (example.path / "tests" / name).write_text(text)
    (example.path / "tests" / "_broken.toml").write_text("a = = 1")
    result = example.runpytest_inprocess("--collect-only", "-q")
    listed = [line for line in result.outlines if line.startswith(f"tests/{name}")]
    assert len(listed) == collected


def test_a_run_without_scenarios_imports_nothing_of_ours(
    pytester: pytest.Pytester,
) -> None:
    pytester.makepyfile(
        """
        import sys

        def test_it():
            ours = [m for m in sys.modules if m.partition(".")[0] == "orchestrator"]
            assert sorted(ours) == ["orchestrator", "orchestrator.pytest_plugin"]
            assert "numpy" not in sys.modules
        """
    )
    pytester.runpytest_subprocess().assert_outcomes(passed=1)


def test_an_fmu_that_violates_the_standard_is_refused_with_the_clause(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By what stands in its files; nothing of it needs to run for that."""
    monkeypatch.setattr("orchestrator.checks.check_fmu", FILES_ALONE)
    sound = build(str(EXAMPLE / "models" / "speed_pi.py"), folder=tmp_path)
    broken = tmp_path / "broken.fmu"
    with zipfile.ZipFile(sound) as old, zipfile.ZipFile(broken, "w") as new:
        for item in old.infolist():
            content = old.read(item)
            if item.filename == "modelDescription.xml":
                content = content.replace(b"<Outputs>", b"<Outputs/><Was>")
                content = content.replace(b"</Outputs>", b"</Was>")
            new.writestr(item, content)
    with pytest.raises(pytest.fail.Exception, match=r"does not conform[\s\S]*remedy:"):
        assert_fmu_conforms(broken)
