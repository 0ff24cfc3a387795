"""Split FMUs, one composite FMU and an independent monolith are the same drive.

The monolith knows none of our models: matched filters by SciPy, the exact
zero-order hold of the plant by the matrix exponential, the command by its
closed form in extended precision (Gordon 2010, eq. 3.1 to 3.14, table 3.1).
"""

import shutil
from itertools import product
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.signal import lfilter
from simulated import simulated
from systems import part, system

from fmus.build import build
from orchestrator.master.simulate import simulate
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run

STUDY = "ball_screw_pole_placement"
T = 1 / 20_000
m_1, m_2, b_1, k, c = 1.858e-3, 0.379e-3, 1.020e-3, 210.02, 0.014
K_x1, K_x2, K_v1, K_v2, K_i2 = (
    632.965300,
    -83.312458,
    1.648469979,
    0.264903101,
    70135.3877,
)
Array = NDArray[np.float64]


def command(n: int, V: float = 1.0) -> Array:
    """Return the 250 mm move from 20 ms on as screw angle (rad), shape (n,)."""
    D, A, J, S = (np.longdouble(v) for v in (0.25, 9.81, 500.0, 5e4))
    stages = D / np.longdouble(V), np.longdouble(V) / A, A / J, J / S
    t = np.arange(n, dtype=np.longdouble) / 20_000 - np.longdouble(1) / 50
    x = np.zeros(n, dtype=np.longdouble)
    for chosen in product((0, 1), repeat=4):
        tau = sum(np.longdouble(i) * T_i for i, T_i in zip(chosen, stages, strict=True))
        x += (-1) ** sum(chosen) * np.maximum(t - tau, 0) ** 4 / 24
    pi = np.longdouble("3.14159265358979323846")
    return np.array(S * x * 2 * pi / np.longdouble(0.02), dtype=float)


def pair(w_hz: float, zeta: float) -> Array:
    """Return the two roots of s² + 2 zeta w s + w² (rad/s)."""
    w = 2 * np.pi * w_hz
    return np.roots([1, 2 * zeta * w, w * w])


def feedforward(x_r: Array) -> tuple[Array, Array]:
    """Return the screw command and the model inversion's voltage (eq. 3.12, 3.13)."""
    p = np.exp(-k * T / c)
    pair_r = np.roots([m_2, c, k]) * T
    b = np.real(np.poly(np.exp(pair_r)))
    x_1r = lfilter(b * (1 - p) / b.sum(), [1, -p], x_r)
    a_1, a_2 = m_2 * b_1 + (m_1 + m_2) * c, b_1 * c + (m_1 + m_2) * k
    poles = np.roots([m_1 * m_2, a_1, a_2, b_1 * k])
    slow = poles[np.argmin(np.abs(poles))].real
    axial = np.real(np.poly(np.exp(T * poles[np.abs(poles) > 100])))
    once = lfilter([1, -1], 1, x_r)
    twice = lfilter([1, -np.exp(slow * T)], 1, once)
    gain = b_1 / T * (1 - p) / (1 - np.exp(slow * T)) / axial.sum()
    return x_1r, lfilter(gain * axial, [1, -p], twice)


def filter_pack() -> tuple[Array, Array]:
    """Return the digital filter pack as one numerator and denominator."""
    numerator, denominator = np.array([1.0]), np.array([1.0])
    for f, zeta_z, zeta_p in ((420, 0.55, 0.7), (1080, 0.05, 0.7)):
        b = np.real(np.poly(np.exp(pair(f, zeta_z) * T)))
        a = np.real(np.poly(np.exp(pair(f, zeta_p) * T)))
        numerator = np.polymul(numerator, b * a.sum() / b.sum())
        denominator = np.polymul(denominator, a)
    p = np.exp(-2 * np.pi * 2000 * T)
    return (
        np.polymul(numerator, [(1 - p) / 2, (1 - p) / 2]),
        np.polymul(denominator, [1, -p]),
    )


