"""Which public models there are, and which of them exist for model exchange."""

from importlib import import_module
from pathlib import Path

import controllers
import plants
from fmus.model import Continuous


def _public(package):
    top = Path(package.__file__).parent
    for file in top.rglob("[!_]*.py"):
        name = file.relative_to(top.parent).with_suffix("")
        if "synthesis" not in name.parts:
            yield ".".join(name.parts)


MODULES = sorted([*_public(plants), *_public(controllers)])
EXCHANGED = [
    m
    for m in MODULES
    if isinstance(model := import_module(m).model, Continuous)
    and not (model.advance or model.delay)
]
