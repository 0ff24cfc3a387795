/* FMI 2.0: what model exchange and co-simulation have in common.  Arrays are
   scalar elements with consecutive value references. */
#include "component.h" /* first: it may set the prefix */

#include "fmi2Functions.h"
#include "memory.h"

#include <math.h>
#include <string.h>

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
    return fmi2Version;
}

/* The importer's logger is a printf: a % in the text must be doubled. */
static void fmi2_log(void *environment, void (*callback)(void),
                        const char *instance, int status, const char *category,
                        const char *message) {
    char room[1024], *longer = NULL, *text = room, *to;
    size_t size = 2 * strlen(message) + 1;
    if (size > sizeof room)
        text = longer = (char *)memory_more(size);
    if (!text)
        return;
    for (to = text; *message; *to++ = *message++)
        if (*message == '%')
            *to++ = '%';
    *to = '\0';
    ((fmi2CallbackLogger)callback)(environment, instance, (fmi2Status)status,
                                   category, text);
    memory_release(longer);
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType,
                              fmi2String fmuGUID, fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn) {
    return component_opened(
        component_new(instanceName, fmuGUID, fmuType == fmi2ModelExchange, loggingOn,
                      fmi2_log, functions ? (void (*)(void))functions->logger : NULL,
                      functions ? functions->componentEnvironment : NULL),
        fmuResourceLocation);
}

void fmi2FreeInstance(fmi2Component c) {
    component_free(OF(c));
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn,
                               size_t nCategories, const fmi2String categories[]) {
    return (fmi2Status)component_set_logging(OF(c), "fmi2SetDebugLogging", loggingOn, nCategories,
                                 categories);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined,
                               fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
    if (!component_may(OF(c), "fmi2SetupExperiment", INSTANTIATED))
        return fmi2Error;
    return (fmi2Status)component_set_times(OF(c), "fmi2SetupExperiment", startTime,
                               stopTimeDefined ? stopTime : INFINITY);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    return (fmi2Status)component_move(OF(c), "fmi2EnterInitializationMode", INSTANTIATED,
                          INITIALIZING);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return (fmi2Status)component_exit_initialization(OF(c), "fmi2ExitInitializationMode");
}

fmi2Status fmi2Terminate(fmi2Component c) {
    return (fmi2Status)component_move(OF(c), "fmi2Terminate", RUNNING, TERMINATED);
}

fmi2Status fmi2Reset(fmi2Component c) {
    return (fmi2Status)component_reset(OF(c), "fmi2Reset");
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       fmi2Real value[]) {
    if (!component_may(OF(c), "fmi2GetReal", ANY) ||
        !component_given(OF(c), "fmi2GetReal", nvr, vr) ||
        !component_given(OF(c), "fmi2GetReal", nvr, value))
        return fmi2Error;
    const double *values = component_values(OF(c));
    for (size_t i = 0; i < nvr; i++) {
        if (!component_find(OF(c), "fmi2GetReal", vr[i], 0))
            return fmi2Error;
        value[i] = values[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       const fmi2Real value[]) {
    if (!component_may(OF(c), "fmi2SetReal", SOUND) ||
        !component_given(OF(c), "fmi2SetReal", nvr, vr) ||
        !component_given(OF(c), "fmi2SetReal", nvr, value))
        return fmi2Error;
    for (size_t i = 0; i < nvr; i++) {
        const Variable *v = component_find(OF(c), "fmi2SetReal", vr[i], 0);
        if (!v || !component_may_set(OF(c), "fmi2SetReal", v, value + i, 1))
            return fmi2Error;
    }
    for (size_t i = 0; i < nvr; i++)
        component_set(OF(c), vr[i], value + i, 1);
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[],
                          size_t nvr, fmi2Boolean value[]) {
    if (!component_may(OF(c), "fmi2GetBoolean", ANY) ||
        !component_given(OF(c), "fmi2GetBoolean", nvr, vr) ||
        !component_given(OF(c), "fmi2GetBoolean", nvr, value))
        return fmi2Error;
    const double *values = component_values(OF(c));
    for (size_t i = 0; i < nvr; i++) {
        if (!component_find(OF(c), "fmi2GetBoolean", vr[i], 1))
            return fmi2Error;
        value[i] = values[vr[i]] != 0 ? fmi2True : fmi2False;
    }
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[],
                          size_t nvr, const fmi2Boolean value[]) {
    if (!component_may(OF(c), "fmi2SetBoolean", SOUND) ||
        !component_given(OF(c), "fmi2SetBoolean", nvr, vr) ||
        !component_given(OF(c), "fmi2SetBoolean", nvr, value))
        return fmi2Error;
    for (size_t i = 0; i < nvr; i++) {
        const Variable *v = component_find(OF(c), "fmi2SetBoolean", vr[i], 1);
        if (!v || !component_may_set(OF(c), "fmi2SetBoolean", v, NULL, 0))
            return fmi2Error;
    }
    for (size_t i = 0; i < nvr; i++) {
        double number = value[i] ? 1.0 : 0.0;
        component_set(OF(c), vr[i], &number, 1);
    }
    return fmi2OK;
}

static fmi2Status fmi2_no_type(fmi2Component c, const char *function,
                          const fmi2ValueReference vr[], size_t nvr) {
    if (!component_may(OF(c), function, ANY) || !component_given(OF(c), function, nvr, vr))
        return fmi2Error;
    return (fmi2Status)component_no_type(OF(c), function, nvr, nvr ? vr[0] : 0);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[],
                          size_t nvr, fmi2Integer value[]) {
    return fmi2_no_type(c, "fmi2GetInteger", vr, nvr);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[],
                          size_t nvr, const fmi2Integer value[]) {
    return fmi2_no_type(c, "fmi2SetInteger", vr, nvr);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         fmi2String value[]) {
    return fmi2_no_type(c, "fmi2GetString", vr, nvr);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[]) {
    return fmi2_no_type(c, "fmi2SetString", vr, nvr);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    return (fmi2Status)snapshot_take(OF(c), "fmi2GetFMUstate", FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
    return (fmi2Status)snapshot_restore(OF(c), "fmi2SetFMUstate", FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    return (fmi2Status)snapshot_release(OF(c), "fmi2FreeFMUstate", FMUstate);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate,
                                      size_t *size) {
    return (fmi2Status)snapshot_size(OF(c), "fmi2SerializedFMUstateSize", FMUstate, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate,
                                 fmi2Byte serializedState[], size_t size) {
    return (fmi2Status)snapshot_write(OF(c), "fmi2SerializeFMUstate", FMUstate,
                          (unsigned char *)serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[],
                                   size_t size, fmi2FMUstate *FMUstate) {
    return (fmi2Status)snapshot_read(OF(c), "fmi2DeSerializeFMUstate",
                         (const unsigned char *)serializedState, size, FMUstate);
}
