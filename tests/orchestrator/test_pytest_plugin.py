"""The pytest plugin finds scenarios, runs them, and says where they fail."""

import re
import shutil
import zipfile
from pathlib import Path

import pytest

from fmus.build import build
from orchestrator.pytest_plugin import assert_fmu_conforms

pytest_plugins = ["pytester"]
EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "own_drive"
WEAK = """\
base = "speed_step.toml"

[components.controller]
parameters = { K_p = 0.5 }
"""


@pytest.fixture
def example(pytester: pytest.Pytester) -> pytest.Pytester:
    """A repository laid out as the docs say."""
    ignored = shutil.ignore_patterns("__pycache__", ".*", "runs")
    shutil.copytree(EXAMPLE, pytester.path, ignore=ignored, dirs_exist_ok=True)
    return pytester


def run(pytester: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    return pytester.runpytest_subprocess("-p", "no:cacheprovider", *arguments)


def test_the_example_of_the_docs_passes(example: pytest.Pytester) -> None:
    run(example, "--feeddrive-runs", "kept").assert_outcomes(passed=5)
    kept = {folder.name for folder in (example.path / "kept").iterdir()}
    assert "tests-speed_step.toml--expect" in kept
    assert len(kept) == 3  # the test that compares two runs keeps both


def test_a_composition_that_misses_its_bounds_fails_and_says_where(
    example: pytest.Pytester,
) -> None:
    (example.path / "tests" / "weak_gain.toml").write_text(WEAK)
    result = run(example, "tests/weak_gain.toml", "--feeddrive-runs", "kept")
    result.assert_outcomes(failed=1)
    text = result.stdout.str()
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
    assert Path(report[1]).is_relative_to(example.path / "kept")
    assert Path(report[1]).is_file()
    assert "Traceback" not in text


def test_a_figure_the_run_does_not_have_fails_with_reason_stretch_and_report(
    example: pytest.Pytester,
) -> None:
    (example.path / "tests" / "weak_gain.toml").write_text(WEAK.replace("0.5", "0.02"))
    result = run(example, "tests/weak_gain.toml")
    result.assert_outcomes(failed=1)
    lost = re.search(
        r"speed.settling: not settled: the error is -198.\d+ rad/s at 0.1 s, outside "
        r"the band of 2 rad/s; expected below 30 ms\n"
        r" +motor.omega - 100 rad/s: worst from ([\d.]+) s to 0.1 s",
        result.stdout.str(),
    )
    assert lost is not None, result.stdout.str()
    assert "speed.overshoot = 207" in result.stdout.str()
    assert "report: " in result.stdout.str()


def test_a_run_that_diverges_fails_with_that_before_all_else(
    example: pytest.Pytester,
) -> None:
    (example.path / "tests" / "wrong_sign.toml").write_text(WEAK.replace("0.5", "-50"))
    result = run(example, "tests/wrong_sign.toml")
    result.assert_outcomes(failed=1)
    named = "diverged: motor.omega passes 1e+08 rad/s at t = 0.003 s"
    lines = result.outlines
    assert lines[lines.index(named) + 1].startswith("speed.settling: not settled")
    assert "Warning" not in result.stdout.str()


def test_a_scenario_with_a_mistake_fails_with_one_paragraph(
    example: pytest.Pytester,
) -> None:
    file = example.path / "tests" / "speed_step.toml"
    file.write_text(file.read_text().replace("motor.i", "motor.current"))
    result = run(example, "tests/speed_step.toml")
    result.assert_outcomes(failed=1)
    assert "motor.current" in result.stdout.str()
    assert "pytest_plugin.py" not in result.stdout.str()


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
    ],
)
def test_only_scenarios_with_expectations_are_collected(
    example: pytest.Pytester, name: str, text: str, collected: int
) -> None:
    (example.path / "tests" / name).write_text(text)
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
    tmp_path: Path,
) -> None:
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
