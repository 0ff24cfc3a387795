/* FMI 3.0: event mode of co-simulation and the clock of a sampled model.

   The clock is an input with the model's constant period; its value reference
   follows that of time.  With event mode, doStep runs no tick: in event mode the
   importer activates the clock, sets inputs, and calls updateDiscreteStates, which
   runs one.  Outputs read while the clock is active are already those of the
   tick; afterwards they hold. */
#include "component.h" /* first: it may set the prefix */

#include "fmi3Functions.h"

#define M feeddrive_model

/* Tell whether the references are clocks, each with a place in two more arrays. */
static int may_clock(Component *c, const char *function, int phases,
               const fmi3ValueReference references[], size_t n, const void *one,
               const void *other) {
    if (!component_may(c, function, phases) ||
        !component_given(c, function, n, references) ||
        !component_given(c, function, n, one) ||
        !component_given(c, function, n, other))
        return 0;
    for (size_t i = 0; i < n; i++) {
        if (M.clock && references[i] == M.size)
            continue;
        if (references[i] < M.size)
            component_no_type(c, function, 1, references[i]);
        else
            component_refuse(c, "%s: there is no clock with value reference %u",
                             function, (unsigned)references[i]);
        return 0;
    }
    return 1;
}

fmi3Status fmi3GetClock(fmi3Instance instance,
                        const fmi3ValueReference valueReferences[],
                        size_t nValueReferences, fmi3Clock values[]) {
    Component *c = OF(instance);
    if (!may_clock(c, "fmi3GetClock", ANY, valueReferences, nValueReferences, values,
             values))
        return fmi3Error;
    for (size_t i = 0; i < nValueReferences; i++)
        values[i] = c->simulation.state.ticking != 0;
    return fmi3OK;
}

fmi3Status fmi3SetClock(fmi3Instance instance,
                        const fmi3ValueReference valueReferences[],
                        size_t nValueReferences, const fmi3Clock values[]) {
    Component *c = OF(instance);
    if (!may_clock(c, "fmi3SetClock", EVENT, valueReferences, nValueReferences, values,
             values))
        return fmi3Error;
    for (size_t i = 0; i < nValueReferences; i++)
        simulation_activate(&c->simulation, values[i]);
    return fmi3OK;
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance,
                                  const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
    if (!may_clock(OF(instance), "fmi3GetIntervalDecimal", ANY, valueReferences,
             nValueReferences, intervals, qualifiers))
        return fmi3Error;
    for (size_t i = 0; i < nValueReferences; i++) {
        intervals[i] = (double)M.period_num / (double)M.period_den;
        qualifiers[i] = fmi3IntervalUnchanged;
    }
    return fmi3OK;
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance,
                                   const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, fmi3UInt64 counters[],
                                   fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[]) {
    if (!may_clock(OF(instance), "fmi3GetIntervalFraction", ANY, valueReferences,
             nValueReferences, counters, resolutions) ||
        !component_given(OF(instance), "fmi3GetIntervalFraction", nValueReferences,
                         qualifiers))
        return fmi3Error;
    for (size_t i = 0; i < nValueReferences; i++) {
        counters[i] = (fmi3UInt64)M.period_num;
        resolutions[i] = (fmi3UInt64)M.period_den;
        qualifiers[i] = fmi3IntervalUnchanged;
    }
    return fmi3OK;
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance,
                               const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[]) {
    if (!may_clock(OF(instance), "fmi3GetShiftDecimal", ANY, valueReferences, nValueReferences,
             shifts, shifts))
        return fmi3Error;
    for (size_t i = 0; i < nValueReferences; i++)
        shifts[i] = 0.0;
    return fmi3OK;
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance,
                                const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, fmi3UInt64 counters[],
                                fmi3UInt64 resolutions[]) {
    if (!may_clock(OF(instance), "fmi3GetShiftFraction", ANY, valueReferences,
             nValueReferences, counters, resolutions))
        return fmi3Error;
    for (size_t i = 0; i < nValueReferences; i++) {
        counters[i] = 0;
        resolutions[i] = (fmi3UInt64)M.period_den;
    }
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    return (fmi3Status)component_leave_events(OF(instance), "fmi3EnterStepMode");
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    return (fmi3Status)component_enter_events(OF(instance), "fmi3EnterEventMode");
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance,
                                    fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime) {
    const char *function = "fmi3UpdateDiscreteStates";
    if (!component_may(OF(instance), function, EVENT) ||
        !component_given(OF(instance), function, 1, discreteStatesNeedUpdate) ||
        !component_given(OF(instance), function, 1, terminateSimulation) ||
        !component_given(OF(instance), function, 1, nominalsOfContinuousStatesChanged) ||
        !component_given(OF(instance), function, 1, valuesOfContinuousStatesChanged) ||
        !component_given(OF(instance), function, 1, nextEventTimeDefined))
        return fmi3Error;
    *discreteStatesNeedUpdate = *terminateSimulation = fmi3False;
    *nominalsOfContinuousStatesChanged = *valuesOfContinuousStatesChanged = fmi3False;
    *nextEventTimeDefined = fmi3False;
    return (fmi3Status)component_update(OF(instance), function);
}
