"""Reference results in an FMU (FMI-LS-REF) are found, and computed once more."""

import csv
import hashlib
import io
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

from fmus.build import build
from orchestrator.checks import check_fmu
from orchestrator.checks.item import Finding

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
STEP, STOP = 1 / 2000, 1 / 50
MASS = 0.8  # kg, not the default
EXPERIMENT = (
    f'<Experiment name="push" stopTime="{STOP}" stepSize="{STEP}">'
    '<Parameters source="heavy.ssv"/><Stimuli source="in.csv"/>'
    '<References source="out.csv"/></Experiment>'
)
SSV = (
    '<ParameterSet xmlns="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
    'version="1.0" name="heavy"><Parameters><Parameter name="m_x">'
    f'<Real value="{MASS}"/></Parameter></Parameters></ParameterSet>'
)


def related(source: str, role: str, kind: str = "", more: str = "") -> str:
    text = f' type="{kind}"' if kind else ""
    return f'<Related source="{source}" role="{role}"{text} {more}/>'


def manifest(content: str) -> str:
    return (
        '<fmiReferences xmlns:ls="http://fmi-standard.org/fmi-ls-manifest" '
        'ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref" ls:fmi-ls-version="1.0.0-alpha.1"'
        ' ls:fmi-ls-description="Layered Standard providing information on related '
        f'files included in an FMU.">{content}</fmiReferences>'
    )


def table(columns: dict[str, np.ndarray]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, quoting=csv.QUOTE_NONNUMERIC)
    writer.writerow(columns)
    writer.writerows(zip(*(c.tolist() for c in columns.values()), strict=True))
    return text.getvalue()


def stimuli() -> np.ndarray:
    times = np.arange(0, STOP + STEP / 2, STEP)
    pairs = list(zip(times, np.sin(300 * times), strict=True))
    return np.array(pairs, [("time", float), ("u", float)])


def results(fmu: Path, mass: float, pushed: bool = True) -> dict[str, np.ndarray]:
    result = fmpy.simulate_fmu(
        str(fmu),
        validate=False,
        fmi_type="CoSimulation",
        stop_time=STOP,
        output_interval=STEP,
        start_values={"m_x": mass},
        input=stimuli() if pushed else None,
        output=["x", "v"],
    )
    return {name: result[name] for name in ("time", "x", "v")}


def packed(folder: Path, fmu: Path, files: dict[str, str]) -> Path:
    """Write an FMU again with these files of the layered standard alone."""
    target = folder / "referenced.fmu"
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w") as archive:
        for name in old.namelist():
            if not name.startswith(FOLDER):
                archive.writestr(name, old.read(name))
        for name, text in files.items():
            archive.writestr(f"{FOLDER}/{name}", text)
    return target


def pushed(folder: Path, fmi: int, out: dict[str, np.ndarray] | None = None) -> Path:
    """Pack an experiment with parameters, stimuli and results."""
    fmu = build("plants.gantry.x_axis", fmi=fmi)  # type: ignore[arg-type]
    u = stimuli()
    files = {
        "fmi-ls-manifest.xml": manifest(related("tests.exp", "experiment/smoke-test")),
        "tests.exp": f'<Experiments name="tests">{EXPERIMENT}</Experiments>',
        "in.csv": table({name: u[name] for name in ("time", "u")}),
        "out.csv": table(out or results(fmu, MASS)),
        "heavy.ssv": SSV,
    }
    return packed(folder, fmu, files)


def found(fmu: Path, part: str) -> list[Finding]:
    report = check_fmu(fmu, only=[33], dynamic=part == "dynamic")
    (outcome,) = [o for o in report.outcomes if o.item.part == part]
    assert outcome.verdict in ("pass", "finding"), outcome.reason
    return outcome.findings


@pytest.mark.parametrize("fmi", [2, 3])
def test_results_that_the_fmu_computes_pass(tmp_path: Path, fmi: int) -> None:
    fmu = pushed(tmp_path, fmi)
    assert found(fmu, "static") == []
    report = check_fmu(fmu, only=[33])
    assert [o.findings for o in report.outcomes] == [[], []]
    assert report.outcomes[1].seen == ["push: 2 columns, 41 of 41 rows"]


