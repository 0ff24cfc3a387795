"""Derivatives that an FMU gives are compared with those of its values."""

from pathlib import Path

import pytest
from differentiable import differentiable

from orchestrator.checks import check_fmu
from orchestrator.checks.item import Outcome

DERIVATIVES = 22


def outcome(fmu: Path) -> Outcome:
    (only,) = check_fmu(fmu, only=[DERIVATIVES]).outcomes
    return only


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("shows", [0, 1])
def test_right_derivatives_pass(tmp_path: Path, fmi: int, shows: int) -> None:
    it = outcome(differentiable(fmi, tmp_path, shows=shows))
    assert it.verdict == "pass", it
    if not shows:
        assert "by co-simulation no output shows an input at once" in str(it.seen)


@pytest.mark.parametrize("fmi", [2, 3])
def test_derivatives_that_remain_those_of_the_start_are_found(
    tmp_path: Path, fmi: int
) -> None:
    texts = [f.text for f in outcome(differentiable(fmi, tmp_path, fault=2)).findings]
    assert not any("in initialisation" in text for text in texts)
    assert any(text.startswith("by co-simulation d y / d a = 2, ") for text in texts)


def test_derivatives_of_the_wrong_sign_are_found_everywhere(tmp_path: Path) -> None:
    texts = [f.text for f in outcome(differentiable(3, tmp_path, fault=3)).findings]
    assert "in initialisation d y / d b[1] = -6, should be 6" in texts
    for where in ("in initialisation", "by co-simulation", "by model exchange"):
        assert any(t.startswith(f"{where} d z[1] / d b[0] = -") for t in texts)
        assert any(
            t.startswith(f"{where} the adjoint of d z[1] / d b[0]") for t in texts
        )
    assert any("by model exchange d der(x) / d x = 1, should be -1" for t in texts)


@pytest.mark.parametrize("shows", [0, 1])
def test_an_adjoint_that_is_none_is_found(tmp_path: Path, shows: int) -> None:
    texts = [
        f.text
        for f in outcome(differentiable(3, tmp_path, fault=1, shows=shows)).findings
    ]
    assert texts
    assert all("the adjoint of" in text for text in texts)
    assert any(text.startswith("by co-simulation the adjoint of d y") for text in texts)
