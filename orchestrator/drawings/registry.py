"""What ``figures.toml`` of a study says: the figures of its source, and how ours come.

``[not_drawn]`` gives the reason for each figure that is none of data, or that cannot
be drawn; every other table is a figure by its number::

    [fig_3_11]
    title = "Sensitivity magnitude"
    obtained = "computed"              # there: measured, computed
    why = "ideal plant; there the measured one"      # what is not as there
    columns = 2                        # panels beside each other
    call = "controllers.synthesis.ball_screw.curves:loop"
    [[fig_3_11.panels]]
    title = "(a) MC-PPC"
    x = { label = "frequency", unit = "Hz", log = true, range = [1, 400] }
    y = { label = "|S|" }
    curves = [{ name = "s-domain", of = "S", part = "magnitude", arguments = {} }]
    marks = [{ y = "mc_ppc.s_max" }]   # what the source prints, by the id of its row

A key of a curve may stand at its panel or at the figure; the nearer counts,
``arguments`` merge and ``set`` adds up.  ``base = "fig_6_7"`` takes over another
figure, key by key.  A curve has one source:

    scenario     a run's signal ``of``, less ``against``, times ``scale / per``, over
                 time or over the signal ``over`` less ``over_against``; ``window``
                 (s) takes a part, ``show`` its rate, spectrum, density (per root of
                 Hz), or, for a contour metric ``of``, the path, errors magnified;
                 ``design.<step>.<name>`` is an array that a design step has found
    vary         a figure ``of`` of a scenario against values of a key, or against
                 another figure ``over``
    broken       L, S or T (``of``) measured at a signal of the co-simulation from
                 ``lowest`` (Hz) up; of several signals the largest singular value
    call         ``of`` of the arrays that a function returns over the first of them
                 or over ``over``; of a complex one the real part (Nyquist plots)
    rows         figures of ``reference.toml``, ours ``at`` these places
    x_data       numbers that the source prints, with ``y_data``

``part`` takes magnitude, db, phase, real or imag; ``relative`` divides by the first
value, ``origin`` and ``x_origin`` count from the first value, from the last, or what is
left to the last.  Values are converted to the units of the axes, those of a function as
they are; then times ``factor`` and x to the ``power``.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from orchestrator.errors import ScenarioError, did_you_mean
from orchestrator.evaluation.schema import Strict
from orchestrator.scenario.complaints import complaints
from orchestrator.scenario.reading import read_toml

FILE = "figures.toml"
NOT_DRAWN = "not_drawn"
SOURCES = ("vary", "broken", "call", "rows", "x_data")
FROM_RUN = ("vary", "broken")  # sources that name a scenario besides

Part = Literal["magnitude", "db", "phase", "real", "imag"]
Origin = Literal["first", "last", "left"]
Numbers = tuple[float, ...]


class Curve(Strict):
    """One curve; keys as in the contract above."""

    name: str = ""
    style: Literal["line", "dashed", "dotted", "points", "line and points"] = "line"
    colour: int | None = Field(default=None, ge=0)
    of: str = ""
    against: str | None = None
    over: str | None = None
    over_against: str | None = None
    scenario: str | None = None
    set: tuple[str, ...] = Field(default=(), strict=False)
    scale: float | str = 1.0
    per: float | str = 1.0
    window: tuple[float, float] | None = Field(default=None, strict=False)
    show: Literal["signal", "rate", "spectrum", "density", "contour"] = "signal"
    vary: str | None = None
    values: Numbers = Field(default=(), strict=False)
    broken: str | None = None
    lowest: int = Field(default=1, ge=1)
    call: str | None = None
    arguments: dict[str, Any] = Field(default_factory=dict)
    rows: tuple[str, ...] = Field(default=(), strict=False)
    at: Numbers = Field(default=(), strict=False)
    published: bool = False
    x_data: Numbers = Field(default=(), strict=False)
    y_data: Numbers = Field(default=(), strict=False)
    factor: float = 1.0
    part: Part | None = None
    relative: bool = False
    power: int = 0
    origin: Origin | None = None
    x_origin: Origin | None = None

    @model_validator(mode="after")
    def _complete(self) -> Self:
        given = [key for key in SOURCES if getattr(self, key)]
        if len(given) > 1 or (not given and self.scenario is None):
            raise ValueError(
                "give one of scenario, vary, broken, call, rows, x_data"
                + f", not {' and '.join(given)}" * bool(given)
            )
        if self.source in FROM_RUN and self.scenario is None:
            raise ValueError(f"{self.source} needs the scenario")
        if self.source not in ("rows", "x_data") and not self.of:
            raise ValueError("of is missing: what is drawn")
        if len(self.rows) != len(self.at) or len(self.x_data) != len(self.y_data):
            raise ValueError("rows and at, x_data and y_data, are of one length")
        return self

    @property
    def source(self) -> str:
        """The key that says where the curve comes from."""
        return next((key for key in SOURCES if getattr(self, key)), "scenario")


class Axis(Strict):
    """An axis with its unit; ``range`` where it is not that of the curves."""

    label: str = ""
    unit: str = "1"
    log: bool = False
    range: tuple[float, float] | None = Field(default=None, strict=False)


class Mark(Strict):
    """What the source prints: a point, or a line where one of x and y is not given.

    Each is a number in the unit of the axis or the id of a row.
    """

    x: float | str | None = None
    y: float | str | None = None
    text: str = ""

    @model_validator(mode="after")
    def _somewhere(self) -> Self:
        if self.x is None and self.y is None:
            raise ValueError("give x, y or both")
        return self


class Panel(Strict):
    """Curves on one pair of axes."""

    title: str = ""
    x: Axis = Axis(label="time", unit="s")
    y: Axis
    equal: bool = False
    curves: tuple[Curve, ...] = Field(min_length=1, strict=False)
    marks: tuple[Mark, ...] = Field(default=(), strict=False)


class Drawn(Strict):
    """One figure of the source."""

    title: str
    obtained: Literal["measured", "computed"]
    why: str = ""
    columns: int = Field(default=1, ge=1, le=6)
    panels: tuple[Panel, ...] = Field(min_length=1, strict=False)


@dataclass(frozen=True)
class Registry:
    """A study's figures by number, and why the others are not drawn."""

    folder: Path
    figures: Mapping[str, Drawn]
    not_drawn: Mapping[str, str]

    def figure(self, number: str) -> Drawn:
        """Return a figure by its number.

        Raises:
            ScenarioError: it is not drawn, or there is none.
        """
        if number in self.figures:
            return self.figures[number]
        place = self.folder.name
        if number in self.not_drawn:
            reason = self.not_drawn[number]
            raise ScenarioError(f"{place}: {number} is not drawn: {reason}")
        remedy = did_you_mean(number, self.figures)
        raise ScenarioError(f"{place} has no figure {number!r}; {remedy}")


