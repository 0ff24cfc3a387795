"""What an FMU says when it refuses reaches the user under its own name."""

from collections.abc import Callable

import pytest
from systems import part, system

from orchestrator.errors import SimulationError
from orchestrator.result import Result
from orchestrator.system import System


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_message_is_that_of_the_instance_that_failed(
    run: Callable[[System], Result], fmi: int
) -> None:
    start = {"u": 1e308, "state.x": 1e308}
    parts = [
        part("huge", "integrator", "1000", fmi=fmi, start=start),
        part("last", "counter", "1000", fmi=fmi),
    ]
    with pytest.raises(SimulationError, match=r"huge.*logged: .*huge: .*y is inf"):
        run(system("3000", parts, record={"huge.y": "1000"}))
