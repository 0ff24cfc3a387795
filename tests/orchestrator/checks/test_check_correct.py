"""A correct FMU gives no alarm, whatever the standard lets it do."""

import re
import zipfile
from pathlib import Path
from typing import Any

import pytest
from correct import correct, large, source_of
from counting import calls
from effort import EFFORT
from lxml import etree
from rewritten import rewritten
from typer.testing import CliRunner

from orchestrator.checks import Report, check_fmu, patience
from orchestrator.checks.archive import Archive
from orchestrator.checks.sources import source_sets
from orchestrator.cli import app


@pytest.fixture(params=[2, 3], ids=["FMI 2", "FMI 3"])
def fmi(request: pytest.FixtureRequest) -> int:
    return int(request.param)


def assert_no_alarm(report: Report) -> None:
    """Nothing violates the standard, everything could be tried or does not apply."""
    errors = [
        (o.item.key, f.text)
        for o in report.outcomes
        for f in o.findings
        if f.severity == "error"
    ]
    assert errors == []
    reasons = [o.reason for o in report.outcomes if o.verdict == "could not be run"]
    assert reasons == []
    assert report.clean


def outcome(report: Report, key: str) -> Any:
    return next(o for o in report.outcomes if o.item.key == key)


def test_what_ends_an_instance_after_an_error_passes(tmp_path: Path, fmi: int) -> None:
    """It also has arrays of a structural parameter's length, and a Binary."""
    report = check_fmu(correct(fmi, tmp_path))
    assert_no_alarm(report)
    assert report.counts["pass"] > 25
    assert report.notes == []


def test_an_fmu_may_end_the_run_itself(tmp_path: Path, fmi: int) -> None:
    report = check_fmu(correct(fmi, tmp_path, "ends"))
    assert_no_alarm(report)
    assert outcome(report, "8D").seen == ["20 steps of 0.001 s by co-simulation"]
    assert outcome(report, "17D").seen == ["19 steps of 0.001 s"]
    assert "it ends the run itself at t = 0.02 s" in report.notes


@pytest.mark.parametrize("kind", ["unstable", "chaotic"])
def test_what_a_model_amplifies_is_no_lost_step(tmp_path: Path, kind: str) -> None:
    report = check_fmu(correct(2, tmp_path, kind), only=[16, 17])
    assert_no_alarm(report)
    overflows = [n for n in report.notes if "beyond 1e+100 and is not judged" in n]
    assert len(overflows) == (kind == "unstable")


@pytest.mark.parametrize("fixed", [True, False])
def test_a_lost_step_is_still_found(tmp_path: Path, fixed: bool) -> None:
    fmu = correct(2, tmp_path, "loses a step", variable_step=not fixed)
    found = [f.text for f in outcome(check_fmu(fmu, only=[17]), "17D").findings]
    text = "times noisy by rounding end at other values: y is 1999.5, not 2000.5"
    assert text in found


def test_steps_of_another_length_are_still_found(tmp_path: Path) -> None:
    fmu = correct(2, tmp_path, "steps alike")
    (found,) = outcome(check_fmu(fmu, only=[16]), "16D").findings
    assert re.search(r"after 0.05 s in 6\d steps y is 0.53", found.text)


def test_an_fmu_that_wants_a_stop_time_gets_one(tmp_path: Path, fmi: int) -> None:
    report = check_fmu(correct(fmi, tmp_path, "wants a stop time"), only=[8, 21, 25])
    assert [o.item.key for o in report.outcomes if o.findings] == ["25D"]
    assert report.notes == ["it wants a stop time; it got 100 s"]


