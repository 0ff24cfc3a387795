"""Dynamic item: outputs depend on what is declared, and in the way declared.

After a step every output may have changed with every input, by way of the
states, so a step tells nothing as such.  What counts as a direct effect:

1. in initialisation, a value that changes when an input, the start of a state or
   a parameter is set;
2. between steps, or by model exchange in continuous-time mode, the same.  A
   co-simulation need not show an input before the next step (FMI 2.0.5 section
   4.2.4), so nothing follows from a value that stays;
3. after a step of a millionth of the usual one, a change that is no smaller
   than after a whole one: states would not have had the time;
4. in the tick of a sampled FMU of ours, which holds y_k = g(x_k, u_k), any.

The kinds constant, fixed and tunable say that an unknown is the known times a
factor that only parameters change, plus a rest.  The factor is measured by 2 and
4 at several places: with other values, inputs, states and parameters.
"""

from collections.abc import Iterable, Iterator
from contextlib import nullcontext, suppress
from dataclasses import replace

import numpy as np
from fmpy.fmi1 import FMICallException

from orchestrator.checks.effects import MAY_DIFFER, NOISE, Effects, Factors, Values
from orchestrator.checks.instance import Instance, excitation
from orchestrator.checks.item import NotApplicable, Said, advice, dynamic
from orchestrator.checks.laboratory import Laboratory
from orchestrator.checks.moment import (
    Known,
    Unknown,
    interfaces,
    knowns,
    real_inputs,
    unknowns,
)
from orchestrator.fmu.description import FmuVariable

PARTS = (1.0, -1.0, 0.37)
SMALL = (0.02, -0.01)  # for parameters
MOVING = ("continuous", "discrete")
REST = 0.61  # where states start, a place that PARTS leave
HISTORIES = (2, 7)  # steps before the moment that is looked at
MOMENT = 1e-6  # of a step: too short for a state to follow
STRUCTURE = "ModelStructure"
# Whose parameters have other values than at first: nobody's, these, those as well.
DIFFERENT = ("", "tunable", "fixed")


@dynamic(
    6,
    "Outputs depend on what they say, and on nothing else",
    "FMI 2.0.5 section 2.2.8; FMI 3.0.2 section 2.4.8",
    "list every input that the output depends on directly, with a kind that holds; an "
    "importer orders its calls by that",
)
def dependencies_true(lab: Laboratory) -> Iterator[Said]:
    inputs = real_inputs(lab)
    outputs = lab.variables(causality="output")
    if not inputs or not any(v.sort == "real" for v in outputs):
        raise NotApplicable("it has no real input or no real output")
    yield from _in_initialisation(lab, inputs)
    for by in interfaces(lab):
        try:
            yield from _between_steps(by)
        except FMICallException as error:
            yield f"by {by.kind} not to the end: {error}"
    if lab.kind == "co-simulation":
        yield from _in_a_step(lab)
    yield f"{len(inputs)} inputs moved, {len(unknowns(lab))} outputs watched"


def _in_initialisation(lab: Laboratory, inputs: list[Known]) -> Iterator[Said]:
    declared = lab.description.initial_dependencies
    outputs = [
        replace(u, kinds=dict.fromkeys(names, ""))
        for u in unknowns(lab)
        if (names := declared.get(u.name)) is not None
    ]
    exact = [v for v in lab.variables(initial="exact") if v.sort == "real"]
    states = [v for v in exact if v.causality == "local" and v.variability in MOVING]
    found = Effects()
    for known in inputs:
        with lab.instance() as one:
            one.enter()
            _move_start(one, known.variable, PARTS, outputs, found)
            one.leave()
    states = lab.settable(lab.sampled("states", states), REST)
    with lab.instance() as one:  # one for all: there may be a thousand
        one.enter()
        with suppress(FMICallException):  # some values of parameters make no model
            for state in states:  # at rest at zero little depends on anything
                one.set(state, excitation(state, REST))
            for variable in states + lab.movable_parameters:
                parts = PARTS if variable in states else SMALL
                _move_start(one, variable, parts, outputs, found)
    yield from found.told("in initialisation {} changes with {}, which {} does not")


def _move_start(
    one: Instance,
    variable: FmuVariable,
    parts: Iterable[float],
    outputs: list[Unknown],
    found: Effects,
) -> None:
    at, before = one.get(variable), _read(one, outputs)
    for part in parts:
        one.set(variable, excitation(variable, part))
        found.compare(variable.name, outputs, before, _read(one, outputs))
    one.set(variable, at)


def _between_steps(lab: Laboratory) -> Iterator[Said]:
    """Move knowns where the FMU stands, without a step."""
    movable = knowns(lab)
    watched = [u for u in unknowns(lab) if _says_something(u, movable)]
    if not watched:
        return
    effects, factors = Effects(), Factors()
    for different in DIFFERENT:
        refusing = suppress(FMICallException) if different else nullcontext()
        with refusing, lab.instance() as one:
            one.enter()
            _move_parameters(one, different)
            one.leave()
            for history in HISTORIES:
                one.run(history)
                if one.ended:
                    break
                lab.trying(f"moving inputs between steps by {lab.kind}")
                _move_all(one, movable, watched, different, effects, factors)
    by = "between steps" if lab.kind == "co-simulation" else "by model exchange"
    yield from effects.told(by + " {} changes with {}, which {} does not", STRUCTURE)
    yield from factors.told(watched, by)


