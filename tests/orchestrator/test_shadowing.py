"""Folders of the user's that bear our packages' names do not break ours."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

NAMES = ("controllers", "plants", "fmus", "orchestrator")
COMMAND = Path(sys.executable).with_name("feeddrive")
SCENARIO = """
stop = "1/100"
[components.plant]
fmu = "plants.xy_table.axis"
step = "1/1000"
[components.controller]
fmu = "controllers.xy_table.speed_pi"
step = "1/1000"
[record]
"plant.y" = true
[metrics]
x = { kind = "peak", of = "plant.y" }
[expect]
"x.peak" = { below = 1 }
"""
OWN_MODEL = """
from typing import Annotated, NamedTuple
from fmus.model import Sampled, Var
class State(NamedTuple):
    k: Annotated[float, Var("1", "ticks")] = 0.0
class Output(NamedTuple):
    y: Annotated[float, Var("1", "ticks so far")]
class Nothing(NamedTuple):
    pass
def step(x, u, p, T_s):
    return State(x.k + 1), Output(x.k)
model = Sampled("Mine", step, State(), Nothing(), Nothing())
"""


@pytest.fixture
def project(tmp_path):
    """A project with four packages of our names, a model and a scenario."""
    for name in NAMES:
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("MINE = True\n")
    (tmp_path / "plants" / "mine.py").write_text(OWN_MODEL)
    (tmp_path / "loop.toml").write_text(SCENARIO)
    return tmp_path


def python(project, *arguments):
    env = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST")}
    return subprocess.run(
        [str(a) for a in arguments],
        cwd=project,
        env=env,
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_command_builds_ours_and_the_users_by_its_file(project):
    done = python(project, COMMAND, "run", "loop.toml", "--json")
    assert done.returncode == 0, done.stderr
    done = python(project, COMMAND, "build", "plants/mine.py", "-o", "out")
    assert done.returncode == 0, done.stderr
    done = python(project, COMMAND, "build", "plants.mine", "-o", "out")
    assert done.returncode == 2
    assert "by the path of its .py file" in " ".join(done.stderr.split())


def test_a_script_has_its_own_packages_and_our_models(project):
    for name in ("fmus", "orchestrator"):  # these Python itself would take first
        (project / name / "__init__.py").unlink()
    (project / "script.py").write_text(
        "import controllers\n"
        "from orchestrator import load_scenario, run\n"
        "result = run(load_scenario('loop.toml'), 'out')\n"
        "import controllers as again, plants\n"
        "print(controllers.MINE, again is controllers, plants.MINE)\n"
    )
    done = python(project, sys.executable, "script.py")
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["True", "True", "True"]


def test_where_python_took_another_fmus_one_error_says_so(project):
    (project / "orchestrator" / "__init__.py").unlink()
    (project / "script.py").write_text("import fmus\nimport orchestrator\n")
    done = python(project, sys.executable, "script.py")
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("ImportError: feeddrive needs its own package fmus")
    assert str(project / "fmus") in last
    assert "rename that folder" in last


def test_a_script_beside_a_folder_fmus_imports_orchestrator_first(project):
    (project / "orchestrator" / "__init__.py").unlink()
    (project / "script.py").write_text(
        "from orchestrator import load_scenario, run\n"
        "run(load_scenario('loop.toml'), 'out')\n"
    )
    done = python(project, sys.executable, "script.py")
    assert done.returncode == 0, done.stderr


def test_pytest_collects_and_runs_scenarios_beside_them(project):
    (project / "conftest.py").write_text("import controllers, plants\n")
    (project / "test_mine.py").write_text(
        "import controllers\n"
        "def test_mine(build_fmu):\n"
        "    assert controllers.MINE\n"
        "    assert build_fmu('controllers.xy_table.speed_pi').is_file()\n"
    )
    done = python(project, sys.executable, "-P", "-m", "pytest", "-q", "-p", "no:xdist")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 passed" in done.stdout


def test_an_fmu_in_a_process_of_its_own_finds_our_packages(project):
    text = SCENARIO.replace(
        "[components.controller]\n", '[components.controller]\nisolation = "process"\n'
    )
    (project / "loop.toml").write_text(text)
    done = python(project, COMMAND, "run", "loop.toml", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)
