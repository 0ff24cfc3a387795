"""The systems that are timed, all of native FMI 2.0 FMUs."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from fmus.build import build
from orchestrator.scenario.compose import Composition, compose
from orchestrator.scenario.reading import load_scenario
from orchestrator.session import run_earlier
from orchestrator.system import Component, System

LAG = Path(__file__).with_name("models") / "lag.py"
DRIVE = "ball_screw_pole_placement/mc_ppc_track_500"
OPEN = ("K_x1", "K_x2", "K_v1", "K_v2", "K_i2")
GROWTH = (2, 10, 50, 200)

# steps of a timed run in which the C loop takes some tenths of a second
STEPS = {"pair": 400_000, "drive": 200_000}
STEPS |= {f"ring {n}": 2_000_000 // n for n in GROWTH}


def system(workload: str, steps: int) -> System:
    """Return ``pair``, ``drive`` or ``ring <n>``, to be run for so many steps."""
    if workload == "drive":
        return drive(steps)
    return ring(2 if workload == "pair" else int(workload.split()[1]), steps)


def ring(n: int, steps: int) -> System:
    """Return n lags in a ring at 1 kHz, every output recorded at every step."""
    T = Fraction(1, 1000)
    fmu = build(str(LAG))
    names = [f"lag{i}" for i in range(n)]
    return System(
        f"ring of {n}",
        steps * T,
        {
            name: Component(name, fmu, T, start={"state.x": float(i)})
            for i, name in enumerate(names)
        },
        {f"{name}.u": f"{names[i - 1]}.y" for i, name in enumerate(names)},
        dict.fromkeys((f"{name}.y" for name in names), (T,)),
    )


def drive(steps: int) -> System:
    """Return the ball-screw drive of the demo, its feedback gains set to 0.

    The peers add samples to the loop, which would make it unstable; the
    arithmetic is the same without.
    """
    return replace(driven().system, stop=Fraction(steps, 20_000))


def driven() -> Composition:
    """Return the scenario of the drive with its gains set to 0."""
    scenario = load_scenario(DRIVE, [f"controller.{gain}=0" for gain in OPEN])
    return compose(scenario, run_earlier)
