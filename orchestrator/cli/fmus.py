"""Verbs about models and FMU files: ``models``, ``build``, ``info``."""

import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orchestrator.cli.output import (
    command,
    echo,
    executing,
    print_json,
    print_table,
    waiting,
)
from orchestrator.plugins import named
from orchestrator.quantities.quantity import parse_period, rate, time_text

if TYPE_CHECKING:
    from fmus.model import Model
    from orchestrator.fmu.description import FmuDescription

PACKAGES = ("plants", "controllers")
Json = Annotated[bool, typer.Option("--json", help="print one JSON object")]


@command
def models(json: Json = False) -> None:
    """List the models there are, and the forms that each can be built in."""
    from fmus.build import load_model

    found = [_model_facts(name, load_model(name)) for name in model_modules()]
    if json:
        print_json({"models": found})
        return
    rows = [
        [
            m["module"],
            m["kind"],
            rate(parse_period(m["period"])) if m["period"] else "",
            ", ".join(m["forms"]),
            m["description"],
        ]
        for m in found
    ]
    print_table(["module", "kind", "sample time", "forms", "description"], rows)


def model_modules() -> Iterator[str]:
    """Yield the dotted names of all public model modules, ours and then others'."""
    for package in (*PACKAGES, *(entry.value for entry in named("models").values())):
        for folder in importlib.import_module(package).__path__:
            for file in sorted(Path(folder).rglob("[!_]*.py")):
                parts = file.relative_to(folder).with_suffix("").parts
                if (package, parts[0]) != ("controllers", "synthesis"):
                    yield ".".join((package, *parts))


def _model_facts(module: str, model: "Model") -> dict[str, Any]:
    from fmus.model import Continuous, Sampled

    sampled = isinstance(model, Sampled)
    exchange = isinstance(model, Continuous) and not (model.advance or model.delay)
    source = importlib.import_module(module).__doc__ or ""
    return {
        "module": module,
        "name": model.name,
        "kind": "sampled" if sampled else "continuous",
        "period": time_text(model.period) if isinstance(model, Sampled) else None,
        "forms": [
            "FMI 2",
            "FMI 3",
            *(["model exchange"] if exchange else []),
            "Python",
            *(["C"] if sampled else []),
        ],
        "description": source.strip().partition("\n")[0].rstrip("."),
    }


@executing
def info(
    fmu: Annotated[str, typer.Argument(metavar="FMU", help="an .fmu file or a module")],
    json: Json = False,
) -> None:
    """Show what an FMU says of itself: kind, platforms, variables with units."""
    import fmus.build
    from orchestrator.fmu.description import read_fmu

    if fmu.endswith(".fmu"):
        described = read_fmu(fmu)
    else:
        with waiting(f"building {fmu}"):
            described = read_fmu(fmus.build.build(fmu))
    facts = _facts(described)
    if json:
        print_json(facts)
        return
    variables = facts.pop("variables")
    echo(f"{facts.pop('name')}: {facts.pop('description')}")
    for key, value in facts.items():
        text = ", ".join(value) if isinstance(value, list) else str(value)
        echo(f"  {key.replace('_', ' '):14} {text}")
    head = ("name", "causality", "variability", "unit", "start", "min", "max")
    print_table(
        [*head, "description"],
        [[str(v[key] or "") for key in (*head, "description")] for v in variables],
    )


def _steps(d: "FmuDescription") -> str:
    """Say which communication steps an FMU takes, and which it suggests."""
    words = ["any" if d.variable_step else "equal ones only"]
    if d.internal_step is not None:
        words.append(f"multiples of {float(d.internal_step):g} s")
    if d.default_step is not None:
        words.append(f"suggests {d.default_step:g} s")
    return ", ".join(words)


def _facts(d: "FmuDescription") -> dict[str, Any]:
    interfaces = {"co-simulation": d.co_simulation, "model exchange": d.model_exchange}
    return {
        "name": d.model_name,
        "description": d.description,
        "file": str(d.path),
        "fmi": d.fmi_major,
        "interfaces": [name for name, there in interfaces.items() if there],
        "kind": d.kind or "not stated",
        "period": time_text(d.period) if d.period else "none",
        "steps": _steps(d),
        "platforms": list(d.platforms),
        "tool": d.tool,
        "token": d.token,
        "variables": [
            {
                "name": v.name,
                "causality": v.causality,
                "variability": v.variability,
                "unit": v.unit,
                "start": v.start,
                "min": v.min,
                "max": v.max,
                "description": v.description,
            }
            for v in d.variables.values()
        ],
    }
