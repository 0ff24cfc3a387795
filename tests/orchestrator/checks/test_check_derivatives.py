"""Derivatives that an FMU gives are compared with those of its values."""

from pathlib import Path
from typing import Any

import pytest
from differentiable import differentiable
from rewritten import rewritten

from orchestrator.checks import check_fmu
from orchestrator.checks.item import Outcome

EXPORTED, DERIVATIVES, IN_TIME = 11, 22, 23


def outcome(fmu: Path, number: int = DERIVATIVES) -> Outcome:
    (only,) = check_fmu(fmu, only=[number]).outcomes
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


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    ("fault", "given"), [(0, None), (4, "nan"), (5, "-2."), (None, None)]
)
def test_derivatives_of_outputs_are_those_of_their_steps(
    tmp_path: Path, fmi: int, fault: int | None, given: str | None
) -> None:
    def forget(root: Any) -> None:
        if fault is None:
            root.find("CoSimulation").attrib.pop("maxOutputDerivativeOrder")

    fmu = differentiable(fmi, tmp_path, fault=fault or 0)
    texts = [
        f.text for f in outcome(rewritten(fmu, tmp_path, forget), IN_TIME).findings
    ]
    if fault is None:
        assert texts == ["maxOutputDerivativeOrder = 0, but a derivative is given"]
    elif given is None:
        assert texts == []
    else:
        assert texts[0].startswith(f"d y / d t = {given}")


@pytest.mark.parametrize("fmi", [2, 3])
def test_derivatives_that_are_given_undeclared_are_found(
    tmp_path: Path, fmi: int
) -> None:
    def forget(root: Any) -> None:
        for element in (root.find("CoSimulation"), root.find("ModelExchange")):
            for key in () if element is None else element.keys():
                if key.startswith("providesD"):
                    del element.attrib[key]

    fmu = rewritten(differentiable(fmi, tmp_path), tmp_path, forget)
    texts = [f.text for f in outcome(fmu, EXPORTED).findings]
    assert "directional derivatives are not declared, but given" in texts
