"""Draw the pictures of README and docs from runs made now: make pictures."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from orchestrator import Result, run
from orchestrator.analysis.sweep import sweep
from orchestrator.analysis.variations import Axis
from orchestrator.drawings.page import write_figure
from orchestrator.drawings.registry import read_registry
from orchestrator.master.simulate import plan
from orchestrator.pictures.timetable import timetable_picture
from orchestrator.pictures.wiring import wiring_picture
from orchestrator.scenario.compose import compose
from orchestrator.scenario.reading import find_study, load_scenario
from orchestrator.supplied import PROJECT

HERE = Path(__file__).parent
UM_PER_RAD = 1e6 * 0.020 / (2 * np.pi)
STUDY = "ball_screw_pole_placement"


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


def compositions() -> None:
    """Wiring of the gantry; timetables of a cascade and of rates that rarely meet."""
    split = load_scenario(
        f"{STUDY}/p_pi_split_track_500",
        ["position.step=1 kHz", "velocity.step=4 kHz"],
    )
    rare = ["controller.step=200 us", "motor.step=125 us"]
    own = load_scenario(PROJECT / "tests" / "speed_step.toml", rare)
    gantry = load_scenario("gantry/circle_200")
    for name, draw, scenario in (
        ("wiring_gantry", wiring_picture, gantry),
        ("timetable_cascade", timetable_picture, split),
        ("timetable_125_200", timetable_picture, own),
    ):
        drawn = draw(plan(compose(scenario, None).system))
        (HERE / "pictures" / f"{name}.svg").write_text(drawn, encoding="utf-8")


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


def switching() -> None:
    """Error and command of the serial machine's x axis where a controller changes."""
    labels = {
        "hysteresis_kept": "hysteresis, state kept",
        "hysteresis": "hysteresis, state reset",
        "smooth": "smooth",
        "lpv": "no switching",
    }
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(8, 5), sharex=True, layout="constrained"
    )
    for scenario, label in labels.items():
        done = run(f"serial_lpv/{scenario}", report=False)
        e, v_m = done["control_x.e"], done["control_x.v_m"]
        near = (e.time > 0.85) & (e.time < 1.0)
        above.plot(e.time[near], 1e6 * e.values[near], label=label, lw=1)
        below.plot(v_m.time[near], v_m.values[near], lw=1)
    above.set_ylabel("error in µm")
    above.legend(frameon=False)
    below.set(xlabel="time in s", ylabel="command in V")
    for axes in (above, below):
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(HERE / "pictures" / "switching.png", dpi=110)


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


def studies() -> None:
    """A figure of each of three sources, as ``feeddrive figure`` draws it."""
    for study, number in (
        ("ball_screw_pole_placement", "fig_3_11"),
        ("gantry", "fig_4_14"),
        ("leadscrew_nctf", "fig_5_1"),
    ):
        file = HERE / "pictures" / f"{study}_{number}.png"
        write_figure(read_registry(find_study(study)), number, file)


if __name__ == "__main__":
    demo()
    compositions()
    held()
    switching()
    rose()
    studies()
