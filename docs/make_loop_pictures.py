"""Draw the pictures of loops and fits in the docs from runs made now: make pictures."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from make_pictures import STUDY, tracking_error

from controllers.synthesis.ball_screw.loops import sampled_loop
from controllers.synthesis.frequency import respond
from orchestrator import run
from orchestrator.analysis.begin import begin_of, free_of
from orchestrator.analysis.candidates import parse_constraint
from orchestrator.analysis.fit import fit, free_values
from orchestrator.analysis.measured import beside
from orchestrator.analysis.tune import tune
from orchestrator.response.measure import measure
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier

HERE = Path(__file__).parent
MARGIN = HERE / "examples" / "margin" / "drive.toml"
POINTS = {"marker": ".", "ms": 3, "ls": "none", "color": "#1f5fa8"}


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
    begin = begin_of(nominal)
    found = tune(
        nominal,
        free_of(nominal, ["controller.K_*"], {}, begin),
        "tracking.peak",
        [parse_constraint("loop.modulus_margin >= 0.42")],
        begin=begin,
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


if __name__ == "__main__":
    responded()
    tuned()
    fitted()
