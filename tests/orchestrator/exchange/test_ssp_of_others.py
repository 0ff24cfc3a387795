"""Parameters of packages that other tools write: their units, their items."""

from pathlib import Path
from typing import Any

import pytest
from packages import (
    binding,
    component,
    connectors,
    experiment,
    mapping,
    package,
    parameter_set,
    ssd,
    unit,
)
from rewritten import rewritten
from small_packages import KINDS, PLAIN, STEP, elements, values
from stub import Stub, library, stub

from orchestrator.errors import ScenarioError

MM = unit("mm", 'm="1" factor="0.001"', "ssv")
FIVE = parameter_set('k Real value="5" unit="mm"').replace(
    "</ssv:Parameters>", f"</ssv:Parameters>{MM}"
)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return library(tmp_path_factory.mktemp("stub"))


def written(folder: Path, fmu: Path, inside: str, of_system: str = "") -> Path:
    """Write a package of one component ``a``, whose parameter is ``k``."""
    units = unit("m", 'm="1"')
    text = ssd(
        elements(component("a", "r.fmu", inside)) + of_system,
        units + experiment(annotations=STEP),
    )
    return package(folder / "a.ssp", {"SystemStructure.ssd": text, "r.fmu": fmu})


PLACES = {
    "its component": (binding(FIVE), ""),
    "the system": ("", binding(FIVE.replace('name="k"', 'name="a.k"'))),
    "a mapping": (
        binding(FIVE.replace('name="k"', 'name="p"'), maps=mapping("p k")),
        "",
    ),
}


@pytest.mark.parametrize("place", PLACES)
def test_a_parameter_comes_in_the_unit_of_its_connector_where_the_fmu_says_none(
    compiled: Path, tmp_path: Path, place: str
) -> None:
    fmu = stub(compiled, tmp_path / "r.fmu", PLAIN)
    kinds = connectors(k="parameter [m]", y="output")
    inside, of_system = PLACES[place]
    file = written(tmp_path, fmu, kinds + inside, of_system)
    assert values(file, tmp_path / "run", "a.y") == [0.005]


def test_a_connector_of_a_parameter_that_contradicts_its_fmu_is_refused(
    compiled: Path, tmp_path: Path
) -> None:
    fmu = stub(
        compiled, tmp_path / "r.fmu", PLAIN | {"k": Stub("parameter", unit="mm")}
    )
    kinds = connectors(k="parameter [m]", y="output")
    with pytest.raises(ScenarioError, match="the connector says m, the FMU mm"):
        values(written(tmp_path, fmu, kinds + binding(FIVE)), tmp_path / "run", "a.y")


@pytest.mark.parametrize("own", ["", "foo"])
def test_a_unit_that_leads_nowhere_is_told_of(
    compiled: Path, tmp_path: Path, own: str, caplog: pytest.LogCaptureFixture
) -> None:
    fmu = stub(compiled, tmp_path / "r.fmu", PLAIN | {"k": Stub("parameter", unit=own)})
    file = written(tmp_path, fmu, KINDS + binding(FIVE))
    assert values(file, tmp_path / "run", "a.y") == [5.0]
    assert "a.k: given in mm" in caplog.text


def test_an_item_whose_name_is_a_number_is_taken_by_its_name(
    compiled: Path, tmp_path: Path
) -> None:
    def numbered(root: Any) -> None:
        for name, item in zip(("1", "4"), root.iterfind(".//Item"), strict=True):
            item.set("name", {"1": "4", "4": "1"}[name])

    kinds = {"k": ("parameter", "1"), "y": ("output", "0")}
    variables = {n: Stub(c, "Enumeration", start=v) for n, (c, v) in kinds.items()}
    fmu = stub(compiled, tmp_path / "s.fmu", variables)
    fmu = rewritten(fmu, tmp_path, numbered)
    given = binding(parameter_set('k Enumeration value="4"'))
    file = written(tmp_path, fmu, connectors(y="output") + given)
    assert values(file, tmp_path / "run", "a.y") == [1.0]
