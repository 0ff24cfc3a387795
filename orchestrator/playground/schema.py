"""What ``pages.toml`` says of a page: a scenario, and what is moved in it."""

from functools import cache
from pathlib import Path

from pydantic import Field

from orchestrator.evaluation.schema import Strict
from orchestrator.scenario.reading import read_toml

FILE = Path(__file__).with_name("pages.toml")


class Rate(Strict):
    """Rates to choose from, each as ``--set`` takes it for the key."""

    key: str
    values: tuple[str, ...] = Field(strict=False)
    start: str


class Latency(Strict):
    """Latencies of the components, all the same: 0 to ``most`` samples."""

    components: tuple[str, ...] = Field(strict=False)
    most: int
    start: int


class Slider(Strict):
    """Parameters that are multiplied together, from ``low`` to ``high`` times.

    Without ``label`` it is called as the first is described.
    """

    label: str | None = None
    parameters: tuple[str, ...] = Field(strict=False)
    low: float
    high: float


class PageSpec(Strict):
    """A page: ``switches`` are Boolean parameters."""

    scenario: str
    title: str
    about: str
    rate: Rate
    latency: Latency
    switches: tuple[str, ...] = Field(default=(), strict=False)
    sliders: tuple[Slider, ...] = Field(default=(), strict=False)


@cache
def pages() -> dict[str, PageSpec]:
    """Return the pages by name.

    Raises:
        ScenarioError: the file is no TOML.
        pydantic.ValidationError: a key is wrong.
    """
    return {n: PageSpec.model_validate(t) for n, t in read_toml(FILE).items()}
