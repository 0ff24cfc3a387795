/* FMI 3.0: instances, phases, states, and the steps of co-simulation.  There is
   no intermediate update and no early return; fmi3_clocks.c has the event mode. */
#include "component.h" /* first: it may set the prefix */

#include "fmi3Functions.h"

#include <math.h>

const char *fmi3GetVersion(void) {
    return fmi3Version;
}

static void fmi3_log(void *environment, void (*callback)(void),
                        const char *instance, int status, const char *category,
                        const char *message) {
    ((fmi3LogMessageCallback)callback)(environment, (fmi3Status)status, category,
                                       message);
}

fmi3Instance fmi3InstantiateModelExchange(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn,
    fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage) {
    return component_new(instanceName, instantiationToken, 1, loggingOn, fmi3_log,
                         (void (*)(void))logMessage, instanceEnvironment);
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
    fmi3Boolean earlyReturnAllowed,
    const fmi3ValueReference requiredIntermediateVariables[],
    size_t nRequiredIntermediateVariables,
    fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3IntermediateUpdateCallback intermediateUpdate) {
    Component *c = component_opened(
        component_new(instanceName, instantiationToken, 0, 1, fmi3_log,
                      (void (*)(void))logMessage, instanceEnvironment),
        resourcePath);
    if (!c)
        return NULL;
    if ((eventModeUsed && !feeddrive_model.clock) ||
        nRequiredIntermediateVariables) {
        component_refuse(c, "fmi3InstantiateCoSimulation: intermediate variables, and "
                            "event mode of a model without clock, are not supported; "
                            "instantiate without");
        component_free(c);
        return NULL;
    }
    c->simulation.clocked = eventModeUsed;
    c->logging = loggingOn;
    return c;
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn,
    fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
    fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
    fmi3UnlockPreemptionCallback unlockPreemption) {
    if (logMessage)
        logMessage(instanceEnvironment, fmi3Error, "logStatusError",
                   "fmi3InstantiateScheduledExecution is not supported; use "
                   "co-simulation");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) {
    component_free(OF(instance));
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn,
                               size_t nCategories, const fmi3String categories[]) {
    return (fmi3Status)component_set_logging(OF(instance), "fmi3SetDebugLogging", loggingOn,
                                 nCategories, categories);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance,
                                       fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined,
                                       fmi3Float64 stopTime) {
    const char *function = "fmi3EnterInitializationMode";
    if (!component_may(OF(instance), function, INSTANTIATED) ||
        component_set_times(OF(instance), function, startTime,
                            stopTimeDefined ? stopTime : INFINITY) != STATUS_OK)
        return fmi3Error;
    return (fmi3Status)component_move(OF(instance), function, INSTANTIATED, INITIALIZING);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    return (fmi3Status)component_exit_initialization(OF(instance), "fmi3ExitInitializationMode");
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    return (fmi3Status)component_move(OF(instance), "fmi3Terminate", RUNNING, TERMINATED);
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    return (fmi3Status)component_reset(OF(instance), "fmi3Reset");
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState) {
    return (fmi3Status)snapshot_take(OF(instance), "fmi3GetFMUState", FMUState);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState) {
    return (fmi3Status)snapshot_restore(OF(instance), "fmi3SetFMUState", FMUState);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState) {
    return (fmi3Status)snapshot_release(OF(instance), "fmi3FreeFMUState", FMUState);
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState,
                                      size_t *size) {
    return (fmi3Status)snapshot_size(OF(instance), "fmi3SerializedFMUStateSize", FMUState, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState,
                                 fmi3Byte serializedState[], size_t size) {
    return (fmi3Status)snapshot_write(OF(instance), "fmi3SerializeFMUState", FMUState,
                          serializedState, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance,
                                   const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState) {
    return (fmi3Status)snapshot_read(OF(instance), "fmi3DeserializeFMUState", serializedState, size,
                         FMUState);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn,
                      fmi3Float64 *lastSuccessfulTime) {
    int status = component_step(OF(instance), "fmi3DoStep", currentCommunicationPoint,
                                communicationStepSize);
    if (eventHandlingNeeded)
        *eventHandlingNeeded = fmi3False;
    if (terminateSimulation)
        *terminateSimulation = fmi3False;
    if (earlyReturn)
        *earlyReturn = fmi3False;
    if (lastSuccessfulTime && instance)
        *lastSuccessfulTime = component_values(OF(instance))[feeddrive_model.size - 1];
    return (fmi3Status)status;
}

/* Model exchange: the equations are continuous and have no events. */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
    const char *function = "fmi3EnterContinuousTimeMode";
    if (feeddrive_model.continuous)
        return (fmi3Status)component_move(OF(instance), function, EVENT, CONTINUOUS_TIME);
    return (fmi3Status)component_refuse(OF(instance), "%s: %s has no continuous states", function,
                            feeddrive_model.identifier);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance,
                                       fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode,
                                       fmi3Boolean *terminateSimulation) {
    const char *function = "fmi3CompletedIntegratorStep";
    if (!component_may(OF(instance), function, CONTINUOUS_TIME) ||
        !component_given(OF(instance), function, 1, enterEventMode) ||
        !component_given(OF(instance), function, 1, terminateSimulation))
        return fmi3Error;
    *enterEventMode = *terminateSimulation = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
    return (fmi3Status)component_set_time(OF(instance), "fmi3SetTime", time);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance,
                                   const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
    return (fmi3Status)component_set_states(OF(instance), "fmi3SetContinuousStates",
                                continuousStates, nContinuousStates);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance,
                                             fmi3Float64 derivatives[],
                                             size_t nContinuousStates) {
    return (fmi3Status)component_get_block(OF(instance), "fmi3GetContinuousStateDerivatives",
                               feeddrive_model.der_x, derivatives,
                               nContinuousStates);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance,
                                   fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
    return (fmi3Status)component_get_block(OF(instance), "fmi3GetContinuousStates",
                               feeddrive_model.x, continuousStates,
                               nContinuousStates);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance,
                                             fmi3Float64 nominals[],
                                             size_t nContinuousStates) {
    return (fmi3Status)component_get_nominals(OF(instance), "fmi3GetNominalsOfContinuousStates",
                                  nominals, nContinuousStates);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance,
                                           size_t *nContinuousStates) {
    const char *function = "fmi3GetNumberOfContinuousStates";
    if (!component_may(OF(instance), function, SOUND) ||
        !component_given(OF(instance), function, 1, nContinuousStates))
        return fmi3Error;
    *nContinuousStates = component_continuous_states();
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance,
                                          size_t *nEventIndicators) {
    const char *function = "fmi3GetNumberOfEventIndicators";
    if (!component_may(OF(instance), function, SOUND) ||
        !component_given(OF(instance), function, 1, nEventIndicators))
        return fmi3Error;
    *nEventIndicators = 0;
    return fmi3OK;
}
