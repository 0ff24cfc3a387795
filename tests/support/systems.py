"""Small systems of test models, built natively."""

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from fmus.build import build
from fmus.trust import trust
from orchestrator.system import Component, Fault, Mapped, System

MODELS = Path(__file__).parents[1] / "orchestrator" / "models"
SMALL = Path(__file__).parents[1] / "fmus" / "small_models"


def trusted(fmu: Path) -> Path:
    """Return a copy of an FMU that counts as built here, and may run in this process.

    It has other bytes than the FMU, which does not.
    """
    copy = fmu.parent / "trusted" / fmu.name
    copy.parent.mkdir(exist_ok=True)
    copy.write_bytes(fmu.read_bytes())
    with ZipFile(copy, "a") as archive:
        archive.comment = b"trusted"
    trust(copy)
    return copy


def part(name: str, model: str, period: str, **options: Any) -> Component:
    """Return a component of a test model (``counter``) or of ours (``plants.x``)."""
    module = model if "." in model else str(MODELS / f"{model}.py")
    T = Fraction(period)
    sampled = model in ("counter", "memory") or options.pop("sampled", False)
    fmi = options.pop("fmi", 2)
    fmu = build(module, fmi=fmi, period=T if sampled else None)
    options["offset"] = Fraction(options.get("offset", 0))
    return Component(name, fmu, T, **options)


def system(
    stop: str,
    components: list[Component],
    connections: Mapping[str, str] | None = None,
    record: Mapping[str, str] | None = None,
) -> System:
    """Return a system; rows as ``{"plant.x": "1/1000"}``."""
    return System(
        "test",
        Fraction(stop),
        {c.name: c for c in components},
        connections or {},
        {name: (Fraction(period),) for name, period in (record or {}).items()},
    )


def controller(kind: str) -> Component:
    file = build(str(SMALL / "pi.py"), kind=kind, period=Fraction(1, 1000))  # type: ignore[arg-type]
    start = {"r": 1.0}
    return Component("pi", file, Fraction(1, 1000), kind="sampled", start=start)


def lag() -> System:
    file, per = build(str(SMALL / "late.py")), {"u": Mapped("u", 2.0, 0.0, "N.m")}
    plant = Component("late", file, Fraction(1, 1000), map=per)
    wires = {"late.u": "pi.u"}
    return system("1/50", [controller("native"), plant], wires, {"late.y": "1/1000"})


def mixed() -> System:
    """Dead time, a latency, several rates with an offset, a fault with a memory."""
    slow = replace(controller("native"), name="slow", period=Fraction(1, 1000))
    slow = replace(
        slow, offset=Fraction(1, 3000), map={"y": Mapped("y", 1.0, 0.0, "V")}
    )
    late = Fault("delay", 0.0, 2, Fraction(1, 200), None)
    given = lag()
    pi = replace(given.components["pi"], latency=2)
    return replace(
        given,
        components={**given.components, "pi": pi, "slow": slow},
        connections={**given.connections, "slow.y": "late.y"},
        record={"late.y": (Fraction(1, 1000),), "slow.u": (Fraction(1, 500),)},
        faults={"late.u": (late,)},
    )
