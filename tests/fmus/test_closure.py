import subprocess
import sys
from pathlib import Path

import pytest

from fmus.closure import NoSuchModule, closure, digest

MODELS = Path(__file__).parent / "small_models"


def write(folder, **modules):
    for name, text in modules.items():
        (folder / f"{name}.py").write_text(text)
    return str(folder / "drive.py")


def test_a_model_is_its_module_its_packages_and_their_imports():
    names = set(closure("controllers.ball_screw.mc_ppc"))
    assert {
        "controllers",
        "controllers.ball_screw.mc_ppc",
        "fmus",
        "fmus.model",
    } <= names
    assert "fmus.trace" not in names
    assert not any(n.startswith("controllers.synthesis") for n in names)


def test_a_model_file_brings_its_siblings_and_no_third_party(tmp_path):
    path = write(
        tmp_path,
        drive="import numpy\nimport casadi\nfrom friction import stribeck\n",
        friction="from fmus.table import lookup\nimport json\n",
        other="raise RuntimeError",
    )
    names = set(closure(path))
    assert names == {"drive", "friction", "fmus", "fmus.table"}


def test_relative_imports_are_followed(tmp_path, monkeypatch):
    package = tmp_path / "axes" / "parts"
    package.mkdir(parents=True)
    (tmp_path / "axes" / "__init__.py").touch()
    (package / "__init__.py").write_text("from ..shared import g\n")
    (tmp_path / "axes" / "shared.py").touch()
    (package / "drive.py").write_text("from . import gear\n")
    (package / "gear.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    names = set(closure("axes.parts.drive"))
    expected = {"axes", "axes.parts", "axes.parts.drive", "axes.parts.gear"}
    assert names == expected | {"axes.shared"}


def test_the_digest_follows_every_byte_of_the_closure(tmp_path):
    path = write(tmp_path, drive="import friction\n", friction="c = 1.0\n")
    before = digest(path)
    (tmp_path / "unrelated.py").write_text("x = 1\n")
    assert digest(path) == before
    write(tmp_path, friction="c = 2.0\n")
    assert digest(path) != before


def test_nothing_is_imported():
    code = (
        "import sys; from fmus.closure import closure; closure('plants.xy_table.axis');"
        "print([m for m in ('plants', 'numpy', 'casadi') if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("module", ["plants.nowhere", "nowhere", "", "gone/drive.py"])
def test_a_missing_module_is_refused(module):
    with pytest.raises(NoSuchModule, match="there is no module"):
        closure(module)
