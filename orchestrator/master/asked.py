"""What a scenario asks of one component, checked against what its FMU is and does.

Refused here: interfaces and clocks that nobody can step, a kind, latency, offset or
split that does not go with the FMU, steps it does not take.
"""

from collections.abc import Iterator

from orchestrator.errors import ScheduleError, WiringError
from orchestrator.fmu.clocks import left_alone, unticked
from orchestrator.fmu.description import FmuDescription
from orchestrator.master.layout import kind_of
from orchestrator.system import Component, System
from orchestrator.warned import warn

ROUNDED = 1e-6  # of a step that an FMU writes as a decimal


def refuse_unfit(system: System, c: Component, fmu: FmuDescription) -> None:
    """Refuse what an FMU is not, or does not do, of what is asked of a component.

    Raises:
        WiringError, ScheduleError: the message says what, and the remedy.
    """
    where = f"components.{c.name}"
    if not (fmu.co_simulation or fmu.model_exchange):
        raise WiringError(
            f"{where}: {fmu.path.name} is neither for co-simulation nor for model "
            f"exchange (scheduled execution is not carried out: its tasks want clocks "
            f"that preempt one another); export it for one of these"
        )
    if fmu.clock is None and (why := unticked(fmu.clocks)):
        raise WiringError(
            f"{where}: {fmu.path.name} {why}: what depends on it would never be "
            f"computed; export it without clocks"
        )
    if alone := left_alone(fmu.clocks):
        warn(
            f"{where}: {fmu.path.name} has the input clock {', '.join(alone)} but "
            f"declares no event mode, so nothing ticks it; what depends on it is right "
            f"only if the FMU ticks it itself"
        )
    if fmu.clock is not None and c.kind == "continuous":
        raise WiringError(
            f"{where}.kind: {fmu.path.name} is sampled by its clock, not continuous"
        )
    if c.kind and fmu.kind and c.kind != fmu.kind:
        raise WiringError(f"{where}.kind: {fmu.path.name} is {fmu.kind}, not {c.kind}")
    kind = kind_of(c, fmu)
    if c.latency < 0 or (c.latency and kind == "continuous"):
        raise WiringError(
            f"{where}.latency = {c.latency}: a whole number of samples >= 0, and only "
            f"on a sampled component (this one is {kind})"
        )
    if fmu.period and c.period != fmu.period:
        raise ScheduleError(
            f"{where}.step = {c.period} s, but {fmu.path.name} was built for a sample "
            f"time of {fmu.period} s; build it again with --period {c.period}"
        )
    if c.split is not None and kind == "sampled":
        raise WiringError(
            f"{where}.split: a sampled component ticks, it has no step to split; "
            f"remove it"
        )
    if kind == "sampled" or fmu.variable_step:
        return
    if c.split:
        raise WiringError(
            f"{where}.split = true: {fmu.path.name} only takes equal steps "
            f"(canHandleVariableCommunicationStepSize is false); remove it"
        )
    _refuse_no_multiple(where, c, fmu)
    if c.offset:
        raise ScheduleError(
            f"{where}.offset: {fmu.path.name} has a fixed step and cannot start with a "
            f"step of {c.offset} s; set offset = 0"
        )
    if system.stop % c.period:
        low = system.stop // c.period * c.period
        raise ScheduleError(
            f"stop = {system.stop} s: {c.name} ({fmu.path.name}) only takes steps of "
            f"{c.period} s; the nearest stops are {low} and {low + c.period} s"
        )


def _refuse_no_multiple(where: str, c: Component, fmu: FmuDescription) -> None:
    """FMI 3.0.2 section 4.2: steps are multiples of fixedInternalStepSize."""
    if fmu.internal_step is None:
        return
    ratio = c.period / fmu.internal_step
    if round(ratio) < 1 or abs(ratio - round(ratio)) > ROUNDED * ratio:
        below = max(1, int(ratio)) * fmu.internal_step
        raise ScheduleError(
            f"{where}.step = {c.period} s: {fmu.path.name} steps by "
            f"{float(fmu.internal_step):g} s inside (fixedInternalStepSize) and takes "
            f"whole multiples of that only, such as {float(below):g} s; set step"
        )


def experiment_notes(c: Component, fmu: FmuDescription) -> Iterator[str]:
    """Yield what of an FMU's default experiment the component does otherwise."""
    step = fmu.default_step
    if step and not fmu.variable_step and fmu.kind is None:
        ratio = float(c.period) / step
        if round(ratio) < 1 or abs(ratio - round(ratio)) > ROUNDED * ratio:
            yield (
                f"components.{c.name}.step = {float(c.period):g} s is no multiple of "
                f"{step:g} s, by which {fmu.path.name} steps as it says (equal steps "
                f"only, DefaultExperiment stepSize); its results may lag"
            )
    if fmu.default_start:
        yield (
            f"{c.name}: the experiment of {fmu.path.name} starts at "
            f"{fmu.default_start:g} s, here it starts at 0"
        )
