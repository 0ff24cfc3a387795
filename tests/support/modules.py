"""Which public models there are, and which of them exist for model exchange."""

import pkgutil
from importlib import import_module

import controllers
import plants
from fmus.model import Continuous

MODULES = sorted(
    f"{package.__name__}.{found.name}"
    for package in (plants, controllers)
    for found in pkgutil.iter_modules(package.__path__)
    if not found.name.startswith("_") and not found.ispkg
)
EXCHANGED = [
    m
    for m in MODULES
    if isinstance(model := import_module(m).model, Continuous)
    and not (model.advance or model.delay)
]
