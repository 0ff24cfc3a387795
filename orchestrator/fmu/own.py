"""Kind and exact sample period, which our own FMUs carry in a file beside."""

from fractions import Fraction
from pathlib import Path
from typing import Any, cast, get_args

from fmus.archive import EXTRA
from orchestrator.errors import FmuError
from orchestrator.fmu.archive import checked_members, read_member
from orchestrator.quantities.quantity import exact
from orchestrator.system import Kind


def kind_and_period(path: Path, root: Any) -> tuple[Kind | None, Fraction | None]:
    """Return kind and exact period that our own FMUs carry, built today or before."""
    from lxml import etree

    place = EXTRA
    try:
        if any(member.filename == EXTRA for member in checked_members(path)):
            return _told(etree.fromstring(read_member(path, EXTRA)))
        place = "modelDescription.xml"
        for note in root.iter("{*}Tool", "{*}Annotation"):
            if "feeddrive" in (note.get("name"), note.get("type")):
                for model in note.iter("{*}Model"):
                    return _told(model)
    except (etree.XMLSyntaxError, ValueError, ZeroDivisionError) as error:
        raise FmuError(
            f"{path}: kind and period in {place} cannot be understood ({error}); "
            f"build the FMU again"
        ) from None
    return None, None


def _told(model: Any) -> tuple[Kind, Fraction | None]:
    kind, period = model.get("kind"), model.get("period")
    if kind not in get_args(Kind):
        raise ValueError(f"kind = {kind!r}")
    return cast(Kind, kind), exact(period) if period else None
