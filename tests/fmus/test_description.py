"""What modelDescription.xml promises, against the validators and the equations."""

import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from lxml import etree

from fmus.archive import EXTRA
from fmus.build import BuildError, build, load_model
from fmus.model import Continuous, pack, unpack

MODELS = Path(__file__).parent / "small_models"
NAMES = ["spring_mass", "pi", "matrices", "late"]
FORMS = [("native", 2), ("native", 3), ("python", 2)]


def fmu(name, kind="native", fmi=2):
    return str(build(str(MODELS / f"{name}.py"), kind=kind, fmi=fmi))


def xml(path, member="modelDescription.xml"):
    with zipfile.ZipFile(path) as archive:
        return etree.fromstring(archive.read(member))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("kind", "fmi"), FORMS)
def test_fmpy_and_the_schemas_find_no_problem(name, kind, fmi):
    assert validate_fmu(fmu(name, kind, fmi)) == []


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("kind", "fmi"), FORMS)
def test_every_number_has_a_unit_with_base_units_defined_once(name, kind, fmi):
    root = xml(fmu(name, kind, fmi))
    units = [unit.get("name") for unit in root.iterfind("UnitDefinitions/Unit")]
    assert len(units) == len(set(units))
    assert all(unit.find("BaseUnit") is not None for unit in root.iter("Unit"))
    for real in [*root.iter("Real"), *root.iter("Float64")]:
        assert real.get("unit") in units


def test_both_versions_and_kinds_name_the_same_variables():
    names = [
        {
            v.name
            for v in read_model_description(fmu("spring_mass", *form)).modelVariables
        }
        for form in FORMS
    ]
    assert names[0] == names[1] - {"time"} == names[2]


def test_arrays_are_elements_in_fmi_2_and_arrays_in_fmi_3():
    two = {v.name: v for v in read_model_description(fmu("matrices")).modelVariables}
    three = read_model_description(fmu("matrices", fmi=3))
    starts = [float(two[f"gains.A[{i},{j}]"].start) for i in (1, 2) for j in (1, 2)]
    assert starts == [0.9, 0.05, -0.1, 0.8]
    (matrix,) = (v for v in three.modelVariables if v.name == "gains.A")
    assert matrix.shape == (2, 2)
    assert [float(v) for v in matrix.start.split()] == starts


def test_constants_fixed_and_switches_are_declared_as_such():
    said = {
        v.name: (v.causality, v.variability, v.type, v.start)
        for v in read_model_description(fmu("spring_mass")).modelVariables
    }
    assert said["scale"] == ("local", "constant", "Real", "1000000.0")
    assert said["k_2"] == ("parameter", "fixed", "Real", "20000.0")
    assert said["second"] == ("parameter", "tunable", "Boolean", "true")
    assert said["state.x"] == ("local", "continuous", "Real", "0.01")


@pytest.mark.parametrize(
    ("name", "offered"), [("spring_mass", True), ("late", False), ("pi", False)]
)
def test_model_exchange_is_offered_where_an_integrator_suffices(name, offered):
    for fmi in (2, 3):
        description = read_model_description(fmu(name, fmi=fmi))
        assert (description.modelExchange is not None) == offered
    assert read_model_description(fmu(name, "python")).modelExchange is None


@pytest.mark.parametrize("fmi", [2, 3])
def test_our_master_is_told_kind_and_exact_period(fmi):
    told = xml(fmu("pi", fmi=fmi), EXTRA)
    assert dict(told.attrib) == {"module": "pi", "kind": "sampled", "period": "1/2000"}
    told = xml(fmu("late", fmi=fmi), EXTRA)
    assert dict(told.attrib) == {"module": "late", "kind": "continuous"}


def evaluate(model, x, u, p):
    """Outputs and state derivatives by the model's own NumPy equations."""
    d = ()
    if isinstance(model, Continuous):
        values = (model.output(x, u, p), model.derivative(x, u, p))
        return np.concatenate([pack(v) for v in values])
    T_s = float(model.period)
    if model.prepare is not None:
        d = (model.prepare(p, T_s),)
    return pack(model.step(x, u, p, T_s, *d)[1])