def plant() -> tuple[Array, Array]:
    """Return the exact zero-order hold of the two-mass drive (x_1, x_2, v_1, v_2)."""
    system = np.zeros((5, 5))
    system[:2, 2:4] = np.eye(2)
    system[2, :5] = np.array([-k, k, -(c + b_1), c, 1.0]) / m_1
    system[3, :4] = np.array([k, -k, c, -c]) / m_2
    held = expm(system * T)
    return held[:4, :4], held[:4, 4]


def monolith(n: int, latency: int) -> Array:
    """Return the table's angle x_2 at n samples of the 1000 mm/s move."""
    x_r = command(n)
    x_1r, u_ff = feedforward(x_r)
    b, a = filter_pack()
    A, B = plant()
    z, x_2, u = np.zeros(4), np.zeros(n), np.zeros(n)
    memory = np.zeros(len(a) - 1)
    e_1 = e_2 = integral = 0.0
    for i in range(n):
        x_2[i] = z[1]
        before_1, before_2 = e_1, e_2
        e_1, e_2 = x_1r[i] - z[0], x_r[i] - z[1]
        integral += T * e_2
        v = K_x1 * e_1 + K_x2 * e_2 + K_i2 * integral
        v += (K_v1 * (e_1 - before_1) + K_v2 * (e_2 - before_2)) / T
        y = b[0] * v + memory[0]
        memory = np.append(memory[1:], 0.0) + b[1:] * v - a[1:] * y
        u[i] = y + u_ff[i]
        z = A @ z + B * (u[i - latency] if i >= latency else 0.0)
    return x_2


def p_pi_monolith(n: int, every: int) -> Array:
    """Return the table's angle x_2 of the 500 mm/s move under P-PI, set A.

    The position loop runs at each ``every``-th sample (fig. 3.9, eq. 3.25); what the
    controller computes acts one sample later.
    """
    K_px, K_pv, K_iv = 189.0, 0.91, 119.0
    x_r = command(n, 0.5)
    v_r = np.diff(x_r, prepend=0) / T
    u_ff = (m_1 + m_2) * np.diff(v_r, prepend=0) / T + b_1 * v_r
    b, a = filter_pack()
    A, B = plant()
    z, x_2, u = np.zeros(4), np.zeros(n), np.zeros(n + 1)
    memory = np.zeros(len(a) - 1)
    v_c = before = integral = 0.0
    for i in range(n):
        x_2[i] = z[1]
        if i % every == 0:
            v_c = K_px * (x_r[i] - z[1])
        v_e = v_c + v_r[i] - (z[0] - before) / T
        before = z[0]
        integral += T * v_e
        v = K_pv * v_e + K_iv * integral
        y = b[0] * v + memory[0]
        memory = np.append(memory[1:], 0.0) + b[1:] * v - a[1:] * y
        z = A @ z + B * u[i]
        u[i + 1] = y + u_ff[i]
    return x_2


@pytest.mark.parametrize(
    ("every", "peak", "rms"), [(1, 4.774, 1.342), (5, 4.822, 1.347)]
)
def test_a_slower_position_loop_holds_no_feed_forward_back(
    every: int, peak: float, rms: float, tmp_path: Path
) -> None:
    split = simulated(
        tmp_path, f"{STUDY}/p_pi_split_track_500", f"position.step={every}/20000"
    )
    x_2 = p_pi_monolith(15013, every)
    assert np.max(np.abs(split["plant.x_2"].values - x_2)) < 1e-9
    assert split.metrics["tracking.peak"].value == pytest.approx(peak, abs=0.005)
    assert split.metrics["tracking.rms"].value == pytest.approx(rms, abs=0.005)


@pytest.mark.parametrize("latency", [0, 1, 2])
def test_split_composite_and_monolith_move_alike(latency: int, tmp_path: Path) -> None:
    composite = simulated(
        tmp_path / "one", f"{STUDY}/mc_ppc_track_1000", f"controller.latency={latency}"
    )
    split = simulated(
        tmp_path / "split",
        f"{STUDY}/mc_ppc_split_track_1000",
        f"filters.latency={latency}",
    )
    x_2 = monolith(11032, latency)
    for result in (composite, split):
        assert np.max(np.abs(result["plant.x_2"].values - x_2)) < 1e-9


