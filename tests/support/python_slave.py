"""Small Python FMUs, driven by the names of their variables."""

from pathlib import Path

from fmus.build import build

MODELS = Path(__file__).parents[1] / "fmus" / "small_models"


def start(instance, **values):
    instance.setupExperiment()
    instance.enterInitializationMode()
    put(instance, **values)
    instance.exitInitializationMode()
    return instance


def put(instance, **values):
    names = [instance.references[name] for name in values]
    instance.setReal(names, list(values.values()))


def read(instance, *names):
    return instance.getReal([instance.references[name] for name in names])


def python_fmu(name):
    return build(str(MODELS / f"{name}.py"), kind="python")