@pytest.mark.parametrize("name", NAMES)
def test_declared_dependencies_are_those_of_the_equations(name):
    """Every known is moved at random points; what moves must be declared, what is
    declared must move, and what is called constant must move in proportion."""
    model = load_model(str(MODELS / f"{name}.py"))
    description = read_model_description(fmu(name))
    unknowns = [
        u.variable.name for u in [*description.outputs, *description.derivatives]
    ]
    declared = {
        u.variable.name: dict(
            zip([d.name for d in u.dependencies], u.dependenciesKind, strict=True)
        )
        for u in [*description.outputs, *description.derivatives]
    }
    at_start = {
        u.variable.name: {d.name for d in u.dependencies}
        for u in description.initialUnknowns
    }
    names = [v.name for v in description.modelVariables]
    n_p, n_u, n_x = (len(pack(r)) for r in (model.parameters, model.input, model.state))
    first_x = names.index(next(n for n in names if n.startswith("state.")))
    known = names[: n_p + n_u] + names[first_x : first_x + n_x]
    random = np.random.default_rng(1)
    constants = {
        v.name for v in description.modelVariables if v.variability == "constant"
    }
    constant = np.array([n in constants for n in known[:n_p]])
    ratios: dict[tuple[str, str], list[float]] = {}
    for _ in range(40):
        p = pack(model.parameters)
        p = np.where(constant, p, p * random.uniform(0.5, 2, n_p))
        u, x = random.normal(0, 1, n_u), random.normal(0, 0.01, n_x)
        point = np.concatenate([p, u, x])

        def at(z):
            return evaluate(
                model,
                unpack(model.state, z[n_p + n_u :]),
                unpack(model.input, z[n_p : n_p + n_u]),
                unpack(model.parameters, z[:n_p]),
            )

        base = at(point)
        for j, name_j in enumerate(known):
            moved = point.copy()
            boolean = isinstance(name_j, str) and name_j in ("second", "gate")
            moved[j] = (
                1.0 - round(moved[j]) if boolean else moved[j] + random.uniform(1, 3)
            )
            change = (at(moved) - base) / (moved[j] - point[j])
            for i, name_i in enumerate(unknowns):
                ratios.setdefault((name_i, name_j), []).append(change[i])
    for (unknown, name_j), slopes in ratios.items():
        if name_j in constants:
            continue
        moves = bool(np.any(np.abs(slopes) > 0))
        assert (name_j in at_start[unknown]) == moves, (unknown, name_j)
        kind = declared[unknown].get(name_j)
        stepping_known = name_j in known[n_p : n_p + n_u] or (
            isinstance(model, Continuous) and name_j.startswith("state.")
        )
        assert (kind is not None) == (moves and stepping_known), (unknown, name_j)
        if kind == "constant":
            np.testing.assert_allclose(slopes, slopes[0], rtol=1e-6)


def test_dependencies_of_a_quantiser_are_not_called_linear(tmp_path):
    source = (MODELS / "pi.py").read_text()
    source = source.replace("v = p.K_p * e + x.q", "v = e + np.floor(e) + x.q")
    (tmp_path / "steps.py").write_text(source)
    description = read_model_description(str(build(str(tmp_path / "steps.py"))))
    assert {k for o in description.outputs for k in o.dependenciesKind} == {"dependent"}


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("] = 2.0", "] = float('nan')", r"parameter 'm' starts at \(nan,\)"),
        (
            "] = 2.0",
            "] = -2.0",
            r"parameter 'm' starts out of its bounds \[0.001, inf\]",
        ),
        ('"kg"', '"kgg.x"', "unknown unit 'kgg'"),
        ("    m: Ann", "    time: Ann", "'time' has the name of the independent"),
        ("    c: Ann", "    F: Ann", "input 'F' is also the name of a parameter"),
        ("scale: Ann", "scale: float = 1\n    d: Ann", "Parameters.scale has no Var"),
    ],
)
def test_what_no_importer_would_take_is_refused(tmp_path, old, new, complaint):
    source = (MODELS / "spring_mass.py").read_text().replace(old, new, 1)
    source = source.replace("/ p.m", "/ p[0]").replace("p.c ", "p[3] ")
    (tmp_path / "wrong.py").write_text(source)
    with pytest.raises(BuildError, match=complaint):
        build(str(tmp_path / "wrong.py"))
