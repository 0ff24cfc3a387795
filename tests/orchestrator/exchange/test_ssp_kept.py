"""What was imported stands alone, and goes out again as it came in."""

from pathlib import Path

from packages import (
    annotated,
    binding,
    component,
    experiment,
    package,
    parameter_set,
    ssd,
)
from small_packages import KINDS, STEP, elements

from orchestrator.exchange.ssp.beside import write_beside
from orchestrator.exchange.ssp.load import load_package
from orchestrator.exchange.ssp.write import export_ssp
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run, run_earlier


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