def read_registry(folder: Path) -> Registry:
    """Return the figures of the study in a folder.

    Raises:
        ScenarioError: the file is missing or says something wrong.
    """
    file = folder / FILE
    written = read_toml(file)
    not_drawn = {str(k): str(v) for k, v in written.pop(NOT_DRAWN, {}).items()}
    figures = {}
    for number, table in written.items():
        try:
            whole = _with_base(number, table, written)
            figures[number] = Drawn.model_validate(_spread(whole))
        except ValidationError as error:
            told = "; ".join(f"{number}: {text}" for text in complaints(error))
            raise ScenarioError(f"{file}: {told}") from None
        except ValueError as error:
            raise ScenarioError(f"{file}: {number}: {error}") from None
    return Registry(folder, figures, not_drawn)


def _with_base(
    number: str, table: Any, written: Mapping[str, Any], depth: int = 0
) -> dict[str, Any]:
    if not isinstance(table, dict):
        raise ValueError("is no table")
    if "base" not in table:
        return dict(table)
    base = table["base"]
    if base not in written or depth > 3:
        raise ValueError(f"base {base!r}: {did_you_mean(str(base), written)}")
    own = {key: value for key, value in table.items() if key != "base"}
    return _with_base(base, written[base], written, depth + 1) | own


def _spread(table: Mapping[str, Any]) -> dict[str, Any]:
    """Hand the keys of curves that stand at the figure or a panel to its curves."""
    keys = Curve.model_fields.keys()
    own = {k: v for k, v in table.items() if k in keys and k not in Drawn.model_fields}
    figure = {k: v for k, v in table.items() if k not in own}
    panels = figure.get("panels")
    if isinstance(panels, list) and all(isinstance(panel, dict) for panel in panels):
        figure["panels"] = [_spread_panel(panel, own, keys) for panel in panels]
    return figure


def _spread_panel(
    panel: Mapping[str, Any], outer: Mapping[str, Any], keys: Any
) -> dict[str, Any]:
    own = {k: v for k, v in panel.items() if k in keys}
    rest = {k: v for k, v in panel.items() if k not in own}
    handed = _nearer(outer, own)
    curves = rest.get("curves", [{}])
    if isinstance(curves, list) and all(isinstance(curve, dict) for curve in curves):
        rest["curves"] = [_nearer(handed, curve) for curve in curves]
    return rest


def _nearer(outer: Mapping[str, Any], inner: Mapping[str, Any]) -> dict[str, Any]:
    both = {**outer, **inner}
    if "arguments" in outer and "arguments" in inner:
        both["arguments"] = {**outer["arguments"], **inner["arguments"]}
    if "set" in outer and "set" in inner:
        both["set"] = [*outer["set"], *inner["set"]]
    return both
