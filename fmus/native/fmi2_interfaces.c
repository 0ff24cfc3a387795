/* FMI 2.0: functions of co-simulation alone and of model exchange alone. */
#include "component.h" /* first: it may set the prefix */

#include "fmi2Functions.h"

#include <string.h>

/* A function of which the description says that it is not supported. */
static fmi2Status fmi2_absent(fmi2Component c, const char *function) {
    if (!component_may(OF(c), function, ANY))
        return fmi2Error;
    return (fmi2Status)component_refuse(OF(c), "%s is not supported", function);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c,
                                        const fmi2ValueReference vUnknown_ref[],
                                        size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[],
                                        size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
    const char *function = "fmi2GetDirectionalDerivative";
    size_t i;
    if (!component_direction_begin(OF(c), function) ||
        !component_given(OF(c), function, nUnknown, vUnknown_ref) ||
        !component_given(OF(c), function, nKnown, vKnown_ref) ||
        !component_given(OF(c), function, nKnown, dvKnown) ||
        !component_given(OF(c), function, nUnknown, dvUnknown))
        return fmi2Error;
    for (i = 0; i < nKnown; i++)
        if (!component_direction_seed(OF(c), function, vKnown_ref[i], dvKnown[i]))
            return fmi2Error;
    component_direction(OF(c));
    for (i = 0; i < nUnknown; i++)
        if (!component_direction_of(OF(c), function, vUnknown_ref[i], dvUnknown + i))
            return fmi2Error;
    return fmi2OK;
}

/* Co-simulation */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint,
                      fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    return (fmi2Status)component_step(OF(c), "fmi2DoStep", currentCommunicationPoint,
                          communicationStepSize);
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    return fmi2_absent(c, "fmi2CancelStep");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c,
                                       const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[],
                                       const fmi2Real value[]) {
    return fmi2_absent(c, "fmi2SetRealInputDerivatives");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c,
                                        const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[],
                                        fmi2Real value[]) {
    return fmi2_absent(c, "fmi2GetRealOutputDerivatives");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s,
                         fmi2Status *value) {
    return fmi2_absent(c, "fmi2GetStatus (steps are never pending)");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s,
                             fmi2Real *value) {
    if (s != fmi2LastSuccessfulTime)
        return fmi2_absent(c, "fmi2GetRealStatus of another kind than the last time");
    if (!component_may(OF(c), "fmi2GetRealStatus", STEPPING | TERMINATED | FAILED) ||
        !component_given(OF(c), "fmi2GetRealStatus", 1, value))
        return fmi2Error;
    *value = component_values(OF(c))[feeddrive_model.size - 1];
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s,
                                fmi2Integer *value) {
    return fmi2_absent(c, "fmi2GetIntegerStatus");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s,
                                fmi2Boolean *value) {
    if (s != fmi2Terminated)
        return fmi2_absent(c, "fmi2GetBooleanStatus of another kind than terminated");
    if (!component_may(OF(c), "fmi2GetBooleanStatus", STEPPING | TERMINATED | FAILED) ||
        !component_given(OF(c), "fmi2GetBooleanStatus", 1, value))
        return fmi2Error;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s,
                               fmi2String *value) {
    return fmi2_absent(c, "fmi2GetStringStatus (steps are never pending)");
}

/* Model exchange: the equations are continuous and have no events. */

fmi2Status fmi2EnterEventMode(fmi2Component c) {
    return (fmi2Status)component_move(OF(c), "fmi2EnterEventMode", EXCHANGING, EVENT);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo) {
    if (!component_may(OF(c), "fmi2NewDiscreteStates", EVENT) ||
        !component_given(OF(c), "fmi2NewDiscreteStates", 1, eventInfo))
        return fmi2Error;
    memset(eventInfo, 0, sizeof *eventInfo);
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    return (fmi2Status)component_move(OF(c), "fmi2EnterContinuousTimeMode", EVENT, CONTINUOUS_TIME);
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c,
                                       fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode,
                                       fmi2Boolean *terminateSimulation) {
    const char *function = "fmi2CompletedIntegratorStep";
    if (!component_may(OF(c), function, CONTINUOUS_TIME) ||
        !component_given(OF(c), function, 1, enterEventMode) ||
        !component_given(OF(c), function, 1, terminateSimulation))
        return fmi2Error;
    *enterEventMode = *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    return (fmi2Status)component_set_time(OF(c), "fmi2SetTime", time);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx) {
    return (fmi2Status)component_set_states(OF(c), "fmi2SetContinuousStates", x, nx);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
    return (fmi2Status)component_get_block(OF(c), "fmi2GetDerivatives", feeddrive_model.der_x,
                               derivatives, nx);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[],
                                  size_t ni) {
    return ni ? fmi2_absent(c, "fmi2GetEventIndicators") : fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx) {
    return (fmi2Status)component_get_block(OF(c), "fmi2GetContinuousStates", feeddrive_model.x, x,
                               nx);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[],
                                             size_t nx) {
    return (fmi2Status)component_get_nominals(OF(c), "fmi2GetNominalsOfContinuousStates", x_nominal,
                                  nx);
}
