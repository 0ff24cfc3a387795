"""Tables of a source: from rows, columns and rules to figures and their layout."""

import tomllib

import pytest

from orchestrator.reproduction.table import TableError, expand

KNOWN = {"id", "where", "published", "expected", "tolerance", "unit", "set", "why"}
KNOWN |= {"scenario", "arguments", "with", "class"}
TABLE = """
title = "Step response"
where = "Table 5-2"
id = "step.{height}.{q}.{c}@{ours}"

set = ["reference.height={h}"]
class = "derived"
tolerance = 0.1
columns = [
  { name = "C1", c = "c1", height = "1mm", h = "1e-3" },
  { name = "C2", c = "c2", height = "1mm", h = "1e-3", arguments = { K = "{K}" } },
]
rows = [
  { name = "rise", q = "rise", K = 2, unit = "s", published = [0.1, ""] },
  { name = "overshoot", q = "over", K = 3, published = ["-", { below = 1 }] },
]
ours = [
  { name = "cal", scenario = "step_cal", expected = [[0.11, 0.2], [1, ""]] },
  { name = "tab", scenario = "step", set = ["stop=1"] },
]
[except."step.1mm.rise.c2@tab"]
class = "calibrated"
"""


def expanded(text=TABLE):
    return expand(tomllib.loads(text), KNOWN)


def test_each_cell_is_a_figure_per_way_of_ours_in_the_layout_of_the_source():
    table, figures = expanded()
    assert table.columns == ("C1", "C2")
    assert table.rows == ("rise", "overshoot")
    assert table.ids[0][1] == ("step.1mm.rise.c2@cal", "step.1mm.rise.c2@tab")
    assert table.ids[1][0] == (None, None)  # "-": the source has no such cell
    assert [figure["id"] for figure in figures] == [
        name for row in table.ids for cell in row for name in cell if name
    ]


def test_keys_come_from_table_row_column_and_way_and_set_adds_up():
    _, figures = expanded()
    rows = {figure["id"]: figure for figure in figures}
    assert rows["step.1mm.rise.c1@cal"] == {
        "id": "step.1mm.rise.c1@cal",
        "where": "Table 5-2",
        "scenario": "step_cal",
        "set": ["reference.height=1e-3"],
        "class": "derived",
        "unit": "s",
        "published": 0.1,
        "expected": 0.11,
        "tolerance": 0.1,
    }
    other = rows["step.1mm.rise.c2@tab"]
    assert other["set"] == ["reference.height=1e-3", "stop=1"]
    assert other["arguments"] == {"K": 2}  # a text that is one {key} takes its value
    assert other["class"] == "calibrated"
    assert not {"published", "expected", "tolerance"} & other.keys()
    assert rows["step.1mm.over.c2@cal"]["published"] == {"below": 1}
    assert "tolerance" not in rows["step.1mm.over.c2@cal"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('K = 2, unit = "s"', 'unit = "s"', "{K}?"),
        ('name = "C1", c = "c1"', 'name = "C1", c = "c1", d = 1', "'d': nothing uses"),
        ('[0.1, ""]', "[0.1]", "published has 1 values for 2"),
        ('[1, ""]]', '[1, ""], [2, 3]]', "expected has 3 values"),
        ('"step.1mm.rise.c2@tab"]', '"step.2mm"]', "no figure 'step.2mm'"),
        ("tolerance = 0.1", "tolerence = 0.1", "'tolerance'"),
        ("rows = [", "rowes = [", "'rows'"),
    ],
)
def test_a_wrong_table_is_named_with_a_remedy(old, new, told):
    assert old in TABLE
    with pytest.raises(TableError, match="Step response") as refusal:
        expanded(TABLE.replace(old, new))
    assert told in str(refusal.value)
