"""Offline design steps: what they are told, what they may return."""

import sys
from types import ModuleType
from typing import NamedTuple

import numpy as np
import pytest

from orchestrator.errors import DesignError, ScenarioError
from orchestrator.result import Signal
from orchestrator.scenario.design import run_step
from orchestrator.scenario.schema import DesignSpec


class Gains(NamedTuple):
    K_p: float
    K_i: float


@pytest.fixture(autouse=True)
def module(monkeypatch):
    """A module of design functions that can be named as a string."""
    found = ModuleType("some_design")
    found.gains = lambda m, beta=2.0: {"K_p": beta * m, "K": np.array([m, 1.0])}
    found.record = lambda m: Gains(m, np.float64(3.0))
    found.mean = lambda e, T_s: {"mean": float(np.mean(e)), "T_s": T_s}
    found.lost = lambda m: {"K_p": float("nan")}
    found.number = lambda m: 3.0
    found.broken = lambda m: 1 / (m - m)
    monkeypatch.setitem(sys.modules, "some_design", found)


def step(call, told=None, recorded=None, **options):
    spec = DesignSpec(call=f"some_design:{call}", arguments=told or {}, **options)
    parameters = {"plant.m": 4.0}
    return run_step(
        "design.gains", spec, parameters.__getitem__, lambda _: recorded or {}
    )


def test_arguments_are_numbers_or_parameters_and_results_plain_values():
    found = step("gains", {"m": "plant.m", "beta": 3})
    assert found.arguments == {"m": 4.0, "beta": 3.0}
    assert found.values == {"K_p": 12.0, "K": (4.0, 1.0)}


def test_a_named_tuple_is_taken_by_its_fields():
    assert step("record", {"m": 1}).values == {"K_p": 1.0, "K_i": 3.0}


def test_signals_of_an_earlier_run_come_with_their_sample_time():
    time = np.arange(101) / 20_000
    recorded = {"plant.e": Signal("plant.e", time, np.full(101, 2.5), "rad")}
    found = step("mean", None, recorded, from_run="x", signals={"e": "plant.e"})
    assert found.values == {"mean": 2.5, "T_s": pytest.approx(1 / 20_000)}


@pytest.mark.parametrize(
    ("call", "told", "remedy"),
    [
        ("gians", {"m": 1}, "'gains'"),
        ("gains", {"m": 1, "betta": 1}, "'beta'"),
        ("gains", {}, "missing a required argument: 'm'"),
        ("lost", {"m": 1}, "K_p"),
        ("number", {"m": 1}, "not a mapping"),
        ("broken", {"m": 1}, "ZeroDivisionError"),
    ],
)
def test_a_step_that_cannot_be_carried_out_is_named(call, told, remedy):
    with pytest.raises(DesignError, match=r"design\.gains") as refusal:
        step(call, told)
    assert remedy in str(refusal.value)


def test_a_missing_module_is_a_design_error():
    spec = DesignSpec(call="no_such_module:design")
    with pytest.raises(DesignError, match="no_such_module"):
        run_step("design.gains", spec, lambda _: 0.0, lambda _: {})


def test_a_signal_that_was_not_recorded_is_refused():
    with pytest.raises(DesignError, match="does not record"):
        step("mean", None, {}, from_run="x", signals={"e": "plant.e"})


def test_an_unknown_parameter_keeps_its_own_kind_of_error():
    def lookup(name):
        raise ScenarioError(f"{name}: there is none")

    spec = DesignSpec(call="some_design:gains", arguments={"m": "plant.n"})
    with pytest.raises(ScenarioError, match=r"design\.gains: plant\.n"):
        run_step("design.gains", spec, lookup, lambda _: {})
