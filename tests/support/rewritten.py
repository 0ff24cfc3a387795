"""An FMU written again, its model description edited and files added."""

import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from lxml import etree

Edit: TypeAlias = Callable[[Any], None]
DESCRIPTION = "modelDescription.xml"


def rewritten(
    fmu: Path,
    folder: Path,
    edit: Edit | None = None,
    *,
    more: Mapping[str, str] | None = None,
    inside: str = "",
) -> Path:
    """Write an FMU into a folder; ``edit`` takes the root of its description.

    ``more`` adds or replaces files, ``inside`` goes before the name of every old one.
    """
    target = folder / "edited.fmu"
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            if name in (more or {}):
                continue
            content = old.read(name)
            if name == DESCRIPTION and edit is not None:
                root = etree.fromstring(content)
                edit(root)
                content = etree.tostring(root, encoding="UTF-8", xml_declaration=True)
            new.writestr(inside + name, content)
        for name, text in (more or {}).items():
            new.writestr(name, text)
    return target
