"""What was imported stands alone, and goes out again as it came in."""

from pathlib import Path

import pytest
from packages import (
    annotated,
    binding,
    component,
    connectors,
    experiment,
    package,
    parameter_set,
    ssd,
)
from stub import Stub, library, stub

from orchestrator.exchange.ssp.beside import write_beside
from orchestrator.exchange.ssp.load import load_package
from orchestrator.exchange.ssp.write import export_ssp
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run, run_earlier

OSP = "com.opensimulationplatform"
STEP = annotated(
    OSP,
    '<osp:Algorithm xmlns:osp="x"><osp:FixedStepAlgorithm baseStepSize="1e-3"/>'
    "</osp:Algorithm>",
)
PLAIN = {"u": Stub("input"), "k": Stub("parameter"), "y": Stub("output")}
KINDS = connectors(u="input", k="parameter", y="output")


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return library(tmp_path_factory.mktemp("stub"))


@pytest.fixture(scope="module")
def plain(compiled: Path) -> Path:
    """An FMU with y = u + k, of no units, that proposes a step of 2 ms."""
    return stub(compiled, compiled.parent / "plain.fmu", PLAIN, step="0.002")


def values(file: Path, folder: Path, *names: str, sets: tuple[str, ...] = ()) -> list:
    """Return the last recorded values of outputs."""
    done = run(load_package(file, sets), folder, report=False)
    return [float(done[name].values[-1]) for name in names]


def elements(*text: str) -> str:
    return f"<ssd:Elements>{''.join(text)}</ssd:Elements>"


def test_an_imported_folder_runs_without_the_package(
    plain: Path, tmp_path: Path
) -> None:
    parts = elements(
        component(
            "my part",
            "my%20fmus/r.fmu",
            KINDS + binding(parameter_set('k Real value="2"')),
        )
    )
    file = package(
        tmp_path / "a.ssp",
        {
            "SystemStructure.ssd": ssd(parts, experiment(annotations=STEP)),
            "my fmus/r.fmu": plain,
        },
    )
    written = write_beside(file, tmp_path / "new")
    file.unlink()
    done = run(written, tmp_path / "run", report=False)
    assert float(done["my_part.y"].values[-1]) == 2


def test_what_we_do_not_know_is_kept_as_long_as_nothing_is_changed(
    plain: Path, tmp_path: Path
) -> None:
    unknown = annotated("com.example", '<x:Colour xmlns:x="x" red="1"/>')
    geometry = '<ssd:ElementGeometry x1="0" y1="0" x2="9" y2="9"/>'
    parts = elements(component("a", "r.fmu", KINDS + geometry + unknown))
    text = ssd(parts, experiment(annotations=STEP))
    members = {"SystemStructure.ssd": text, "r.fmu": plain, "extra/notes.txt": "mine"}
    file = package(tmp_path / "a.ssp", members)
    written = write_beside(file, tmp_path / "new")
    again = tmp_path / "again.ssp"
    export_ssp(compose(load_scenario(written), run_earlier), again)
    assert again.read_bytes() == file.read_bytes()
    changed = load_scenario(written, ["a.k=3"])
    export_ssp(compose(changed, run_earlier), again)
    assert load_package(again).spec.components["a"].parameters == {"k": 3}
