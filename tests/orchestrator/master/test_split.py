"""Two readings of mixed rates: steps split where a source publishes, or inputs held."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from broken import MISBEHAVES, pack
from foreign import foreign
from systems import part, system, trusted

from orchestrator.errors import WiringError
from orchestrator.master.ages import describe_schedule
from orchestrator.master.simulate import Choice, plan, simulate
from orchestrator.system import Component, Isolation, Mapped, System

FAST, SLOW, STOP, W = "1/2000", "1/400", "1/5", 40.0  # s, rad/s
EXECUTORS: tuple[Choice, ...] = ("kernel", "python")


def oscillator(split: bool | None) -> System:
    """Return two integrators in a circle, x1' = -W x2 and x2' = W x1."""
    one = part(
        "one",
        "integrator",
        FAST,
        map={"z": Mapped("z", W), "u": Mapped("u")},
        start={"state.x": 1.0},
    )
    two = part("two", "integrator", SLOW, map={"z": Mapped("z", -W)}, split=split)
    wires = {"one.u": "two.z", "two.u": "one.z"}
    return system(STOP, [one, two], wires, {"one.y": SLOW, "two.y": SLOW})


def independent(split: bool) -> np.ndarray:
    """Return x1 and x2 at the slow instants, by a loop of our own."""
    h, x1, x2 = 1 / 2000, 1.0, 0.0
    u1, u2, rows = 0.0, W, [(x1, x2)]
    for k in range(1, 401):
        x1, x2 = x1 + h * u1, x2 + h * u2
        if split or k % 5 == 0:
            u2 = W * x1
        if k % 5 == 0:
            u1 = -W * x2
            rows.append((x1, x2))
    return np.array(rows).T


@pytest.mark.parametrize("executor", EXECUTORS)
@pytest.mark.parametrize("split", [True, False])
def test_each_reading_is_its_own_independent_loop(
    split: bool, executor: Choice, tmp_path: Path
) -> None:
    result = simulate(oscillator(split), tmp_path, executor=executor)
    found = np.array([result["one.y"].values, result["two.y"].values])
    expected = independent(split)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
    other = independent(not split)
    assert np.max(np.abs(expected - other)) > 0.03  # they do differ


def test_by_default_steps_are_split() -> None:
    assert plan(oscillator(None)).steps() == plan(oscillator(True)).steps()


@pytest.mark.parametrize(("split", "steps"), [(None, 400), (True, 400), (False, 80)])
def test_the_schedule_counts_the_steps_that_an_fmu_counts(
    split: bool | None, steps: int, tmp_path: Path
) -> None:
    here = Isolation(process=False)
    slow, fast = Fraction(SLOW), part("fast", "counter", FAST)
    fmu = trusted(foreign(2, tmp_path))
    theirs = Component("theirs", fmu, slow, isolation=here, split=split)
    given = system(
        STOP, [theirs, fast], {"theirs.in_Real": "fast.k"}, {"theirs.steps": SLOW}
    )
    described = describe_schedule(given)
    counted = {turn.component: turn.steps for turn in described.turns}
    assert counted == {"theirs": steps, "fast": 401}
    (age,) = described.ages
    assert ("split" in age.remark) == (split is not False)
    result = simulate(given, tmp_path / "run")
    assert result["theirs.steps"].values[-1] == steps


def test_split_is_refused_where_no_step_can_be_split(
    tmp_path: Path,
) -> None:
    sampled = part("a", "counter", FAST, split=True)
    with pytest.raises(WiringError, match=r"a\.split: a sampled component ticks"):
        plan(system(STOP, [sampled]))
    fixed = MISBEHAVES.replace(
        'canHandleVariableCommunicationStepSize="true"',
        'canHandleVariableCommunicationStepSize="false"',
    )
    equal = Component(
        "b", pack("misbehaves", fixed, tmp_path), Fraction(FAST), split=True
    )
    with pytest.raises(WiringError, match="only takes equal steps"):
        plan(system(STOP, [equal]))
