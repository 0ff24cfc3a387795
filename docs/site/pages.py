"""Pages of the site that are made of the code: a page per model, the verbs.

Nothing in them is typed twice: a model's page is its docstring, its traced variables
and the response its FMU carries; a verb's is what ``--help`` says.
"""

import html
import inspect
import re
from collections.abc import Iterator
from typing import Any

import typer
from lxml import etree
from mathml import equation

from fmus.description import suggested_step
from fmus.evidence import block, curves, response
from fmus.model import Sampled
from fmus.package import subject_of
from fmus.subject import Subject, role
from orchestrator.cli import app
from orchestrator.quantities.quantity import rate

SHOWN = 6  # start values of an array that are written out


def model_page(module: str) -> str:
    """Return a model's page: equations, picture, parameters, variables."""
    subject = subject_of(module)
    found = response(subject)
    parts = [
        f"# {module}\n",
        _prose(subject.text),
        _block(etree.tostring(block(subject), encoding="unicode")),
        _kind(subject),
    ]
    if found is not None:
        told = ", ".join(f"{name} = {value:g}" for name, value in found.inputs.items())
        parts.append(f"Response from the start values{' to ' if told else ''}{told}:\n")
        parts.append(_block(etree.tostring(curves(found), encoding="unicode")))
    for kind in ("input", "output", "parameter", "local"):
        parts += _variables(subject, kind)
    parts.append(
        "```bash\n"
        f"feeddrive build {module}\n"
        "```\n\n[What may stand in a model](../models.md) · [All models](index.md)\n"
    )
    return "\n".join(parts)


def _kind(subject: Subject) -> str:
    model = subject.model
    if isinstance(model, Sampled):
        held = "held in the FMU" if model.period_fixed else "another one with `build`"
        return f"Sampled, every {rate(model.period)}; {held}.\n"
    return f"Continuous; suggested step {suggested_step(model):g} s.\n"


def _prose(text: str) -> str:
    """Return a docstring as Markdown, its indented lines as equations."""
    parts: list[str] = []
    for paragraph in re.split(r"\n\s*\n", inspect.cleandoc(text)):
        lines = paragraph.splitlines()
        if all(line.startswith("    ") for line in lines):
            parts.append(_block("".join(map(equation, _joined(lines)))))
        else:
            parts.append(html.escape(paragraph, quote=False).replace("*", r"\*") + "\n")
    return "\n".join(parts)


def _joined(lines: list[str]) -> Iterator[str]:
    """Yield equations; a line that is set deeper goes on with the one before it."""
    least = min(len(line) - len(line.lstrip()) for line in lines)
    whole = ""
    for line in lines:
        deeper = len(line) - len(line.lstrip()) > least
        if whole and not deeper:
            yield whole
            whole = ""
        whole = f"{whole} {line.strip()}" if whole else line.strip()
    yield whole


def _block(inner: str) -> str:
    return f'<div class="drawn">{inner}</div>\n'


def _variables(subject: Subject, kind: str) -> list[str]:
    title = {"local": "States"}.get(kind, f"{kind.capitalize()}s")
    rows = []
    for variable in subject.layout.variables:
        causality, variability, _ = role(variable, subject.model)
        if causality != kind:
            continue
        start = ", ".join(f"{v:.6g}" for v in variable.start[:SHOWN])
        more = ", …" if len(variable.start) > SHOWN else ""
        size = f" ({'×'.join(map(str, variable.shape))})" if variable.shape else ""
        unit = "switch" if variable.boolean else variable.var.unit
        how = f" ({variability})" if variability in ("constant", "fixed") else ""
        meaning = cell(variable.var.description) + how
        rows.append(
            f"| `{variable.name}`{size} | {meaning} | {cell(unit)} | {start}{more} |"
        )
    if not rows:
        return []
    return [
        f"## {title}\n",
        "| name | meaning | unit | start |",
        "|---|---|---|---|",
        *rows,
        "",
    ]


def cell(text: str) -> str:
    return html.escape(text, quote=False).replace("|", r"\|").replace("*", r"\*")


def models_page(modules: dict[str, str]) -> str:
    """Return the list of models by drive and role, each with its first line."""
    parts = ["# Models\n", "Each is an FMU of its own: `feeddrive build NAME`.\n"]
    room = ""
    for module, line in modules.items():
        above = module.rpartition(".")[0]
        if above != room:
            parts += [f"\n## {above}\n", "| model | what it is |", "|---|---|"]
            room = above
        parts.append(f"| [{module}]({module}.md) | {cell(line)} |")
    return "\n".join(parts) + "\n"


def verbs_page() -> str:
    """Return every verb with its arguments and options, as ``--help`` has them."""
    group = typer.main.get_command(app)
    parts = ["# Verbs\n", "`feeddrive VERB --help` prints the same.\n"]
    for name, verb in sorted(group.commands.items()):  # type: ignore[attr-defined]
        parts.append(f"## {name}\n\n{html.escape(verb.help or '', quote=False)}\n")
        rows = [_option(p) for p in verb.params if p.name != "help"]
        parts += (
            ["| name | takes | meaning |", "|---|---|---|", *rows, ""] if rows else []
        )
    return "\n".join(parts)


def _option(parameter: Any) -> str:
    names = ", ".join(f"`{o}`" for o in parameter.opts + parameter.secondary_opts)
    if parameter.param_type_name == "argument":
        names = f"`{parameter.name.upper()}`"
    takes = cell(parameter.metavar or "")
    said = (getattr(parameter, "help", None) or "").replace("\n", " ")
    return f"| {names} | {takes} | {cell(said)} |"
