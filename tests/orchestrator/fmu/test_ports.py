"""What a name stands for: elements by index, fields, aliases; and what it does not."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from foreign import foreign
from stub import Stub, library, stub
from systems import system

from orchestrator.errors import WiringError
from orchestrator.master.simulate import plan, simulate
from orchestrator.system import Component, Fault, Value

ORDERS = {  # of a 2 x 3 array, as it may be listed
    "by row": ["1,1", "1,2", "1,3", "2,1", "2,2", "2,3"],
    "by column": ["1,1", "2,1", "1,2", "2,2", "1,3", "2,3"],
    "with spaces": ["2, 3", "1, 1", "1, 2", "2, 1", "1, 3", "2, 2"],
    "one by one": ["2][1", "1][1", "1][3", "1][2", "2][2", "2][3"],
}


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return library(tmp_path_factory.mktemp("stub"))


def listed(compiled: Path, folder: Path, labels: list[str]) -> Path:
    """Write an FMU whose outputs ``y{label}`` are its parameters ``k{label}``."""
    kinds = {"k": "parameter", "y": "output"}
    variables = {f"{n}{at}": Stub(kinds[n]) for n in kinds for at in labels}
    return stub(compiled, folder / "a.fmu", variables)


def given(fmu: Path, labels: list[str], k: Value, folder: Path) -> list[float]:
    """Return the outputs, by label, of a run with a value of ``k``."""
    a = Component("a", fmu, Fraction(1), parameters={"k": k})
    rows = {f"a.y{at}": "1" for at in labels}
    found = simulate(system("1", [a], {}, rows), folder)
    return [found[name].values[-1] for name in rows]


@pytest.mark.parametrize("order", ORDERS)
def test_values_go_by_index_in_whatever_order_an_fmu_lists_its_elements(
    compiled: Path, tmp_path: Path, order: str
) -> None:
    labels = [f"[{at}]" for at in ORDERS[order]]
    fmu = listed(compiled, tmp_path, labels)
    numbers = given(fmu, sorted(labels), (11, 12, 13, 21, 22, 23), tmp_path)
    assert numbers == [11, 12, 13, 21, 22, 23]


def test_of_more_than_nine_elements_the_tenth_is_not_the_second(
    compiled: Path, tmp_path: Path
) -> None:
    labels = [f"[{i}]" for i in range(1, 13)]
    fmu = listed(compiled, tmp_path, sorted(labels))  # [1], [10], [11], [12], [2], ...
    assert given(fmu, labels, tuple(range(1, 13)), tmp_path) == list(range(1, 13))


NO_ARRAY = {
    "fields": [".p", ".q"],
    "a gap": ["[1]", "[3]"],
    "a beginning lost": ["[2]", "[3]"],
    "two ranks": ["[1]", "[1,1]"],
    "elements with fields": ["[1].p", "[2].p"],
}


@pytest.mark.parametrize("case", NO_ARRAY)
def test_a_list_of_values_is_refused_where_positions_say_nothing(
    compiled: Path, tmp_path: Path, case: str
) -> None:
    fmu = listed(compiled, tmp_path, NO_ARRAY[case])
    a = Component("a", fmu, Fraction(1), parameters={"k": (1.0, 2.0)})
    with pytest.raises(WiringError, match="give each value by its name"):
        plan(system("1", [a], {}, {}))


NO_ELEMENT = ("[0]", "[3]", "[1,1]", "[-1]", "[01]", "[]")


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> list[Component]:
    fmu = foreign(3, tmp_path_factory.mktemp("two"))
    return [Component(name, fmu, Fraction(1)) for name in "ab"]


@pytest.mark.parametrize("index", NO_ELEMENT)
@pytest.mark.parametrize("place", ["record", "sink", "source", "fault", "value"])
def test_an_element_that_an_array_has_not_is_refused_wherever_it_is_named(
    two: list[Component], index: str, place: str
) -> None:
    sink, source, start = "b.in_two[1]", "a.out_two[1]", {}
    record: dict[str, str] = {}
    faults: dict[str, tuple[Fault, ...]] = {}
    if place == "record":
        record = {f"b.out_two{index}": "1"}
    elif place == "sink":
        sink = f"b.in_two{index}"
    elif place == "source":
        source = f"a.out_two{index}"
    elif place == "fault":
        faults = {f"b.in_two{index}": (Fault("override", 99.0),)}
    else:
        start = {f"in_two{index}": 1.0}
    a, b = two
    whole = system("1", [a, replace(b, start=start)], {sink: source}, record)
    with pytest.raises(WiringError, match=r"whose elements are \[1\] to \[2\]"):
        plan(replace(whole, faults=faults))
