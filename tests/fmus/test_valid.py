"""What stands in for FMPy's validation still finds a wrong name."""

from pathlib import Path
from zipfile import ZipFile

from valid import problems

from fmus.build import build


def test_a_name_that_is_not_structured_is_found_beside_those_that_are(
    tmp_path: Path,
) -> None:
    fmu = build(str(Path(__file__).parent / "small_models" / "matrices.py"))
    assert problems(fmu) == []
    wrong = tmp_path / "wrong.fmu"
    with ZipFile(fmu) as old, ZipFile(wrong, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                assert b'name="gains.A[1,2]"' in content
                content = content.replace(b'name="gains.A[1,2]"', b'name="gains.A[1,2"')
            new.writestr(name, content)
    (found,) = problems(wrong)
    assert "gains.A[1,2" in found
