"""Draw the pictures of README and docs from runs made now: make pictures."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from controllers.synthesis.ball_screw.loops import sampled_loop
from controllers.synthesis.frequency import respond
from orchestrator import Result, run
from orchestrator.analysis.candidates import parse_constraint
from orchestrator.analysis.fit import fit, free_values
from orchestrator.analysis.measured import beside
from orchestrator.analysis.sweep import sweep
from orchestrator.analysis.tune import free_of, tune
from orchestrator.analysis.variations import Axis
from orchestrator.response.measure import measure
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

HERE = Path(__file__).parent
UM_PER_RAD = 1e6 * 0.020 / (2 * np.pi)
STUDY = "ball_screw_pole_placement"
MARGIN = HERE / "examples" / "margin" / "drive.toml"
POINTS = {"marker": ".", "ms": 3, "ls": "none", "color": "#1f5fa8"}


def demo() -> None:
    """Command, tracking errors and control signal of both controllers at 500 mm/s."""
    runs = {
        "P-PI cascade, set C": run(f"{STUDY}/p_pi_c_track_500", report=False),
        "MC-PPC": run(f"{STUDY}/mc_ppc_track_500", report=False),
        "MC-PPC with pre-filter": run(
            f"{STUDY}/mc_ppc_track_500_prefilter", report=False
        ),
    }
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(9, 5), sharex=True, height_ratios=(2, 1), layout="constrained"
    )
    for label, done in runs.items():
        above.plot(done["encoder.y_2"].time, tracking_error(done), label=label, lw=1)
    control = runs["MC-PPC"]["controller.u"]
    below.plot(control.time, control.values, color="C1", lw=1)
    above.set_ylabel("tracking error in µm")
    above.set_title(
        "Ball-screw drive, 250 mm at 500 mm/s and 1 g, controllers at 20 kHz"
    )
    above.legend(frameon=False)
    below.set_ylabel("control signal in V")
    below.set_xlabel("time in s")
    for axes in (above, below):
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(HERE / "pictures" / "demo.png", dpi=110)


def tracking_error(done: Result) -> np.ndarray:
    """Return x_r - y_2 in micrometres of table motion."""
    error = done["trajectory.x_r"].values - done["encoder.y_2"].values
    return UM_PER_RAD * error


def held() -> None:
    """Peak error over mass and stiffness, and where it misses the expectation."""
    drive = HERE / "examples" / "does_it_hold" / "drive.toml"
    axes = [
        Axis("plant.m_2", tuple(np.linspace(0.8, 1.2, 9) * 0.379e-3)),
        Axis("plant.k", tuple(np.linspace(190, 230, 9))),
    ]
    rows = sweep(drive, axes).rows
    m_2, k, peak = (
        np.array([row[name] for row in rows])
        for name in ("plant.m_2", "plant.k", "tracking.peak")
    )
    figure, plot = plt.subplots(figsize=(7, 4.2), layout="constrained")
    shape = len(axes[0].values), len(axes[1].values)
    x, y, z = (v.reshape(shape) for v in (1e3 * m_2, k, peak))
    colours = plot.pcolormesh(x, y, z, cmap="viridis", shading="nearest")
    figure.colorbar(colours, label="peak tracking error (um)")
    plot.contour(x, y, z, levels=[4.0], colors="#d1495b", linewidths=2)
    missed = np.array([not row["met"] for row in rows])
    plot.plot(1e3 * m_2[missed], k[missed], "x", color="#d1495b", label="not met")
    plot.set(xlabel="plant.m_2 (1e-3 V.s2/rad)", ylabel="plant.k (V/rad)")
    plot.legend(loc="upper left")
    figure.savefig(HERE / "pictures" / "sweep.png", dpi=110)


def composed(file: Path | str, values: Mapping[str, Any] | None = None) -> Composition:
    """Return a scenario with values, composed."""
    sets = [f"{name}={value!r}" for name, value in (values or {}).items()]
    return compose(load_scenario(file, sets), run_earlier)


def responded() -> None:
    """The measured loop of P-PI over the exact one."""
    found = measure(composed(MARGIN), ["controller.u"])
    hz = np.geomspace(found.hz[0], found.hz[-1], 4000)
    L = respond(sampled_loop("p_pi", False, {}), hz).L
    drawn = {"line": (hz, L), "point": (found.hz, found.L[:, 0, 0])}
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
    for kind, (x, loop) in drawn.items():
        style = {"color": "#bbbbbb", "lw": 3} if kind == "line" else POINTS
        label = "exact loop" if kind == "line" else "measured"
        axes[0].semilogx(x, decibels(loop), label=label, **style)
        axes[1].semilogx(x, np.degrees(np.unwrap(np.angle(loop))), **style)
        axes[2].semilogx(x, decibels(1 / (1 + loop)), **style)
    titles = ("|L| in dB", "phase of L in degrees", "|S| in dB")
    for plot, title in zip(axes, titles, strict=True):
        plot.set(title=title, xlabel="Hz")
        plot.grid(alpha=0.3)
    size, at = found.s_max
    axes[2].annotate(f"{size:.3g} at {at:.0f} Hz", (at, decibels(size)), (2, 8))
    axes[2].set_ylim(-60, 12)
    axes[0].legend(frameon=False)
    figure.savefig(HERE / "pictures" / "response.png", dpi=110)


def tuned() -> None:
    """Sensitivity and tracking error of P-PI before and after the first command."""
    nominal = composed(MARGIN)
    bounds = {"K_px": (20.0, 1e3), "K_pv": (0.1, 5.0), "K_iv": (5.0, 1e3)}
    named = {f"controller.{key}": value for key, value in bounds.items()}
    found = tune(
        nominal,
        free_of(nominal, list(named), named),
        "tracking.peak",
        [parse_constraint("loop.modulus_margin >= 0.42")],
        recompose=lambda values: composed(MARGIN, values),
    )
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    scenarios = (load_scenario(MARGIN), composed(MARGIN, found.best()).scenario)
    for word, of, scenario in zip(
        ("published", "tuned"), found.responses, scenarios, strict=True
    ):
        loop = of["loop"]
        left.semilogx(loop.hz, decibels(loop.S[:, 0, 0]), label=word, lw=1.2)
        done = run(scenario, report=False)
        right.plot(done["encoder.y_2"].time, tracking_error(done), label=word, lw=1)
    left.axhline(decibels(1 / 0.42), color="#d1495b", ls="--", lw=1)
    left.set(
        title="|S| in dB, and what it must keep below", xlabel="Hz", ylim=(-60, 12)
    )
    right.set(title="tracking error in µm", xlabel="time in s")
    for plot in (left, right):
        plot.grid(alpha=0.3)
        plot.legend(frameon=False)
    figure.savefig(HERE / "pictures" / "tune.png", dpi=110)


def fitted() -> None:
    """Position of the machine, the fitted model's, and what is left."""
    machine = run(HERE / "examples" / "measured_data" / "machine.toml", report=False)
    name, data = f"{STUDY}/mc_ppc_track_500", HERE / "measured.csv"
    rows = [machine[s].values for s in ("plant.u", "plant.x_1", "plant.x_2")]
    head = "time [s],plant.u [V],plant.x_1 [rad],plant.x_2 [rad]"
    time = np.arange(len(rows[0])) / 20_000
    table = np.column_stack([time, *rows])
    np.savetxt(data, table, "%.15g", ",", header=head, comments="")
    try:
        model = composed(name)
        free = free_values(model, ["plant.m_2", "plant.b_1"], {})
        found = fit(model, beside(model, data), free)
    finally:
        data.unlink()
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(9, 4.6), sharex=True, height_ratios=(2, 1), layout="constrained"
    )
    key = "plant.x_2"
    above.plot(found.time, found.measured[key], color="#bbbbbb", lw=4, label="measured")
    above.plot(found.time, found.simulated[key], lw=1, label="fitted model")
    left = found.simulated[key] - found.measured[key]
    below.plot(found.time, 1e9 * left, lw=0.8, color="#d1495b")
    above.set(ylabel="plant.x_2 in rad")
    values = [f"{k} = {v['value']:.4g} {v['unit']}" for k, v in found.values().items()]
    above.set_title(", ".join(values))
    below.set(xlabel="time in s", ylabel="left in nrad")
    above.legend(frameon=False)
    for plot in (above, below):
        plot.axvspan(
            found.time[found.used - 1], found.time[-1], color="#f2c14e", alpha=0.2
        )
        plot.grid(alpha=0.3)
    figure.savefig(HERE / "pictures" / "fit.png", dpi=110)