def test_the_composite_in_a_foreign_jacobi_master_has_latency_one(
    tmp_path: Path,
) -> None:
    ours = simulated(tmp_path / "ours", f"{STUDY}/mc_ppc_track_1000")
    controller, drive = (
        opened(build(module), tmp_path / module)
        for module in ("controllers.ball_screw.mc_ppc", "plants.ball_screw.two_mass")
    )
    design = ours.composition.designs["gains"].values
    names, values = list(design), [float(design[name]) for name in design]  # type: ignore[arg-type]
    controller.start(dict(zip(names, values, strict=True)))
    drive.start({})
    x_r = ours["trajectory.x_r"].values
    x_2 = np.zeros_like(x_r)
    for i, command_i in enumerate(x_r):
        y_1, x_2[i] = drive.get("x_1", "x_2")
        controller.set(x_r=command_i, y_1=y_1, y_2=x_2[i])
        drive.set(u=controller.get("u")[0])
        for fmu in (controller, drive):
            fmu.slave.doStep(i / 20_000, T)
    assert np.max(np.abs(x_2 - ours["plant.x_2"].values)) < 1e-9
    for fmu in (controller, drive):
        fmu.slave.terminate()
        fmu.slave.freeInstance()


class opened:
    """An FMI 2.0 FMU driven by hand through fmpy."""

    def __init__(self, path: Path, folder: Path) -> None:
        description = fmpy.read_model_description(path)
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.slave = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=fmpy.extract(path, folder),
        )

    def start(self, values: dict[str, float]) -> None:
        self.slave.instantiate()
        self.set(**values)
        self.slave.setupExperiment()
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def set(self, **values: float) -> None:
        self.slave.setReal([self.references[n] for n in values], list(values.values()))

    def get(self, *names: str) -> list[float]:
        found: list[float] = self.slave.getReal([self.references[n] for n in names])
        return found


def test_a_current_loop_split_from_the_plant_converges_with_first_order(
    tmp_path: Path,
) -> None:
    """A step of 1 V on both, exchanged every 4, 2 and 1 us for 20 ms."""
    step = {"u": 1.0}
    on = {"current_loop.on": True}
    whole = part(
        "plant", "plants.ball_screw.drive", "1/1000", start=step, parameters=on
    )
    row = {"plant.x_2": "1/1000"}
    exact = simulate(system("1/50", [whole], record=row), tmp_path)["plant.x_2"].values
    errors = []
    for us in (4, 2, 1):
        every = f"{us}/1000000"
        parts = [
            part("current", "plants.ball_screw.current_loop", every, start=step),
            part("plant", "plants.ball_screw.two_mass", every),
        ]
        wires = {"plant.u": "current.u_a"}
        split = simulate(system("1/50", parts, wires, row), tmp_path)
        errors.append(np.max(np.abs(split["plant.x_2"].values - exact)))
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    np.testing.assert_allclose(ratios, 2.0, rtol=0.01)


def test_the_split_current_loop_costs_what_the_design_says(tmp_path: Path) -> None:
    """Exchanged at 50 us the measured peak of S is 3.583, not 3.294."""
    split = tmp_path / "split.toml"
    base = load_scenario(f"{STUDY}/mc_ppc_sensitivity_165").file
    for file in base.parent.glob("mc_ppc_*.toml"):
        shutil.copy(file, tmp_path)
    split.write_text(
        'base = "mc_ppc_sensitivity_165.toml"\n'
        '[components.plant.parameters]\n"current_loop.on" = false\n'
        '[components.current]\nfmu = "plants.ball_screw.current_loop"\n'
        'step = "control"\n'
        '[connections]\n"current.u" = "controller.u"\n"plant.u" = "current.u_a"\n'
    )
    result = run(load_scenario(split), tmp_path / "run", report=False)
    assert result.metrics["sensitivity.ratio"].value == pytest.approx(3.583, abs=0.03)