def test_results_of_another_mass_are_found(tmp_path: Path) -> None:
    other = results(build("plants.gantry.x_axis"), 0.69)
    (x, v) = found(pushed(tmp_path, 2, other), "dynamic")
    assert x.text.startswith("push: x differs from the reference in")
    assert v.severity == "error"


def test_results_of_a_step_later_are_found(tmp_path: Path) -> None:
    later = results(build("plants.gantry.x_axis"), MASS)
    later["x"] = np.roll(later["x"], 1)
    later["x"][0] = 0
    (x,) = found(pushed(tmp_path, 2, later), "dynamic")
    assert "x differs" in x.text


def test_one_sample_of_a_jump_may_fall_to_its_neighbour(tmp_path: Path) -> None:
    jumped = results(build("plants.gantry.x_axis"), MASS)
    jumped["v"][20] = jumped["v"][21]
    assert found(pushed(tmp_path, 2, jumped), "dynamic") == []


def test_the_first_draft_with_experiments_in_the_manifest_is_read(
    tmp_path: Path,
) -> None:
    fmu = build("plants.gantry.x_axis")
    u = stimuli()
    files = {
        "fmi-ls-manifest.xml": manifest(EXPERIMENT),
        "in.csv": table({"time": u["time"], "u": 2 * u["u"]}),
        "out.csv": table(results(fmu, MASS)),
        "heavy.ssv": SSV,
    }
    assert "push: x differs" in found(packed(tmp_path, fmu, files), "dynamic")[0].text


def test_results_of_the_default_experiment_are_advice(tmp_path: Path) -> None:
    """As the Reference FMUs have them; nothing says which experiment it was."""
    fmu = build("plants.gantry.x_axis")
    out = results(fmu, 0.69, pushed=False)
    files = {
        "fmi-ls-manifest.xml": manifest(related("out.csv", "result", "text/csv")),
        "out.csv": table(out),
    }
    assert found(packed(tmp_path, fmu, files), "dynamic") == []
    files["out.csv"] = table(out | {"x": out["x"] + 1e-3})
    (x,) = found(packed(tmp_path, fmu, files), "dynamic")
    assert x.severity == "advice"
    assert "default experiment (out.csv): x differs" in x.text


def test_a_table_of_no_numbers_is_a_finding(tmp_path: Path) -> None:
    fmu = build("plants.gantry.x_axis")
    files = {
        "fmi-ls-manifest.xml": manifest(related("out.csv", "result", "text/csv")),
        "out.csv": '"t","x"\n0,1\n1,2\n',
    }
    (only,) = found(packed(tmp_path, fmu, files), "dynamic")
    assert "has no column time" in only.text


def test_files_that_are_not_as_told_are_found(tmp_path: Path) -> None:
    right = hashlib.sha3_256(b"x").hexdigest()
    content = (
        related("model.mo", "model", more=f'checksum="{right}"')
        + related("mo%64el.mo", "model", more='checksum="00" checksumType="SHA-256"')
        + related("../../modelDescription.xml", "poem")
        + related("https://example.org/report.pdf", "report")
        + related("nothing.pdf", "document")
        + EXPERIMENT
    )
    files = {"fmi-ls-manifest.xml": manifest(content), "model.mo": "x", "in.csv": ""}
    fmu = packed(tmp_path, build("plants.gantry.x_axis"), files)
    assert [(f.severity, f.text) for f in found(fmu, "static")] == [
        ("error", "mo%64el.mo: it does not have the SHA-256 that is given"),
        ("error", "../../modelDescription.xml: 'poem' is no role of a related file"),
        (
            "advice",
            f"{FOLDER}/fmi-ls-manifest.xml names {FOLDER}/nothing.pdf, which is not "
            f"there",
        ),
        ("error", f"experiment 'push': there is no {FOLDER}/heavy.ssv"),
        ("error", f"experiment 'push': there is no {FOLDER}/out.csv"),
    ]


def test_a_manifest_in_another_folder_is_found(tmp_path: Path) -> None:
    fmu = packed(tmp_path, build("plants.gantry.x_axis"), {})
    with zipfile.ZipFile(fmu, "a") as archive:
        archive.writestr("extra/org.example/fmi-ls-manifest.xml", manifest(""))
    (only,) = found(fmu, "static")
    assert "is of org.fmi-standard.fmi-ls-ref, but lies in the folder of" in only.text
