"""What our own FMUs say of themselves, built today or by the version before."""

import re
import zipfile
from fractions import Fraction
from pathlib import Path

import pytest

from fmus.archive import EXTRA
from fmus.build import build
from orchestrator.errors import FmuError
from orchestrator.fmu.description import read_fmu

MODULE = "controllers.ball_screw.mc_ppc"
BEFORE = {  # where kind and period stood
    2: (
        r"(?=<ModelVariables)",
        '<VendorAnnotations><Tool name="feeddrive">{}</Tool></VendorAnnotations>',
    ),
    3: (
        r"(?=</fmiModelDescription)",
        '<Annotations><Annotation type="feeddrive">{}</Annotation></Annotations>',
    ),
}


def rewritten(fmu: Path, target: Path, **texts: tuple[str, str]) -> Path:
    """Copy an FMU without its extra file, or with another text in it."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == EXTRA and "extra" not in texts:
                continue
            if name == EXTRA:
                content = texts["extra"][1].encode()
            if name == "modelDescription.xml" and "description" in texts:
                place, text = texts["description"]
                content = re.sub(place, text, content.decode(), count=1).encode()
            new.writestr(name, content)
    return target


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_fmu_of_the_version_before_tells_kind_period_and_clock(fmi, tmp_path):
    place, note = BEFORE[fmi]
    model = f'<Model module="{MODULE}" kind="sampled" period="1/20000"/>'
    today = build(MODULE, fmi=fmi)
    before = rewritten(
        today, tmp_path / "before.fmu", description=(place, note.format(model))
    )
    for fmu in (today, before):
        told = read_fmu(fmu)
        assert (told.kind, told.period) == ("sampled", Fraction(1, 20_000))
        assert (told.clock is not None) == (fmi == 3)


def test_without_either_it_is_a_foreign_fmu(tmp_path):
    told = read_fmu(rewritten(build(MODULE), tmp_path / "foreign.fmu"))
    assert (told.kind, told.period) == (None, None)


@pytest.mark.parametrize(
    "text",
    [
        "<Model",
        '<Model kind="wild"/>',
        '<Model kind="sampled" period="1/0"/>',
        '<Model kind="sampled" period="often"/>',
    ],
)
def test_a_damaged_claim_is_refused_and_named(text, tmp_path):
    fmu = rewritten(build(MODULE), tmp_path / "damaged.fmu", extra=("", text))
    with pytest.raises(FmuError, match=rf"{EXTRA} cannot be understood"):
        read_fmu(fmu)
