"""Rows and columns of a value are those of the variable it is for."""

import pickle
from typing import NamedTuple

import numpy as np
import pytest
from systems import MODELS

from orchestrator.errors import WiringError
from orchestrator.scenario.compose import compose
from orchestrator.scenario.design import call
from orchestrator.scenario.reading import load_scenario
from orchestrator.scenario.written import in_lists, parse_setting, parse_value

ROWS = [[1, 2, 3], [4, 5, 6]]
HEAD = f"""
stop = "1/100"
[components.g]
fmu = "{(MODELS / "gains.py").as_posix()}"
map = {{ table = "K" }}
"""


def values(folder, fmi, override):
    file = folder / "rows.toml"
    file.write_text(HEAD)
    found = compose(load_scenario(file, [f"fmi={fmi}", override]), None)
    return found.system.components["g"].values


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", ["K", "table"])
def test_rows_of_the_variable_and_a_flat_list_are_taken(tmp_path, fmi, name):
    for written in (ROWS, [1, 2, 3, 4, 5, 6]):
        found = values(tmp_path, fmi, f"g.{name}={written}")
        assert found == {name: (1, 2, 3, 4, 5, 6)}


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    ("name", "written", "shapes"),
    [
        ("K", [[1, 2], [3, 4], [5, 6]], "it is 2 x 3, and 3 x 2 values"),
        ("table", [[1, 2], [3, 4], [5, 6]], "it is 2 x 3, and 3 x 2 values"),
        ("v", [[1, 2]], "it is 2, and 1 x 2 values"),
        ("k", [[1]], "no array of one shape, and 1 x 1 values"),
    ],
)
def test_rows_of_another_shape_are_not_read_row_by_row(
    tmp_path, fmi, name, written, shapes
):
    with pytest.raises(WiringError, match=f"{name}: .*{shapes}.*one flat list"):
        values(tmp_path, fmi, f"g.{name}={written}")


def test_what_a_design_returns_keeps_its_shape():
    class Found(NamedTuple):
        K: np.ndarray

    found = call(lambda: Found(np.array(ROWS).T), {})
    assert found["K"].shape == (3, 2)
    assert call(lambda: {"v": np.array([1.0, 2.0])}, {}) == {"v": (1.0, 2.0)}


@pytest.mark.parametrize("written", [1, [1, 2], ROWS, [[[1, 2]], [[3, 4]]]])
def test_a_value_is_read_back_in_its_shape(written):
    value = parse_value(written)
    assert in_lists(value) == written
    assert in_lists(pickle.loads(pickle.dumps(value))) == written


def test_texts_in_rows_have_a_shape_too():
    assert in_lists(parse_setting([["a", "b"], ["c", "d"]])) == [["a", "b"], ["c", "d"]]
