"""Directional derivatives of FMUs against differences of the NumPy equations."""

import warnings

import numpy as np
import pytest
from modules import MODULES
from subject import Instance, subject

from fmus.build import build
from fmus.tangent import tangent

CLOSE = 1e-5  # of the largest change
EPSILON = (1e-6, 4e-7)  # where these two disagree there is a kink or a step


# plants with friction, delay and tables, controllers of every kind; one that rounds
REPRESENTATIVES = (
    "controllers.ball_screw.mc_ppc",
    "controllers.gantry.mimo",
    "plants.ball_screw.drive",
    "plants.ball_screw.encoder",
    "plants.ball_screw_lpv.lpv",
    "plants.leadscrew.axis",
    "plants.xy_table.axis",
    "controllers.three_axis.task_frame",
)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "differentiated" in metafunc.fixturenames:
        everything = metafunc.config.getoption("--every-form")
        chosen = MODULES if everything else REPRESENTATIVES
        metafunc.parametrize("differentiated", chosen)


def changes(s, x, u, p, dx, du, epsilon):
    """Central difference of (derivatives, outputs) along (dx, du)."""
    sides = []
    for sign in (1, -1):
        at = (x + sign * epsilon * dx, u + sign * epsilon * du, p)
        if s.continuous:
            rows = [s.numpy(name, *at) for name in ("derivative", "output")]
            sides.append(np.concatenate(rows))
        else:
            sides.append(s.numpy("step", *at)[x.size :])
    return (sides[0] - sides[1]) / (2 * epsilon)


def direction(s, fmi, instance, dx, du):
    """The same as the FMU gives it."""
    knowns = [v for b in ("state", "input") for v in s.layout.block(b) if not v.boolean]
    change = {"state": dx, "input": du}
    seed = [
        float(change[v.block][r - s.layout.offset[v.block]])
        for v in knowns
        for _, r in v.elements()
    ]
    unknowns = [v for b in ("derivative", "output") for v in s.layout.block(b)]
    if fmi == 2:
        of = [r for v in unknowns for _, r in v.elements()]
        by = [r for v in knowns for _, r in v.elements()]
        return np.array(instance.slave.getDirectionalDerivative(of, by, seed))
    of, by = [v.reference for v in unknowns], [v.reference for v in knowns]
    size = sum(v.size for v in unknowns)
    return np.array(instance.slave.getDirectionalDerivative(of, by, seed, size))


def test_at_rest_there_are_directional_derivatives(differentiated):
    """A root of 0 has none, which an FMU would refuse with."""
    s = subject(differentiated)
    found = tangent(s.model, s.traced)
    if found is None:
        return
    random = np.random.default_rng(12)
    T_s = 0.0 if s.continuous else float(s.model.period)
    *start, p = s.start()
    d = s.traced.functions["prepare"](p, T_s)
    for x, u in (start, [0 * part for part in start]):
        changes = random.normal(size=x.size), random.normal(size=u.size)
        for result in found(x, u, p, d, T_s, *changes):
            assert np.isfinite(result.full()).all()


@pytest.mark.parametrize("fmi", [2, 3])
def test_directional_derivatives_are_those_of_the_equations(
    differentiated, fmi, tmp_path
):
    module, s = differentiated, subject(differentiated)
    if tangent(s.model, s.traced) is None:
        rounding = Instance(build(module, fmi=fmi), fmi, tmp_path, s.layout)
        with pytest.raises(Exception, match="status 3"):
            direction(s, fmi, rounding, s.start()[0], s.start()[1])
        rounding.slave.freeInstance()
        return
    if not s.layout.count["state"] + s.layout.count["input"]:
        pytest.skip("it has neither states nor inputs")
    random = np.random.default_rng(11)
    instance = Instance(build(module, fmi=fmi), fmi, tmp_path, s.layout)
    compared = 0
    for _ in range(3):
        x, u, p = s.random_point(random)
        dx = random.normal(size=x.size) * np.maximum(np.abs(x), 1e-3)
        du = random.normal(size=u.size) * np.maximum(np.abs(u), 1e-3)
        for v in s.layout.block("input"):
            if v.boolean:
                first = v.reference - s.layout.offset["input"]
                du[first : first + v.size] = 0
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            once, again = (changes(s, x, u, p, dx, du, e) for e in EPSILON)
        for block, vector in (("parameter", p), ("state", x), ("input", u)):
            instance.set(block, vector)
        given = direction(s, fmi, instance, dx, du)
        scale = np.max(np.abs(given), initial=1e-300)
        smooth = np.abs(once - again) <= CLOSE / 10 * scale
        error = np.abs(given - once)[smooth]
        assert np.max(error, initial=0.0) <= CLOSE * scale
        compared += smooth.sum()
    assert compared
    instance.slave.freeInstance()
