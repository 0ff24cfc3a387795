"""Files that a model reads: its own ones belong to it, all others are refused."""

import json
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy import read_model_description

from fmus.build import BuildError, build, load_model
from fmus.closure import digest

MODEL = '''\
"""A gain from a table.  Source: any textbook (2026)."""
import json
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
from fmus.data import read_data
from fmus.model import Sampled, Var

{read}

class State(NamedTuple):
    pass

class Input(NamedTuple):
    u: Annotated[float, Var("V", "in")] = 1.0

class Output(NamedTuple):
    y: Annotated[float, Var("V", "out")]

class Parameters(NamedTuple):
    K: Annotated[float, Var("1", "gain")] = K

def step(x, u, p, T_s):
    {traced}
    return State(), Output(p.K * u.u)

model = Sampled("FromTable", step, State(), Input(), Parameters())
'''
SHIPPED = 'K = json.loads(read_data(__file__, "gains/table.json"))["K"]'


def written(folder, read=SHIPPED, traced="", K=2.5):
    (folder / "gains").mkdir(exist_ok=True)
    (folder / "gains" / "table.json").write_text(json.dumps({"K": K}))
    (folder / "gain.txt").write_text("2.5\n")
    (folder / "helper.py").write_text("K = 2.5\n")
    model = folder / "from_table.py"
    model.write_text(MODEL.format(read=read, traced=traced))
    return str(model)


@pytest.mark.parametrize(
    ("kind", "fmi", "place"),
    [
        ("native", 2, "sources/gains/table.json"),
        ("native", 3, "sources/gains/table.json"),
        ("python", 2, "resources/gains/table.json"),
    ],
)
def test_a_data_file_is_part_of_the_fmu_and_of_its_digest(tmp_path, kind, fmi, place):
    model = written(tmp_path)
    before, fmu = digest(model), build(model, kind=kind, fmi=fmi)
    with zipfile.ZipFile(fmu) as archive:
        assert json.loads(archive.read(place)) == {"K": 2.5}
    written(tmp_path, K=3.5)
    assert digest(model) != before
    changed = build(model, kind=kind, fmi=fmi)
    assert changed != fmu
    start = {v.name: v.start for v in read_model_description(changed).modelVariables}
    assert float(start["K"]) == 3.5
    (tmp_path / "gains" / "table.json").unlink()
    result = fmpy.simulate_fmu(str(changed), stop_time=0.01)
    assert np.all(result["y"] == 3.5)


def test_a_changed_data_file_is_seen_in_the_same_process(tmp_path):
    model = written(tmp_path)
    assert load_model(model).parameters.K == 2.5
    written(tmp_path, K=4.0)
    assert load_model(model).parameters.K == 4.0


@pytest.mark.parametrize(
    "read",
    [
        'K = float(Path(__file__).with_name("gain.txt").read_text())',
        'K = float(np.loadtxt(str(Path(__file__).with_name("gain.txt"))))',
        'with open(Path(__file__).parent / "gain.txt") as f:\n    K = float(f.read())',
    ],
)
def test_any_other_file_read_at_import_is_refused_in_words(tmp_path, read):
    model = written(tmp_path, read)
    told = r"from_table\.py:10: reads .*gain\.txt while it is imported.*read_data"
    for _ in range(2):  # the second time its module is already in memory
        with pytest.raises(BuildError, match=told):
            build(model)
        load_model(model)


def test_a_file_read_while_the_equations_are_traced_is_refused(tmp_path):
    traced = 'np.loadtxt(str(Path(__file__).with_name("gain.txt")))'
    with pytest.raises(BuildError, match=r"reads .*gain\.txt while it is traced"):
        build(written(tmp_path, traced=traced))


def test_a_module_brought_in_by_other_means_than_import_is_refused(tmp_path):
    read = 'import importlib\nK = importlib.import_module("helper").K'
    with pytest.raises(BuildError, match=r"helper\.py while it is imported.*import s"):
        build(written(tmp_path, read))


@pytest.mark.parametrize(
    ("read", "told"),
    [
        ('n = "gain.txt"\nK = float(read_data(__file__, n))', "write the file out"),
        ('K = float(read_data(__file__, "../g.txt"))', "write the file out"),
        ('K = float(read_data("elsewhere.py", "gain.txt"))', "write the file out"),
        ('K = float(read_data(__file__, "none.txt"))', "none.txt, which is not beside"),
    ],
)
def test_which_data_file_is_read_must_be_plain(tmp_path, read, told):
    with pytest.raises(BuildError, match=told):
        build(written(tmp_path, read))
