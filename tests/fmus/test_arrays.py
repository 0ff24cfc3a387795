"""Arrays of signals and tables of matrices, in every form of FMU, against SciPy."""

from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy import read_model_description
from scipy.linalg import expm
from valid import problems

from fmus.build import build, load_model

MODEL = str(Path(__file__).parent / "small_models" / "scheduled.py")
FORMS = [("native", 2), ("native", 3), ("python", 2)]
RHO, T = 0.37, 0.02


def exact():
    """Return states and outputs at T from matrices interpolated by hand."""
    model = load_model(MODEL)
    p, u = model.parameters, model.input.u
    part = (RHO - 0.3) / 0.3
    A, B = ((1 - part) * M[3:6] + part * M[6:9] for M in (p.A, p.B))
    steady = -np.linalg.solve(A, B @ u)
    x = steady - expm(A * T) @ steady
    return {"state.x": x, "y": p.C @ x, "Y": np.outer(x, p.C[0]), "last": x[2]}


def elements(value):
    value = np.asarray(value)
    for index in np.ndindex(value.shape):
        written = ",".join(str(i + 1) for i in index)
        yield f"[{written}]" if written else "", value[index]


@pytest.mark.parametrize(("kind", "fmi"), FORMS)
def test_array_signals_are_right_and_named_by_index_or_whole(kind, fmi):
    fmu = str(build(MODEL, kind=kind, fmi=fmi))
    assert problems(fmu) == []
    names = {v.name for v in read_model_description(fmu).modelVariables}
    watched = ["state.x", "y", "Y", "last"]
    if fmi == 2:
        watched = [f"{n}{i}" for n in watched for i, _ in elements(exact()[n])]
    assert set(watched) <= names
    result = fmpy.simulate_fmu(
        fmu,
        fmi_type="CoSimulation",
        stop_time=T,
        output_interval=1e-3,
        start_values={"rho": RHO},
        output=watched,
    )
    for name, value in exact().items():
        for index, number in elements(value):
            if fmi == 2:
                got = result[f"{name}{index}"][-1]
            else:
                at = tuple(int(i) - 1 for i in index[1:-1].split(",") if i)
                got = result[name][-1][at]
            assert got == pytest.approx(number, rel=1e-9), f"{name}{index}"


@pytest.mark.parametrize("fmi", [2, 3])
def test_array_states_are_integrated_by_an_importer_too(fmi):
    watched = ["last"]
    result = fmpy.simulate_fmu(
        str(build(MODEL, fmi=fmi)),
        fmi_type="ModelExchange",
        stop_time=T,
        relative_tolerance=1e-10,
        start_values={"rho": RHO},
        output=watched,
    )
    assert result["last"][-1] == pytest.approx(exact()["last"], rel=1e-6)
