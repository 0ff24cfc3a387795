"""The FMUs of a composition, with binaries for the platforms that are asked for."""

from collections.abc import Sequence
from pathlib import Path

from fmus.build import build, load_model
from fmus.compile import PLATFORMS
from fmus.model import Sampled
from orchestrator.errors import ScenarioError
from orchestrator.scenario.compose import Composition


def fmu_for(composition: Composition, name: str, platforms: Sequence[str]) -> Path:
    """Return a component's FMU; a model of ours is built anew for the platforms.

    Raises:
        ScenarioError: it is none of ours and has no binary for one of them.
        fmus.build.BuildError: there is no such platform, or it does not compile.
    """
    fmu, source = composition.fmus[name], composition.sources[name]
    lacking = [
        p
        for p in platforms
        if p not in PLATFORMS or _folder(p, fmu.fmi_major) not in fmu.platforms
    ]
    if not lacking:
        return fmu.path
    spec = composition.scenario.spec.components[name]
    if spec.data is not None or source.endswith(".fmu"):
        raise ScenarioError(
            f"--platform {lacking[0]}: {name} ({source}) has no binary for it; it has "
            f"{', '.join(fmu.platforms) or 'none'}"
        )
    module = composition.module(name)
    sampled = isinstance(load_model(module), Sampled)
    period = composition.system.components[name].period if sampled else None
    return build(
        module, fmi=composition.scenario.spec.fmi, period=period, platforms=platforms
    )


def _folder(platform: str, fmi: int) -> str:
    kind = PLATFORMS[platform]
    return kind.fmi2_folder if fmi == 2 else kind.fmi3_folder
