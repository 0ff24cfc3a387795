"""What the tests of the studies share."""

import pytest
from simulated import Co, simulated

from orchestrator.outcome import Run


@pytest.fixture(scope="module")
def co_simulated(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Co:
    """Return a function that runs a scenario of the module's STUDY, each one once."""
    done: dict[tuple[str, ...], Run] = {}

    def get(scenario: str, *overrides: str) -> Run:
        key = (scenario, *overrides)
        if key not in done:
            named = f"{request.module.STUDY}/{scenario}"
            done[key] = simulated(tmp_path_factory.mktemp("run"), named, *overrides)
        return done[key]

    return get
