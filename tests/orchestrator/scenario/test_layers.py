"""Of every number of an FMU the value that is said last holds, by whatever name."""

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from systems import MODELS

from orchestrator.analysis.members import split
from orchestrator.errors import ScenarioError, WiringError
from orchestrator.evaluation.metrics import evaluate
from orchestrator.result import Result, Signal
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.lock import locked
from orchestrator.scenario.reading import load_scenario

HEAD = f"""
stop = "1/100"
fmi = 3
[components.g]
fmu = "{(MODELS / "gains.py").as_posix()}"
"""
K = "K = [[1, 2, 3], [4, 5, 6]]"
CONSTANT = f'{HEAD}parameters = {{ v = [7, 8] }}\n[connections]\n"g.u" = 3.0\n'
MAPPED = f'{HEAD}map = {{ kk = {{ name = "k", unit = "N/mm" }} }}\n'


def composed(folder: Path, text: str, *overrides: str, heir: str = "") -> Composition:
    """Return the composition of a scenario, or of an heir of it."""
    file = folder / "base.toml"
    file.write_text(text)
    if heir:
        file = folder / "heir.toml"
        file.write_text('base = "base.toml"\n' + heir)

    def no_run(name: str) -> Result:
        raise AssertionError(name)

    return compose(load_scenario(file, overrides), no_run)


def values(found: Composition) -> dict[str, Any]:
    return dict(found.system.components["g"].values)


@pytest.mark.parametrize(
    ("overrides", "u"),
    [
        ((), 3.0),
        (("g.u=5",), 5),
        (("g.start.u=5",), 5),
        (("g.u=5", "connections.g.u=4"), 4),
        (("connections.g.u=4", "g.u=5"), 5),
    ],
)
def test_set_lies_over_a_constant_of_a_connection_and_the_last_set_holds(
    tmp_path, overrides, u
):
    assert values(composed(tmp_path, CONSTANT, *overrides))["u"] == u


def test_set_lies_over_a_constant_that_a_star_gives(tmp_path):
    star = f'{HEAD}[connections]\n"g.u*" = 3.0\n'
    assert values(composed(tmp_path, star))["u"] == 3
    assert values(composed(tmp_path, star, "g.u=5"))["u"] == 5
    assert values(composed(tmp_path, star, "g.u=5", "connections.g.u*=4"))["u"] == 4


def test_a_sweep_and_a_lock_have_the_value_that_a_run_has(tmp_path):
    found = composed(tmp_path, CONSTANT, "g.u=5")
    assert locked(found)["components"]["g"]["parameters"] == {"v": [7, 8], "u": 5}
    given, sets = split(found, {"g.u": 6.0})
    assert sets == ()
    assert values(found.with_values(given))["u"] == 6


def test_a_value_of_the_file_under_a_constant_is_said_to_have_no_effect(tmp_path):
    text = CONSTANT.replace("v = [7, 8]", "u = 4")
    found = composed(tmp_path, text)
    assert values(found)["u"] == 3
    assert "g.u is set, but the constant connections.g.u = 3.0 holds" in str(
        found.warnings
    )
    assert composed(tmp_path, text, "g.u=5").warnings == ()


def test_an_element_of_an_array_that_is_set_whole_has_the_value_that_is_set(tmp_path):
    found = composed(tmp_path, CONSTANT)
    assert found.parameter("g.v[1]").value == 7
    element = composed(tmp_path, f'{HEAD}parameters = {{ "v[1]" = 9 }}\n')
    assert element._values[0].value("g.v") == (9, 2)


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_design_is_told_what_the_scenario_sets_by_another_name(
    tmp_path, monkeypatch, fmi
):
    told = {}

    def design(**given: Any) -> dict[str, Any]:
        told.update(given)
        return {"k": 4.0}

    module = ModuleType("some_layers")
    module.design = design  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "some_layers", module)
    text = f"""{CONSTANT.replace("fmi = 3", f"fmi = {fmi}")}
[design.x]
call = "some_layers:design"
arguments = {{ v_1 = "g.v[1]", v = "g.v", u = "g.u" }}
sets = "g"
"""
    found = composed(tmp_path, text, "g.u=5", "g.v=[1, 2]")
    assert (told["v_1"], told["u"]) == (7, 3)  # as the file stands
    assert np.array_equal(told["v"], [7, 8])
    assert values(found) == {"k": 4.0, "v": (1, 2), "u": 5}


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_a_whole_that_is_set_last_takes_the_place_of_its_elements(tmp_path, fmi):
    text = f"{HEAD}parameters = {{ {K} }}\n"
    whole = "g.K=[10, 20, 30, 40, 50, 60]"
    last = composed(tmp_path, text, f"fmi={fmi}", whole, "g.K[1,2]=99", whole)
    assert values(last) == {"K": (10, 20, 30, 40, 50, 60)}
    element = composed(tmp_path, text, f"fmi={fmi}", "g.K[1,2]=99")
    assert element._values[0].value("g.K") == (1, 99, 3, 4, 5, 6)


