"""A design of ours is carried out once for the same arguments, others always."""

from pathlib import Path

import numpy as np
import pytest

from orchestrator.scenario.design_cache import Values, remembered

OURS = "controllers.synthesis.ball_screw.pole_placement:design"


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FEEDDRIVE_CACHE", str(tmp_path))


def test_the_same_arguments_give_the_same_values_without_a_call() -> None:
    calls: list[int] = []

    def compute() -> Values:
        calls.append(1)
        return {"K": 0.1 + 0.2, "on": True, "w": (1.0, 2.0)}

    arguments = {"beta": 4.0, "w": np.array([1.0, 2.0])}
    first, second = (remembered(OURS, arguments, compute) for _ in range(2))
    assert first == second == {"K": 0.1 + 0.2, "on": True, "w": (1.0, 2.0)}
    assert len(calls) == 1
    remembered(OURS, arguments | {"beta": 5.0}, compute)
    remembered(OURS, arguments | {"w": np.array([[1.0, 2.0]])}, compute)
    assert len(calls) == 3


@pytest.mark.parametrize("call", ["somewhere.design:f", "controllers.no_such:f"])
def test_what_is_not_ours_is_called_every_time(call: str) -> None:
    calls: list[int] = []

    def compute() -> Values:
        calls.append(1)
        return {}

    remembered(call, {}, compute)
    remembered(call, {}, compute)
    assert len(calls) == 2
