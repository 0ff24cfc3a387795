"""The keys of a scenario as a page, read off the schema that refuses wrong ones."""

import html
import inspect
import re
from fractions import Fraction
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pages import cell
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from orchestrator.evaluation import schema as metrics
from orchestrator.scenario.component import ComponentSpec, ExperimentSpec
from orchestrator.scenario.maps import MapSpec
from orchestrator.scenario.responses import ResponseSpec
from orchestrator.scenario.schema import (
    DesignSpec,
    FaultSpec,
    Specification,
    ToleranceSpec,
)

TABLES: dict[str, type[BaseModel]] = {
    "The file": Specification,
    "[components.NAME]": ComponentSpec,
    "[components.NAME.experiment]": ExperimentSpec,
    "[components.NAME.map]": MapSpec,
    "[design.NAME]": DesignSpec,
    '[faults] "component.input"': FaultSpec,
    "[responses] NAME": ResponseSpec,
    '[tolerances] "component.parameter"': ToleranceSpec,
    "[expect] FIGURE": metrics.Expectation,
    "expect_like": metrics.Likeness,
}
WORDS = {
    str: "text",
    float: "number",
    int: "whole number",
    bool: "true, false",
    Fraction: "time or rate",
    Any: "any value",
}


def keys_page() -> str:
    """Return every key of a scenario file with its type and default."""
    parts = [
        "# Keys of a scenario\n",
        "A key that is not in these tables is refused with the nearest that is. What "
        "they mean: [scenarios](../scenarios.md).\n",
    ]
    for title, table in (TABLES | _metrics()).items():
        about = inspect.cleandoc(table.__doc__ or "")
        parts += [f"## {cell(title)}\n", html.escape(about, quote=False) + "\n"]
        rows = [_row(*field) for field in table.model_fields.items()]
        parts += ["| key | takes | without it |", "|---|---|---|", *rows, ""]
    return "\n".join(parts)


def _metrics() -> dict[str, type[BaseModel]]:
    found = {}
    for name, table in vars(metrics).items():
        if name.endswith("Metric") and "kind" in getattr(table, "model_fields", {}):
            kinds = get_args(table.model_fields["kind"].annotation)
            found[f"[metrics] kind = {', '.join(kinds)}"] = table
    return found


def _row(name: str, field: FieldInfo) -> str:
    default = field.get_default(call_default_factory=True)
    if field.is_required():
        told = "needed"
    elif default is None or default in ("", (), {}) or isinstance(default, BaseModel):
        told = ""
    else:
        told = f"`{default}`".lower() if isinstance(default, bool) else f"`{default}`"
    return f"| `{field.alias or name}` | {cell(takes(field.annotation))} | {told} |"


def takes(kind: Any) -> str:
    """Return in words what a key takes."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return takes(inner[0])
    if origin in (Union, UnionType):
        return " or ".join(dict.fromkeys(takes(k) for k in inner if k is not NoneType))
    if origin is Literal:
        return ", ".join(f"`{value}`" for value in inner)
    if origin is dict:
        return f"table of {takes(inner[1])}"
    if origin is tuple and inner[-1] is Ellipsis:
        return f"list of {takes(inner[0])}"
    if origin is tuple:
        return f"[{', '.join(map(takes, inner))}]"
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return f"{re.sub('(Spec|Metric)$', '', kind.__name__).lower()} table"
    return WORDS[kind]
