"""Small systems of test models, built natively."""

from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from fmus.build import build
from fmus.trust import trust
from orchestrator.system import Component, System

MODELS = Path(__file__).parents[1] / "orchestrator" / "models"


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
