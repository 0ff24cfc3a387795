"""Dependencies and their kinds are tried, in initialisation and while stepping."""

from pathlib import Path
from typing import Any

import pytest
from differentiable import differentiable
from rewritten import Edit, rewritten

from fmus.build import build
from orchestrator.checks import check_fmu
from orchestrator.checks.item import Finding

# of differentiable.c: knowns a 0, b 1, x 3; unknowns y 4, z 5, der(x) 7
TRUE = {
    "4": ("0 1 3", "dependent dependent constant"),
    "5": ("0 1", "dependent dependent"),
    "7": ("0 3", "dependent dependent"),
}


def found(fmu: Path) -> list[Finding]:
    report = check_fmu(fmu, only=[6])
    (outcome,) = [o for o in report.outcomes if o.item.part == "dynamic"]
    assert outcome.verdict in ("pass", "finding"), outcome.reason
    return outcome.findings


def declared(table: dict[str, tuple[str, str]], *, exchange: bool = True) -> Edit:
    """Give the unknowns dependencies, those in initialisation as they are."""

    def edit(root: Any) -> None:
        for unknown in root.find("ModelStructure"):
            at_start = unknown.tag == "InitialUnknown"
            row = (TRUE if at_start else table)[unknown.get("valueReference")]
            unknown.set("dependencies", row[0])
            if not at_start:
                unknown.set("dependenciesKind", row[1])
        if not exchange:
            root.remove(root.find("ModelExchange"))
        simulation = root.find("CoSimulation")
        simulation.set("canHandleVariableCommunicationStepSize", "true")

    return edit


@pytest.mark.parametrize("shows", [0, 1])
def test_true_dependencies_pass(tmp_path: Path, shows: int) -> None:
    fmu = differentiable(3, tmp_path, shows=shows)
    assert found(rewritten(fmu, tmp_path, declared(TRUE))) == []


def test_an_effect_between_steps_that_is_not_listed_is_found(tmp_path: Path) -> None:
    table = TRUE | {"4": ("0 3", "dependent constant"), "7": ("0", "dependent")}
    fmu = rewritten(differentiable(3, tmp_path), tmp_path, declared(table))
    texts = [f.text for f in found(fmu) if f.severity == "error"]
    assert texts == [
        "between steps y changes with b, which ModelStructure does not list",
        "by model exchange y changes with b, which ModelStructure does not list",
        "by model exchange der(x) changes with x, which ModelStructure does not list",
    ]


def test_an_effect_of_no_time_is_told_where_outputs_wait_for_a_step(
    tmp_path: Path,
) -> None:
    """Outputs may follow inputs through states, but not within a moment."""
    table = TRUE | {"5": ("1", "dependent")}
    edit = declared(table, exchange=False)
    fmu = rewritten(differentiable(3, tmp_path, shows=0), tmp_path, edit)
    (only,) = found(fmu)
    assert only.severity == "advice"
    assert only.text == (
        "z changes in a step of 1e-09 s as much as in one of 0.001 s with a, which "
        "ModelStructure does not list"
    )


@pytest.mark.parametrize("kind", ["constant", "fixed", "tunable"])
def test_a_kind_that_does_not_hold_is_found(tmp_path: Path, kind: str) -> None:
    table = TRUE | {"4": ("0 1 3", f"{kind} dependent constant")}
    fmu = rewritten(differentiable(3, tmp_path), tmp_path, declared(table))
    first, second = found(fmu)
    assert first.text.startswith("between steps d y / d a is between ")
    assert second.text.startswith("by model exchange d y / d a is between ")
    assert second.text.endswith(f"but dependenciesKind is {kind}")


def forget(tag: str) -> Edit:
    """Let the unknowns of a list depend on nothing."""

    def edit(root: Any) -> None:
        for unknown in root.find(f"ModelStructure/{tag}"):
            unknown.set("dependencies", "")
            unknown.attrib.pop("dependenciesKind", None)

    return edit


def make_constant(root: Any) -> None:
    for unknown in root.iter("Unknown"):
        kinds = unknown.get("dependenciesKind", "")
        if kinds:
            unknown.set("dependenciesKind", kinds.replace("tunable", "constant"))


@pytest.mark.parametrize(
    ("module", "edit", "expected"),
    [
        (
            "controllers.xy_table.speed_pi",
            forget("InitialUnknowns"),
            "in initialisation u changes with k_i, state.e_vi, v_est, v_ref, which",
        ),
        (
            "plants.gantry.frame",
            forget("InitialUnknowns"),
            "in initialisation y_t changes with state.y_1, state.y_2, which",
        ),
        (
            "controllers.xy_table.speed_pi",
            forget("Outputs"),
            "in its tick u changes with v_est, v_ref, which ModelStructure",
        ),
        (
            "controllers.gantry.double_lead",
            make_constant,
            "in a tick d v / d x_f is between",
        ),
        (
            "plants.leadscrew.axis",
            forget("Outputs"),
            "i changes in a step of 5e-11 s as much as in one of 5e-05 s with u",
        ),
        (
            "plants.ball_screw.two_mass",
            forget("Derivatives"),
            "by model exchange der(state.v_1) changes with d_1, d_2, state.v_1",
        ),
        (
            "plants.ball_screw.two_mass",
            make_constant,
            "by model exchange d der(state.v_1) / d u is between",
        ),
    ],
)
def test_what_our_fmus_do_not_declare_is_found(
    tmp_path: Path, module: str, edit: Edit, expected: str
) -> None:
    texts = [f.text for f in found(rewritten(build(module), tmp_path, edit))]
    assert any(text.startswith(expected) for text in texts), texts
