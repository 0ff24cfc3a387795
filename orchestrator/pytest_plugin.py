"""Pytest plugin ``feeddrive``: compositions of FMUs under test.

A ``.toml`` scenario with ``[expect]`` or ``expect_like`` in a test folder is one test:
it is run, and fails with every expectation not met: value, bound, where it was worst,
and the report.  ``--feeddrive-update`` writes the signals that later runs are to be
like.  Bases (``_name.toml``) and lock files are left alone unless they are named on
the command line.  The fixtures ``build_fmu``, ``load_fmu``, ``compose_scenario`` and
``run_scenario`` do the same from Python; ``assert_fmu_conforms`` holds an FMU against
the standard.

Nothing of feeddrive is imported before a scenario is found or a fixture asked
for.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from orchestrator.master.stepper import Stepper
    from orchestrator.outcome import Run
    from orchestrator.scenario.compose import Composition
    from orchestrator.scenario.reading import Scenario

LOCKS = ".lock.toml"
BASES = 200  # files that are looked into for one


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("feeddrive")
    group.addoption(
        "--feeddrive-runs",
        metavar="DIR",
        help="keep the folders of scenario runs here (default: pytest's temporary)",
    )
    group.addoption(
        "--feeddrive-update",
        action="store_true",
        help="write the signals of scenarios with expect_like as their baselines",
    )


def pytest_collect_file(
    file_path: Path, parent: pytest.Collector
) -> "ScenarioFile | None":
    if file_path.suffix != ".toml":
        return None
    named = parent.session.isinitpath(file_path)
    aside = file_path.name.startswith("_") or file_path.name.endswith(LOCKS)
    if (aside and not named) or not _expects(file_path, set()):
        return None
    found: ScenarioFile = ScenarioFile.from_parent(parent, path=file_path)
    return found


def _expects(file: Path, seen: set[Path]) -> bool:
    """Tell whether a file is a scenario with expectations, its own or a base's.

    One that cannot be read to the end, or means them and calls them otherwise, counts:
    its test says what is wrong, where none would say that all is well.
    """
    from orchestrator.scenario.toml import read_toml_text, toml

    seen.add(file)
    is_base = len(seen) > 1
    try:
        text = read_toml_text(file)
    except (OSError, ValueError):
        return is_base
    words = ("base", "components", "expect")
    if not is_base and not any(word in text for word in words):
        return False
    try:
        tables = toml(text)
    except ValueError:
        return is_base or bool(re.search(r"(?m)^\s*\[?\s*expect", text))
    bases = tables.get("base", [])
    if "components" not in tables and not bases:
        return False
    if get_close_matches("expect", set(tables) - {"expect"}, cutoff=0.8):
        return True
    if isinstance(expect := tables.get("expect"), dict) and any(expect.values()):
        return True
    if tables.get("expect_like"):
        return True
    names = [bases] if isinstance(bases, str) else bases
    above = [_base(file, str(name)) for name in names if isinstance(names, list)]
    above = [base for base in above if base.suffix == ".toml"]
    new = [base for base in above if base not in seen and len(seen) < BASES]
    return any(_expects(base, seen) for base in new)


def _base(file: Path, name: str) -> Path:
    """Return a base's file: beside, or of a published scenario."""
    if "/" in name and not name.endswith(".toml"):
        from orchestrator.scenario.reading import STUDIES

        return STUDIES / f"{name}.toml"
    return file.parent / name


class ScenarioFile(pytest.File):
    """A scenario file; it holds one test."""

    def collect(self) -> Iterable[pytest.Item]:
        yield ScenarioTest.from_parent(self, name="expect")


class ExpectationsNotMet(Exception):
    """The text of a failed scenario test."""


class ScenarioTest(pytest.Item):
    """Runs a scenario and checks its expectations."""

    def runtest(self) -> None:
        from orchestrator.session import run

        done = run(self.path, _folder(self.config, self.nodeid), overwrite=True)
        spec = done.scenario.spec.expect_like
        updating = spec is not None and self.config.getoption("--feeddrive-update")
        unlike = [*_unanswered(done), *(() if updating else done.unlike)]
        if text := unmet(done, unlike):
            kept = "\nso it is not made the baseline" if updating else ""
            raise ExpectationsNotMet(text + kept)
        if updating:
            from orchestrator.evaluation.baseline import update

            update(done.scenario.file, spec, done)

    def repr_failure(
        self,
        excinfo: pytest.ExceptionInfo[BaseException],
        style: Any = None,
    ) -> Any:
        from orchestrator.errors import FeedDriveError, shown

        if isinstance(excinfo.value, ExpectationsNotMet | FeedDriveError):
            return shown(str(excinfo.value))
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        return self.path, None, f"scenario {self.path.stem}"


def _unanswered(done: "Run") -> list[str]:
    """Return what is expected of responses and not met."""
    if not done.scenario.spec.responses:
        return []
    from orchestrator.response.expected import respond

    return [c.text for c in respond(done.composition).checks if not c.met]


