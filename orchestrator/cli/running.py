"""What several verbs do with a scenario: load it as the options say, and run it."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orchestrator.cli.output import progress_bar, waiting

if TYPE_CHECKING:
    from orchestrator.outcome import Run
    from orchestrator.scenario.reading import Scenario


def load(
    name: str,
    sets: list[str],
    swaps: list[str],
    maps: list[str],
    fmi: int | None,
    variant: str | None = None,
    sockets: Sequence[str] = (),
    ssv: Sequence[str] = (),
) -> "Scenario":
    """Return the scenario that the options of a verb describe, or that of a package.

    ``variant`` is for a package of several systems, ``ssv`` for any package.
    """
    from fmus.allowed import trusts_all
    from orchestrator.errors import ScenarioError
    from orchestrator.exchange.ssp.package import is_package, sources_anywhere
    from orchestrator.scenario.override import parse_swaps
    from orchestrator.scenario.reading import load_scenario

    overrides = [*sets, *([] if fmi is None else [f"fmi={fmi}"])]
    put = parse_swaps(swaps, maps, sockets)
    if is_package(name):
        from orchestrator.exchange.ssp.load import load_package

        with sources_anywhere(trusts_all()):
            return load_package(name, overrides, put, variant, ssv)
    if ssv:
        raise ScenarioError(f"--ssv: {name} is no package of SSP")
    if variant is not None:
        raise ScenarioError(f"--variant: {name} is no package of several systems")
    return load_scenario(name, overrides, put)


def simulate(scenario: "Scenario", folder: Path | None = None, **options: Any) -> "Run":
    """Run a scenario with its progress on stderr; options as for ``execute``."""
    from orchestrator.scenario.compose import compose
    from orchestrator.session import execute, naming, run_earlier

    with naming(scenario):
        with waiting(f"building the FMUs of {scenario.name}"):
            warm = options.get("origin") is not None
            composition = compose(scenario, run_earlier, warm=warm)
        with progress_bar(scenario.name, composition.system.stop) as progress:
            return execute(composition, folder, progress=progress, **options)
