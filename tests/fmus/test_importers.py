"""Tools of others take our FMUs: CasADi's importer, pathsim-fmi."""

import warnings
import zipfile
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from modules import EXCHANGED, MODULES
from subject import subject

from fmus.build import build

SAME = 1e-12
REPRESENTATIVES = (
    "plants.ball_screw.encoder",
    "controllers.ball_screw.mc_ppc",
    "controllers.gantry.mimo",
    "plants.leadscrew.axis",
)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    everything = metafunc.config.getoption("--every-form")
    if "fmi" in metafunc.fixturenames:
        # in the short run every plant once, FMI 2 and 3 by turns
        forms = [
            (module, fmi)
            for i, module in enumerate(EXCHANGED)
            for fmi in (2, 3)
            if everything or i % 2 == fmi % 2
        ]
        metafunc.parametrize(("module", "fmi"), forms)
    if "clockless" in metafunc.fixturenames:
        metafunc.parametrize("clockless", MODULES if everything else REPRESENTATIVES)


@pytest.mark.filterwarnings("ignore::FutureWarning")  # CasADi on its own past
def test_casadi_evaluates_and_differentiates_every_plant(module, fmi, tmp_path):
    s = subject(module)
    arrays = {v.block for v in s.layout.variables if v.shape and not v.var.constant}
    if fmi == 3 and arrays - {"parameter"}:
        pytest.xfail("CasADi 3.8.2 takes an array of FMI 3 for one number")
    named = "xu" if fmi == 3 and arrays else "xup"  # else parameters keep their start
    with zipfile.ZipFile(build(module, fmi=fmi)) as archive:
        archive.extractall(tmp_path)
    dae = ca.DaeBuilder("plant", str(tmp_path))
    elements: dict[str, list[int]] = {}
    for block in ("state", "input", "parameter", "output"):
        for v in s.layout.block(block):
            first = v.reference - s.layout.offset[block]
            elements[v.name] = list(range(first, first + v.size))
            for name, reference in v.elements():
                elements.setdefault(name, [reference - s.layout.offset[block]])

    def places(names: list[str]) -> list[int]:
        return [place for name in names for place in elements[name]]

    point = dict(zip("xup", s.random_point(np.random.default_rng(3)), strict=True))
    for v in s.layout.block("parameter"):
        if v.boolean:  # which CasADi leaves as they are
            point["p"][v.reference - s.layout.offset["parameter"]] = v.start[0]
    if "p" not in named:
        point["p"] = s.start()[2]
    x, u, p = point.values()
    at = {name: places(getattr(dae, name)()) for name in named}
    x_at, u_at = at["x"], at["u"]
    given = [point[name][at[name]] for name in named]
    f = dae.create("f", list(named), ["ode", "y"])
    ode, y = (np.ravel(result) for result in f(*given))
    expected = s.numpy("derivative", x, u, p)[x_at]
    assert np.max(np.abs(ode - expected)) <= SAME * np.max(np.abs(expected))
    outputs = s.numpy("output", x, u, p)[places(dae.y())]
    assert np.max(np.abs(y - outputs)) <= SAME * np.max(np.abs(outputs))

    jacobian = dae.create("J", list(named), ["jac_ode_x", "jac_ode_u"])
    traced = s.traced.functions["derivative"]
    d = s.traced.functions["prepare"](p, 0.0)
    exact = traced.jacobian()(x, u, p, d, traced(x, u, p, d))
    for found, all_of, of in zip(jacobian(*given), exact, (x_at, u_at), strict=False):
        wanted = np.array(all_of)[np.ix_(x_at, of)]
        error = np.abs(np.array(found) - wanted)
        assert np.max(error, initial=0.0) <= 1e-9 * np.max(np.abs(wanted), initial=1.0)


def test_pathsim_takes_fmi_3_without_clock(clockless):
    from pathsim_fmi import CoSimulationFMU

    s = subject(clockless)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        block = CoSimulationFMU(str(build(clockless, fmi=3, clock=False)), dt=s.h)
    x, u, p = s.start()
    assert block.inputs.to_array().size == u.size
    block.inputs.update_from_array(u)
    for k in range(3):
        block._step_fmu(k * s.h)
        if s.continuous:
            continue
        found = s.numpy("step", x, u, p)
        x, y = np.split(found, [x.size])
        assert np.allclose(block.outputs.to_array(), y, rtol=SAME, atol=1e-12)


def test_fmi_3_has_no_annotations_at_the_root_and_a_clock_only_if_asked_for():
    for clock in (True, False):
        fmu = build("controllers.ball_screw.mc_ppc", fmi=3, clock=clock)
        with zipfile.ZipFile(fmu) as archive:
            text = archive.read("modelDescription.xml").decode()
        assert "Annotation" not in text
        assert ("<Clock" in text) == ('hasEventMode="true"' in text) == clock


def test_an_fmu_without_clock_refuses_event_mode(tmp_path: Path):
    import fmpy

    fmu = build("controllers.ball_screw.mc_ppc", fmi=3, clock=False)
    described = fmpy.read_model_description(str(fmu))
    instance = fmpy.fmi3.FMU3Slave(
        guid=described.guid,
        unzipDirectory=fmpy.extract(str(fmu), str(tmp_path)),
        modelIdentifier=described.coSimulation.modelIdentifier,
    )
    with pytest.raises(Exception, match="nstantiat"):
        instance.instantiate(eventModeUsed=True)