def unmet(done: "Run", unlike: Sequence[str]) -> str:
    """Return the expectations a run does not meet, one paragraph each, or nothing.

    A run that diverged says so first; ``unlike`` comes last.
    """
    from orchestrator.evaluation.worst import worst_stretch

    spec = done.scenario.spec
    lines = [done.diverged] if done.diverged else []
    for check in done.checks:
        if check.met:
            continue
        metric = spec.metrics[check.figure.rpartition(".")[0]]
        expected = spec.expect[check.figure]
        parameter = done.composition.parameter
        worst = worst_stretch(check.figure, metric, expected, done, parameter)
        lines.append(f"{check.text}\n    {worst}")
    lines += unlike
    if lines:
        lines.append(f"report: {(done.folder / 'report.html').absolute()}")
    return "\n".join(lines)


def _folder(config: pytest.Config, name: str) -> Path:
    """Return a folder for a run, new or of the same test's earlier run."""
    plain = "".join(c if c.isalnum() or c in "-_." else "-" for c in name)
    if chosen := config.getoption("--feeddrive-runs"):
        return Path(config.invocation_params.dir, chosen, plain)
    factory: pytest.TempPathFactory = config._tmp_path_factory  # type: ignore[attr-defined]
    return factory.mktemp(plain[-60:], numbered=True)


@pytest.fixture
def build_fmu(tmp_path: Path) -> Callable[..., Path]:
    """``build_fmu("plants.xy_table.axis", fmi=3)`` or a ``.py`` beside the test.

    Options are those of ``fmus.build.build``; a period may be text.
    """
    from fmus.build import build
    from orchestrator.quantities.quantity import parse_period

    def built(module: str | Path, **options: Any) -> Path:
        if (period := options.get("period")) is not None:
            options["period"] = parse_period(period)
        return build(str(module), **{"folder": tmp_path / "fmus", **options})

    return built


@pytest.fixture
def load_fmu() -> "Iterator[Callable[..., Stepper]]":
    """``load_fmu("their.fmu", values={"m": 2.0})``: an initialised FMU to step.

    Closed at the end of the test; see ``orchestrator.master.stepper``.
    """
    from contextlib import ExitStack

    from orchestrator.master.stepper import Stepper

    with ExitStack() as stack:

        def loaded(
            path: str | Path, values: Mapping[str, Any] | None = None
        ) -> "Stepper":
            return stack.enter_context(Stepper(path, values))

        yield loaded


@pytest.fixture
def compose_scenario(request: pytest.FixtureRequest) -> "Callable[..., Composition]":
    """``compose_scenario(scenario, *overrides, swaps=None)``: wired, nothing run.

    ``scenario`` is a name, a path (from the test's folder) or the tables of a
    scenario as a dictionary; ``overrides`` are texts as for ``--set``, ``swaps``
    ``{"plant": {"fmu": "their.fmu", "map": {...}}}``.
    """
    from orchestrator.scenario.compose import compose
    from orchestrator.session import naming, run_earlier

    def composed(
        scenario: str | Path | Mapping[str, Any], *overrides: str, **options: Any
    ) -> "Composition":
        loaded = _scenario(request.path, scenario, overrides, **options)
        with naming(loaded):
            return compose(loaded, run_earlier)

    return composed


@pytest.fixture
def run_scenario(request: pytest.FixtureRequest) -> "Callable[..., Run]":
    """``run_scenario(scenario, *overrides, swaps=None)``: the finished run.

    Arguments as for ``compose_scenario``; the result has signals by name,
    ``metrics``, ``checks`` and its ``folder``.
    """
    from itertools import count

    from orchestrator.session import run

    numbers = count(1)  # every run of a test keeps its own folder

    def ran(
        scenario: str | Path | Mapping[str, Any], *overrides: str, **options: Any
    ) -> "Run":
        loaded = _scenario(request.path, scenario, overrides, **options)
        name = f"{request.node.nodeid}-{next(numbers)}"
        return run(loaded, _folder(request.config, name), overwrite=True)

    return ran


def _scenario(
    test: Path,
    scenario: str | Path | Mapping[str, Any],
    overrides: Sequence[str],
    swaps: Mapping[str, Mapping[str, Any]] | None = None,
) -> "Scenario":
    from orchestrator.scenario.reading import load_scenario, scenario_from

    if isinstance(scenario, Mapping):
        return scenario_from(scenario, test.with_suffix(".toml"), overrides, swaps)
    beside = test.parent / scenario
    chosen = beside if str(scenario).endswith(".toml") else scenario
    return load_scenario(chosen, overrides, swaps)


def assert_fmu_conforms(path: str | Path) -> None:
    """Fail with the violations that ``feeddrive check`` finds, and how to mend them.

    What is only advised does not fail; an item that could not be run does.
    """
    from orchestrator.checks import check_fmu

    lines = []
    report = check_fmu(Path(path))
    for outcome in report.outcomes:
        item = outcome.item
        where = f"{item.number} {item.part}: {item.title} ({report.clause(item)})"
        if outcome.verdict == "could not be run":
            lines.append(f"{where}\n    could not be run: {outcome.reason}")
        lines += [
            f"{where}\n    {finding.text}\n    remedy: {finding.mend or item.mend}"
            for finding in outcome.findings
            if finding.severity == "error"
        ]
    if lines:
        pytest.fail("\n".join([f"{path} does not conform:", *lines]), pytrace=False)
