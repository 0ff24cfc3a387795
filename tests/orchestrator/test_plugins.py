"""A package of somebody else adds a model, a metric, a check, a peer and a writer."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from orchestrator import plugins
from orchestrator.errors import FeedDriveError
from orchestrator.evaluation.plugin import of_plugin
from orchestrator.evaluation.schema import PluginMetric
from orchestrator.quantities.unit import unit_of

PACKAGE = {
    "feeddrive_example/__init__.py": "",
    "feeddrive_example/models/__init__.py": "",
    "feeddrive_example/models/lag.py": '''"""First-order lag of the example.

    T dy/dt = u - y

Source: the textbook.
"""

from typing import Annotated, NamedTuple

from fmus.model import Continuous, Var


class State(NamedTuple):
    y: Annotated[float, Var("V", "lagged signal")] = 0.0


class Input(NamedTuple):
    u: Annotated[float, Var("V", "signal")] = 1.0


class Output(NamedTuple):
    y: Annotated[float, Var("V", "lagged signal")]


class Parameters(NamedTuple):
    T: Annotated[float, Var("s", "time constant", min=1e-9)] = 0.01


def derivative(x: State, u: Input, p: Parameters) -> State:
    """Return the derivative of y."""
    return State((u.u - x.y) / p.T)


def output(x: State, u: Input, p: Parameters) -> Output:
    """Return y."""
    return Output(x.y)


model = Continuous("Lag", derivative, output, State(), Input(), Parameters())
''',
    "feeddrive_example/metrics.py": """
def reaches(time, values, unit, *, share):
    late = time[values >= share * values[-1]]
    return {"time": (late[0], "s"), "end": (values[-1], unit)}


def nothing(time, values, unit):
    return {}
""",
    "feeddrive_example/checks.py": """
from orchestrator.checks.item import advice, static


@static(100, "says who made it", "house rule 1", "name the author")
def author(archive):
    if not archive.description.fmu.author:
        yield advice("no author")
    yield "looked"
""",
    "feeddrive_example/peers.py": """
from pathlib import Path

from orchestrator.peers.environment import Peer

PEER = Peer("echo", ("pip",), "pip", str(Path(__file__).with_name("echo.py")))
""",
    "feeddrive_example/echo.py": """
def run(job):
    raise RuntimeError("echoes nothing")
""",
    "feeddrive_example/writers.py": """
def names(tables, target):
    target.write_text("\\n".join(n for table in tables.values() for n in table))
""",
    "feeddrive_example-1.dist-info/METADATA": (
        "Metadata-Version: 2.1\nName: feeddrive-example\nVersion: 1\n"
    ),
    "feeddrive_example-1.dist-info/entry_points.txt": """
[feeddrive.models]
example = feeddrive_example.models
[feeddrive.metrics]
reaches = feeddrive_example.metrics:reaches
nothing = feeddrive_example.metrics:nothing
[feeddrive.checks]
example = feeddrive_example.checks
[feeddrive.peers]
echo = feeddrive_example.peers:PEER
[feeddrive.writers]
.names = feeddrive_example.writers:names
""",
}
SCENARIO = """
stop = "0.1"
[components.lag]
fmu = "feeddrive_example.models.lag"
step = "1 ms"
[record]
"lag.y" = true
[metrics]
lag = { kind = "plugin", name = "reaches", of = "lag.y", arguments = { share = 0.5 } }
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that is on the path and holds the package as pip would lay it out."""
    folder = tmp_path_factory.mktemp("site") / "site-packages"
    for name, text in PACKAGE.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def feeddrive(
    installed: Path, folder: Path, *words: str
) -> subprocess.CompletedProcess[str]:
    code = (
        "import sys; sys.path.insert(0, sys.argv.pop(1));"
        "from orchestrator.cli import main; main()"
    )
    return subprocess.run(
        [sys.executable, "-c", code, str(installed), *words],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_its_model_metric_and_writer_serve_a_scenario(
    installed: Path, tmp_path: Path
) -> None:
    (tmp_path / "lag.toml").write_text(SCENARIO)
    done = feeddrive(installed, tmp_path, "run", "lag.toml", "--json")
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)["metrics"]
    assert figures["lag.time"]["value"] == pytest.approx(0.0069, abs=1e-3)
    assert figures["lag.end"]["unit"] == "V"
    done = feeddrive(installed, tmp_path, "export", "runs/lag/1", "-o", "x.names")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "x.names").read_text() == "lag.y"


def test_its_model_check_and_peer_are_listed(installed: Path, tmp_path: Path) -> None:
    done = feeddrive(
        installed, tmp_path, "build", "feeddrive_example.models.lag", "-o", "out"
    )
    assert done.returncode == 0, done.stderr
    (fmu,) = (tmp_path / "out").glob("*.fmu")
    done = feeddrive(installed, tmp_path, "check", str(fmu), "--only", "100", "--json")
    assert [item["number"] for item in json.loads(done.stdout)["items"]] == [100]
    (tmp_path / "lag.toml").write_text(SCENARIO)
    done = feeddrive(installed, tmp_path, "second-opinion", "lag.toml", "--tool", "no")
    assert "echo" in done.stderr


@pytest.mark.parametrize(
    ("name", "arguments", "words"),
    [
        ("reach", {"share": 0.5}, "did you mean 'reaches'"),
        ("reaches", {"part": 0.5}, "the metric reaches failed: TypeError"),
        ("nothing", {}, "instead of {figure: (value, unit)}"),
    ],
)
def test_what_does_not_fit_is_named(
    installed: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    arguments: dict[str, float],
    words: str,
) -> None:
    monkeypatch.syspath_prepend(installed)
    plugins.named.cache_clear()
    rows = np.linspace(0, 1, 5)

    def figures() -> object:
        spec = PluginMetric(of="a.y", kind="plugin", name=name, arguments=arguments)
        return of_plugin(spec, rows, rows, unit_of("V"))

    with pytest.raises((FeedDriveError, ValidationError)) as refused:
        figures()
    plugins.named.cache_clear()
    assert words in str(refused.value)