@pytest.mark.parametrize("table", ["parameters", "start"])
def test_a_whole_of_an_heir_lies_over_an_element_of_its_base(tmp_path, table):
    base = f'{HEAD}parameters = {{ v = [5, 6] }}\nstart = {{ "v[2]" = 9 }}\n'
    assert composed(tmp_path, base)._values[0].value("g.v") == (5, 9)
    heir = f"[components.g]\n{table} = {{ v = [3, 4] }}\n"
    found = composed(tmp_path, base, heir=heir)
    assert found._values[0].value("g.v") == (3, 4)
    assert values(found) == {"v": (3, 4)}


def test_a_member_of_a_sweep_is_judged_with_its_value_by_any_name(tmp_path):
    metric = '[record]\n"g.y" = true\n[metrics]\nm = { kind = "final", of = "g.y", '
    found = composed(tmp_path, f'{MAPPED}{metric}scale = "g.kk" }}\n')
    member = found.with_values({"g": {"k": 5000.0}})
    one = Signal("g.y", np.array([0.0, 1.0]), np.array([2.0, 2.0]), "m")
    figures = evaluate(
        found.scenario.spec.metrics, {"g.y": one}, member.parameter, None
    )
    assert figures["m.final"].value == pytest.approx(10)
    assert figures["m.final"].unit == "m.N/mm"


def test_two_names_of_one_number_are_not_both_set(tmp_path):
    with pytest.raises(ScenarioError, match=r"k and kk are both set.*remove one"):
        composed(tmp_path, MAPPED + 'parameters = { k = 5, kk = "3 N/mm" }\n')


def test_two_constants_of_one_input_are_refused(tmp_path):
    text = f'{HEAD}map = {{ a = {{ name = "u", gain = 2 }} }}\n[connections]\n'
    with pytest.raises(ScenarioError, match="u and a are both set"):
        composed(tmp_path, text + '"g.u" = 1.0\n"g.a" = 2.0\n')


def test_set_by_another_name_takes_the_place_of_what_the_file_says(tmp_path):
    text = MAPPED + "parameters = { k = 5 }\n"
    found = composed(tmp_path, text, "g.kk=3")
    assert values(found) == {"kk": 3}
    assert found.parameter("g.k").value == pytest.approx(3000)
    assert values(composed(tmp_path, text, "g.kk=3", "g.k=7")) == {"k": 7}


SWITCH = f'{HEAD}[connections]\n"g.on" = false\n'


def test_false_on_a_connection_is_the_constant_where_nothing_is_inherited(tmp_path):
    assert values(composed(tmp_path, SWITCH)) == {"on": False}
    heir = '[connections]\n"g.on" = false\n'
    assert values(composed(tmp_path, HEAD, heir=heir)) == {"on": False}


def test_false_over_an_inherited_switch_is_its_value_and_not_its_end(tmp_path):
    heir = '[connections]\n"g.on" = false\n'
    for inherited in ("true", "false"):
        base = f'{HEAD}[connections]\n"g.on" = {inherited}\n'
        assert values(composed(tmp_path, base, heir=heir)) == {"on": False}
        set_ = composed(tmp_path, base, "connections.g.on=false")
        assert values(set_) == {"on": False}


def test_false_removes_an_inherited_constant_and_is_no_number(tmp_path):
    heir = '[connections]\n"g.u" = false\n'
    assert "u" not in values(composed(tmp_path, CONSTANT, heir=heir))
    with pytest.raises(
        WiringError, match=r"u = false: g\.u is a Float64 and no switch"
    ):
        composed(tmp_path, HEAD + heir)


def test_a_switch_goes_with_the_component_that_an_heir_removes(tmp_path):
    other = HEAD.partition("[components.g]")[2]
    heir = f"[components]\ng = false\n[components.h]{other}[connections]\n"
    heir += '"g.on" = false\n'
    found = composed(tmp_path, SWITCH.replace("false", "true"), heir=heir)
    assert list(found.system.components) == ["h"]
