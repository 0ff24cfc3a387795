"""parameters, start and --set are one table of values, in which the last holds."""

from pathlib import Path
from typing import Any

import pytest
from systems import MODELS

from orchestrator.errors import ScenarioError
from orchestrator.result import Result
from orchestrator.scenario.compose import compose
from orchestrator.scenario.lock import locked
from orchestrator.scenario.reading import load_scenario

BASE = f"""
stop = "1/100"
[components.a]
fmu = "{MODELS / "counter.py"}"
step = "1/1000"
parameters = {{ gain = 2 }}
start = {{ "state.k" = 5, u = 1 }}
[record]
"a.seen" = true
"""


def values(folder: Path, text: str = "", *overrides: str) -> tuple[Any, Any]:
    """Return both tables of the lock of a scenario that inherits from BASE."""
    (folder / "base.toml").write_text(BASE)
    file = folder / "heir.toml"
    file.write_text('base = "base.toml"\n' + text)

    def no_run(name: str) -> Result:
        raise AssertionError(name)

    found = locked(compose(load_scenario(file, overrides), no_run))["components"]["a"]
    return found.get("parameters", {}), found.get("start", {})


def test_set_replaces_what_the_file_has_under_start(tmp_path: Path) -> None:
    parameters, start = values(tmp_path, "", "a.u=0.1", "a.state.k=7", "a.gain=3")
    assert parameters == {"gain": 3, "u": 0.1}
    assert start == {"state.k": 7}


def test_an_heir_replaces_what_its_base_has_in_the_other_table(tmp_path: Path) -> None:
    heir = "[components.a]\nparameters = { u = 4 }\nstart = { gain = 6 }\n"
    parameters, start = values(tmp_path, heir)
    assert parameters == {"u": 4}
    assert start == {"gain": 6, "state.k": 5}


def test_a_constant_on_a_connection_is_the_last_value_of_its_input(
    tmp_path: Path,
) -> None:
    parameters, start = values(tmp_path, '[connections]\n"a.u" = 9\n')
    assert (parameters, start) == ({"gain": 2}, {"state.k": 5, "u": 9})


def test_one_name_in_both_tables_of_one_file_is_refused(tmp_path: Path) -> None:
    both = "[components.a]\nparameters = { u = 4 }\nstart = { u = 6 }\n"
    with pytest.raises(
        ScenarioError, match="u stands under parameters and under start"
    ):
        values(tmp_path, both)


def test_whole_numbers_stay_whole_in_the_lock(tmp_path: Path) -> None:
    heir = f"[components.a]\nparameters = {{ gain = {2**60 + 1} }}\n"
    parameters, _ = values(tmp_path, heir)
    assert parameters["gain"] == 2**60 + 1