@pytest.mark.parametrize("kind", ["never returns", "waits"])
def test_a_call_without_end_is_found(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(patience, "SILENT", 1.0)
    report = check_fmu(correct(2, tmp_path, kind), only=[8])
    (found,) = outcome(report, "8D").findings
    assert found.text.startswith("no end within 1 s while stepping 50 times")


class Watched(patience.Patience):
    """One whose child says what it has computed, and whether it could run."""

    running, computed, clock = True, 0.0, 0.0

    def _threads(self) -> tuple[bool, float]:
        return self.running, self.computed


def looks(
    monkeypatch: pytest.MonkeyPatch, seconds: float, *, running: bool, share: float
) -> tuple[patience.Over | None, float]:
    """Look until it is enough, or for 300 s; ``share`` of the clock is computing."""
    now = [0.0]
    monkeypatch.setattr(patience, "monotonic", lambda: now[0])
    watch = Watched(0, seconds)
    watch.running = running
    while now[0] < 300:
        now[0] += 1.0
        watch.computed += share
        if over := watch.over(7, begun=True):
            return over, now[0]
    return None, now[0]


def test_a_process_that_waits_for_a_processor_is_given_its_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    alone, at = looks(monkeypatch, 60.0, running=True, share=1.0)
    assert alone is not None
    assert alone.verdict == "hung"
    assert at == pytest.approx(patience.SILENT, abs=3)
    crowded, later = looks(monkeypatch, 60.0, running=True, share=0.1)
    assert crowded is not None
    assert later == pytest.approx(10 * at, rel=0.2)
    asleep, at = looks(monkeypatch, 60.0, running=False, share=0.0)
    assert asleep is not None
    assert at == pytest.approx(patience.SILENT, abs=3)


def test_many_calls_that_take_too_long_are_no_fault(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [0.0]
    monkeypatch.setattr(patience, "monotonic", lambda: now[0])
    watch, over, calls = Watched(0, 60.0), None, 0
    while over is None:
        now[0] += 1.0
        calls += 10
        watch.computed += 1.0
        over = watch.over(calls, begun=True)
    assert over.verdict == "could not be run"
    assert 55 < now[0] < 65
    assert f"called {calls} times" in over.text("stepping")


IN_CPP = """<SourceFileSet language="C++11"><SourceFile name="more.cc"/>
    </SourceFileSet>"""
BUILD = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="correct" platform="riscv32-none">
    <SourceFileSet><SourceFile name="nowhere.c"/></SourceFileSet>
  </BuildConfiguration>
  <BuildConfiguration modelIdentifier="correct">
    <SourceFileSet language="C99" compiler="gcc" compilerOptions="-DBY_OPTION -O1">
      <SourceFile name="correct.c"/>
      <PreprocessorDefinition name="BY_VALUE" value="7"/>
      <PreprocessorDefinition name="PLAIN"/>
      <PreprocessorDefinition name="WRONG" optional="true"/>
      <IncludeDirectory name="inner/headers"/>
    </SourceFileSet>
    {IN_CPP}
    <Library name="m" external="true"/>
  </BuildConfiguration>
</fmiBuildDescription>
"""
WANTS = """#include "needed.h"
#if !defined(BY_OPTION) || BY_VALUE != 7 || !defined(PLAIN) || defined(WRONG)
#error the definitions are not those of the build description
#endif
"""


def test_sources_are_compiled_as_the_build_description_says(tmp_path: Path) -> None:
    """What is in C++ is known; it is compiled with --every-form.

    For that zig builds libc++ first, a minute on every machine that CI makes anew.
    """
    sources, build, count = source_of(3), BUILD, 2
    if not EFFORT.every:
        build, count = BUILD.replace(IN_CPP, ""), 1
    members = {
        "correct.c": WANTS + sources["correct.c"],
        "inner/headers/needed.h": "",
        "config.h": sources["config.h"],
        "nowhere.c": "#error not for this machine",
        "more.cc": "namespace more { class Other {}; }",
        "buildDescription.xml": build,
    }
    more = {f"sources/{name}": text for name, text in members.items()}
    fmu = rewritten(correct(3, tmp_path), tmp_path, more=more)
    report = check_fmu(fmu, only=[34])
    assert_no_alarm(report)
    assert outcome(report, "34D").seen == [f"{count} files compiled, bit-equal"]


def test_files_in_cpp_are_told_from_those_in_c(tmp_path: Path) -> None:
    more = {"sources/buildDescription.xml": BUILD}
    fmu = rewritten(correct(3, tmp_path), tmp_path, more=more)
    sets = source_sets(Archive(fmu), "correct")
    told = {file: one.is_cpp(file) for one in sets for file in one.files}
    assert told == {"correct.c": False, "more.cc": True}


def with_source_files(root: Any) -> None:
    files = etree.SubElement(root.find("CoSimulation"), "SourceFiles")
    etree.SubElement(files, "File", name="correct.c")


def test_sources_may_have_the_model_identifier_as_prefix(tmp_path: Path) -> None:
    sources = source_of(2)
    functions = set(re.findall(r"\bfmi2\w+", "".join(sources.values())))
    prefix = "\n".join(f"#define {f} correct_{f}" for f in sorted(functions))
    more = {
        "sources/config.h": sources["config.h"],
        "sources/correct.c": f"{prefix}\n{sources['correct.c']}",
    }
    fmu = rewritten(correct(2, tmp_path), tmp_path, with_source_files, more=more)
    report = check_fmu(fmu, only=[34])
    assert_no_alarm(report)
    assert outcome(report, "34D").seen == ["1 files compiled, bit-equal"]


def test_sources_that_are_listed_but_not_there_are_its_fault(tmp_path: Path) -> None:
    fmu = rewritten(correct(2, tmp_path), tmp_path, with_source_files)
    report = check_fmu(fmu, only=[34])
    (found,) = outcome(report, "34S").findings
    assert found.text == "there is no sources/, but correct.c are listed"
    assert outcome(report, "34D").verdict == "not applicable"


def scheduled(root: Any) -> None:
    interface = root.find("CoSimulation")
    interface.tag = "ScheduledExecution"
    interface.attrib.pop("canHandleVariableCommunicationStepSize")


def test_scheduled_execution_is_not_called_a_missing_binary(tmp_path: Path) -> None:
    fmu = rewritten(correct(3, tmp_path), tmp_path, scheduled)
    report = check_fmu(fmu)
    assert_no_alarm(report)
    tried = [o for o in report.outcomes if o.item.part == "dynamic"]
    assert {o.verdict for o in tried} == {"not applicable"}
    assert all("scheduled execution only" in o.reason for o in tried)


@pytest.mark.parametrize("platform", ["darwin64", "x86_64-darwin", "win64", "linux32"])
def test_each_system_has_a_suffix_of_its_own(tmp_path: Path, platform: str) -> None:
    two = "-" not in platform
    suffix = {"d": ".dylib", "x": ".dylib", "w": ".dll", "l": ".so"}[platform[0]]
    binary = f"binaries/{platform}/correct{suffix}"
    fmu = rewritten(correct(2 if two else 3, tmp_path), tmp_path, more={binary: "x"})
    assert outcome(check_fmu(fmu, only=[10], dynamic=False), "10S").findings == []
    with zipfile.ZipFile(fmu, "a") as archive:
        archive.writestr("binaries/darwin32/correct.dll", "x")
    named = [f.text for f in outcome(check_fmu(fmu, only=[10]), "10S").findings]
    expected = "there is no binaries/darwin32/correct.dylib"
    assert expected in named if two else "FMI 3 wants" in named[0]


def test_the_work_to_show_variables_grows_with_their_number_only(
    tmp_path: Path,
) -> None:
    files = {}
    for number in (1, 100, 400):
        folder = tmp_path / str(number)
        folder.mkdir()
        files[number] = str(large(folder, number, 3 * number))

    def work(number: int) -> int:
        return calls(lambda: CliRunner().invoke(app, ["info", files[number], "--json"]))

    work(1)  # imports
    assert 3 * work(100) < work(400) < 5 * work(100)


def test_a_large_fmu_is_sampled_and_says_so(tmp_path: Path) -> None:
    """More parameters than are tried one by one, more locals than are watched."""
    fmu = large(tmp_path, 1000, 3000)
    shown = CliRunner().invoke(app, ["info", str(fmu)])
    assert shown.exit_code == 0
    assert "drive[2999].x" in shown.output
    report = check_fmu(fmu, only=[5, 6, 9, 16, 24])
    assert_no_alarm(report)
    assert report.notes == [
        "a sample: 200 of 1001 parameters",
        "a sample: 1999 of 3000 locals",
    ]
    told = CliRunner().invoke(app, ["check", str(fmu), "--only", "24"])
    assert "note: a sample: 200 of 1001 parameters" in told.output