def decibels(values: Any) -> Any:
    """Return magnitudes in dB."""
    return 20 * np.log10(np.abs(values))


def rose() -> None:
    """Rose under the cascade and under K(θ): the contour error, magnified."""
    runs = [
        ("P-PI cascade", "p_pi_rose", 20),
        ("LPV contouring control K(θ)", "lpv_rose", 500),
    ]
    figure, plots = plt.subplots(1, 2, figsize=(9, 4.6), layout="constrained")
    for plot, (label, scenario, magnified) in zip(plots, runs, strict=True):
        done = run(f"contouring_lpv/{scenario}", report=False)
        r_x, r_y = (1e3 * done[f"path.r_{a}"].values for a in "xy")
        t_x, t_y = (done[f"path.t_{a}"].values for a in "xy")
        e = 1e3 * done["frame.e_nd"].values
        plot.plot(r_x, r_y, color="0.6", lw=0.8, label="path")
        # the table lies -e beside the path, along its normal (-t_y, t_x)
        x, y = r_x + magnified * e * t_y, r_y - magnified * e * t_x
        plot.plot(x, y, color="#d1495b", lw=1, label=f"errors × {magnified}")
        worst = 1e3 * np.max(np.abs(e))
        plot.set(aspect="equal", title=f"{label}: {worst:.1f} µm", xlabel="x in mm")
        plot.legend(frameon=False, loc="lower right", fontsize=8)
        plot.spines[["top", "right"]].set_visible(False)
    plots[0].set_ylabel("y in mm")
    figure.savefig(HERE / "pictures" / "rose.png", dpi=110)


if __name__ == "__main__":
    demo()
    held()
    responded()
    tuned()
    fitted()
    rose()