def _move_all(
    one: Instance,
    movable: list[Known],
    watched: list[Unknown],
    different: str,
    effects: Effects,
    factors: Factors,
) -> None:
    for known in movable:
        at = known.read(one)
        before = _read(one, watched)
        for part in PARTS:
            values = known.moved(at, part)
            if np.array_equal(values, at):
                continue
            known.write(one, values)
            after = _read(one, watched)
            effects.compare(known.name, watched, before, after)
            if known.variable.size == 1:
                delta = float((values - at)[0])
                factors.add(different, known, delta, before, after)
        known.write(one, at)


def _in_a_step(lab: Laboratory) -> Iterator[Said]:
    """Move inputs, then step: a tick of ours, or a step too short for states."""
    sampled = lab.description.kind == "sampled"
    if not sampled and not lab.description.variable_step:
        return
    movable = knowns(lab)
    watched = [u for u in unknowns(lab) if _says_something(u, movable)]
    effects, factors = Effects(), Factors()
    moments = [(history, "") for history in HISTORIES]
    if sampled:
        moments += [(HISTORIES[0], different) for different in DIFFERENT[1:]]
    for history, different in moments if watched else ():
        refusing = suppress(FMICallException)  # that is for the items of states
        with refusing, _Fork(lab, history, different, watched) as fork:
            for known in movable:
                lab.trying(f"moving {known.name} before a step")
                if sampled:
                    _in_a_tick(fork, known, lab.h, effects, factors)
                else:
                    _in_no_time(fork, known, lab.h, effects)
    if sampled:
        text = "in its tick {} changes with {}, which {} does not"
        yield from effects.told(text, STRUCTURE)
        yield from factors.told(watched, "in a tick")
        return
    for name, found in effects.of.items():
        yield advice(
            f"{name} changes in a step of {MOMENT * lab.h:.3g} s as much as in one of "
            f"{lab.h:.3g} s with {', '.join(sorted(found))}, which {STRUCTURE} does "
            f"not list"
        )


def _in_a_tick(
    fork: "_Fork", known: Known, h: float, effects: Effects, factors: Factors
) -> None:
    before = fork.after(known, 0.0, h)
    for part in PARTS:
        after = fork.after(known, part, h)
        effects.compare(known.name, fork.watched, before, after)
        if known.variable.size == 1 and fork.delta:
            factors.add(fork.different, known, fork.delta, before, after)


def _in_no_time(fork: "_Fork", known: Known, h: float, effects: Effects) -> None:
    with suppress(FMICallException):  # a step that short may be refused
        still = [fork.after(known, 0.0, size) for size in (MOMENT * h, h)]
        moved = [fork.after(known, 1.0, size) for size in (MOMENT * h, h)]
        for unknown in fork.watched:
            name = unknown.name
            if known.name in (unknown.kinds or {}):
                continue
            short, whole = (
                np.abs(m[name] - s[name]) for m, s in zip(moved, still, strict=True)
            )
            if (short > 0.1 * whole + NOISE * np.abs(still[1][name])).any():
                effects.add(name, known.name)


class _Fork:
    """A moment to which a run goes back: by its saved state, or by a new run."""

    def __init__(
        self, lab: Laboratory, history: int, different: str, watched: list[Unknown]
    ) -> None:
        self.lab, self.history, self.watched = lab, history, watched
        self.different = different  # whose parameters
        self.delta = 0.0  # by how much the first value was moved last

    def __enter__(self) -> "_Fork":
        self.saves = bool(self.lab.interface.canGetAndSetFMUstate)
        self.one = self._run()
        if self.saves:
            self.state = self.one.fmu.getFMUState()
        return self

    def __exit__(self, *_: object) -> None:
        if self.saves:
            self.one.status(self.one.fmu.freeFMUState, self.state)
        self.one.free()

    def _run(self) -> Instance:
        one = Instance(self.lab, "fork")
        one.enter()
        _move_parameters(one, self.different)
        one.leave()
        one.run(self.history)
        return one

    def after(self, known: Known, part: float, size: float) -> Values:
        """Return the values after a step with a known moved."""
        if self.saves:
            self.one.restore(self.state, self.history * self.lab.h)
        else:
            self.one.free()
            self.one = self._run()
        at = known.read(self.one)
        values = known.moved(at, part)
        self.delta = float((values - at)[0])
        known.write(self.one, values)
        self.one.step(self.history * self.lab.h, size)
        return _read(self.one, self.watched)


def _says_something(unknown: Unknown, movable: list[Known]) -> bool:
    """Tell whether there is anything in what it declares that can be false."""
    if unknown.kinds is None:
        return False
    names = {known.name for known in movable}
    promises = names & {n for n, kind in unknown.kinds.items() if kind in MAY_DIFFER}
    return bool(names - unknown.kinds.keys() or promises)


def _move_parameters(one: Instance, up_to: str) -> None:
    """Move the tunable parameters a little; with ``fixed`` those as well."""
    moved = DIFFERENT[1 : DIFFERENT.index(up_to) + 1]
    for variable in one.lab.movable_parameters:
        if variable.variability in moved:
            one.set(variable, excitation(variable, SMALL[0]))


def _read(one: Instance, unknowns: list[Unknown]) -> Values:
    return {unknown.name: unknown.read(one) for unknown in unknowns}
