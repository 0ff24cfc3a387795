"""One metric of every kind of ours, of an FMU ``bad`` with input u and output y.

``plugin`` is refused before a run where no package adds one (test_plugins.py).
"""

from typing import Any, get_args

from pydantic import BaseModel

from orchestrator.evaluation.schema import MetricSpec

_MORE: dict[str, dict[str, Any]] = {
    "error": {"against": "bad.u"},
    "settling": {},
    "sine": {"frequency_hz": 20, "against": "bad.u"},
    "spectrum": {"frequency_hz": 20},
    "onset": {"ramp": "bad.u", "piece": 0.01},
    "step": {"height": 1.0, "band": 0.1},
    "contour": {"across": "bad.u", "shape": "circle", "size": 1.0},
    "sustained": {"level": "bad.u", "dwell": "1/50", "tail": "1/100", "span": 0.1},
}


def _kinds() -> list[str]:
    union: Any = get_args(MetricSpec)[0]
    models: list[type[BaseModel]] = list(get_args(union))
    fields = [get_args(model.model_fields["kind"].annotation) for model in models]
    return [kind for literals in fields for kind in literals]


METRICS = {
    kind: {"kind": kind, "of": "bad.y", **_MORE.get(kind, {})}
    for kind in _kinds()
    if kind != "plugin"
}
