/* FMI 2.0: what model exchange and co-simulation have in common.  Arrays are
   scalar elements with consecutive value references. */
#include "component.h" /* first: it may set the prefix */

#include "fmi2Functions.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
    return fmi2Version;
}

/* The importer's logger is a printf: a % in the text must be doubled. */
static void log_message(void *environment, void (*callback)(void),
                        const char *instance, int status, const char *category,
                        const char *message) {
    char *text = malloc(2 * strlen(message) + 1), *to = text;
    if (!text)
        return;
    while (*message) {
        if (*message == '%')
            *to++ = '%';
        *to++ = *message++;
    }
    *to = '\0';
    ((fmi2CallbackLogger)callback)(environment, instance, (fmi2Status)status,
                                   category, text);
    free(text);
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType,
                              fmi2String fmuGUID, fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn) {
    return component_new(instanceName, fmuGUID, fmuType == fmi2ModelExchange,
                         loggingOn, log_message,
                         functions ? (void (*)(void))functions->logger : NULL,
                         functions ? functions->componentEnvironment : NULL);
}

void fmi2FreeInstance(fmi2Component c) {
    component_free(c);
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn,
                               size_t nCategories, const fmi2String categories[]) {
    return component_set_logging(c, "fmi2SetDebugLogging", loggingOn, nCategories,
                                 categories);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined,
                               fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
    if (!component_may(c, "fmi2SetupExperiment", INSTANTIATED))
        return fmi2Error;
    return component_set_times(c, "fmi2SetupExperiment", startTime,
                               stopTimeDefined ? stopTime : INFINITY);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    return component_move(c, "fmi2EnterInitializationMode", INSTANTIATED,
                          INITIALIZING);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return component_exit_initialization(c, "fmi2ExitInitializationMode");
}

fmi2Status fmi2Terminate(fmi2Component c) {
    return component_move(c, "fmi2Terminate", RUNNING, TERMINATED);
}

fmi2Status fmi2Reset(fmi2Component c) {
    return component_reset(c, "fmi2Reset");
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       fmi2Real value[]) {
    if (!component_may(c, "fmi2GetReal", ANY) ||
        !component_given(c, "fmi2GetReal", nvr, vr) ||
        !component_given(c, "fmi2GetReal", nvr, value))
        return fmi2Error;
    const double *values = component_values(c);
    for (size_t i = 0; i < nvr; i++) {
        if (!component_find(c, "fmi2GetReal", vr[i], 0))
            return fmi2Error;
        value[i] = values[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       const fmi2Real value[]) {
    if (!component_may(c, "fmi2SetReal", SOUND) ||
        !component_given(c, "fmi2SetReal", nvr, vr) ||
        !component_given(c, "fmi2SetReal", nvr, value))
        return fmi2Error;
    for (size_t i = 0; i < nvr; i++) {
        const Variable *v = component_find(c, "fmi2SetReal", vr[i], 0);
        if (!v || !component_may_set(c, "fmi2SetReal", v, value + i, 1))
            return fmi2Error;
    }
    for (size_t i = 0; i < nvr; i++)
        component_set(c, vr[i], value + i, 1);
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[],
                          size_t nvr, fmi2Boolean value[]) {
    if (!component_may(c, "fmi2GetBoolean", ANY) ||
        !component_given(c, "fmi2GetBoolean", nvr, vr) ||
        !component_given(c, "fmi2GetBoolean", nvr, value))
        return fmi2Error;
    const double *values = component_values(c);
    for (size_t i = 0; i < nvr; i++) {
        if (!component_find(c, "fmi2GetBoolean", vr[i], 1))
            return fmi2Error;
        value[i] = values[vr[i]] != 0 ? fmi2True : fmi2False;
    }
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[],
                          size_t nvr, const fmi2Boolean value[]) {
    if (!component_may(c, "fmi2SetBoolean", SOUND) ||
        !component_given(c, "fmi2SetBoolean", nvr, vr) ||
        !component_given(c, "fmi2SetBoolean", nvr, value))
        return fmi2Error;
    for (size_t i = 0; i < nvr; i++) {
        const Variable *v = component_find(c, "fmi2SetBoolean", vr[i], 1);
        if (!v || !component_may_set(c, "fmi2SetBoolean", v, NULL, 0))
            return fmi2Error;
    }
    for (size_t i = 0; i < nvr; i++) {
        double number = value[i] ? 1.0 : 0.0;
        component_set(c, vr[i], &number, 1);
    }
    return fmi2OK;
}

static fmi2Status no_type(fmi2Component c, const char *function,
                          const fmi2ValueReference vr[], size_t nvr) {
    if (!component_may(c, function, ANY) || !component_given(c, function, nvr, vr))
        return fmi2Error;
    return component_no_type(c, function, nvr, nvr ? vr[0] : 0);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[],
                          size_t nvr, fmi2Integer value[]) {
    return no_type(c, "fmi2GetInteger", vr, nvr);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[],
                          size_t nvr, const fmi2Integer value[]) {
    return no_type(c, "fmi2SetInteger", vr, nvr);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         fmi2String value[]) {
    return no_type(c, "fmi2GetString", vr, nvr);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[]) {
    return no_type(c, "fmi2SetString", vr, nvr);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    return snapshot_take(c, "fmi2GetFMUstate", FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
    return snapshot_restore(c, "fmi2SetFMUstate", FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    return snapshot_release(c, "fmi2FreeFMUstate", FMUstate);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate,
                                      size_t *size) {
    return snapshot_size(c, "fmi2SerializedFMUstateSize", FMUstate, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate,
                                 fmi2Byte serializedState[], size_t size) {
    return snapshot_write(c, "fmi2SerializeFMUstate", FMUstate,
                          (unsigned char *)serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[],
                                   size_t size, fmi2FMUstate *FMUstate) {
    return snapshot_read(c, "fmi2DeSerializeFMUstate",
                         (const unsigned char *)serializedState, size, FMUstate);
}
