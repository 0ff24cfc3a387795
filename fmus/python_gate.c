/* The face of a Python FMU; pythonfmu's library stands behind it.

   pythonfmu's own binary compares no token, takes an instance without a name, needs
   the importer's memory functions, and crashes where the host has no Python or the
   resource URI holds an escaped character outside ASCII.  It returns OK when the
   Python code refuses something without an exception (an exception is Fatal), hands
   messages to a printf as they are, and logs even if it must not.

   So importers load this library.  It looks at what fmi2Instantiate is given, loads
   pythonfmu's library from beside itself, once more for every instance, and hands
   all other calls on.  A call during which an error is logged returns Error.

   token.h is generated: TOKEN, the guid, and LIBRARY, the file behind;
   python_gate_files.c finds it. */
#include "fmi2Functions.h"
#include "python_gate_files.h"
#include "token.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define INNER ((Gate *)c)->inner
#define FORWARDED(X)                                                                 \
    X(SetupExperiment, (fmi2Component c, fmi2Boolean tolerant, fmi2Real tolerance,   \
      fmi2Real start, fmi2Boolean ending, fmi2Real stop),                            \
      (INNER, tolerant, tolerance, start, ending, stop))                             \
    X(EnterInitializationMode, (fmi2Component c), (INNER))                           \
    X(ExitInitializationMode, (fmi2Component c), (INNER))                            \
    X(Terminate, (fmi2Component c), (INNER))                                         \
    X(Reset, (fmi2Component c), (INNER))                                             \
    X(GetReal, (fmi2Component c, const fmi2ValueReference vr[], size_t n,            \
      fmi2Real value[]), (INNER, vr, n, value))                                      \
    X(GetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n,         \
      fmi2Integer value[]), (INNER, vr, n, value))                                   \
    X(GetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n,         \
      fmi2Boolean value[]), (INNER, vr, n, value))                                   \
    X(GetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n,          \
      fmi2String value[]), (INNER, vr, n, value))                                    \
    X(SetReal, (fmi2Component c, const fmi2ValueReference vr[], size_t n,            \
      const fmi2Real value[]), (INNER, vr, n, value))                                \
    X(SetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n,         \
      const fmi2Integer value[]), (INNER, vr, n, value))                             \
    X(SetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n,         \
      const fmi2Boolean value[]), (INNER, vr, n, value))                             \
    X(SetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n,          \
      const fmi2String value[]), (INNER, vr, n, value))                              \
    X(GetFMUstate, (fmi2Component c, fmi2FMUstate *state), (INNER, state))           \
    X(SetFMUstate, (fmi2Component c, fmi2FMUstate state), (INNER, state))            \
    X(FreeFMUstate, (fmi2Component c, fmi2FMUstate *state), (INNER, state))          \
    X(SerializedFMUstateSize, (fmi2Component c, fmi2FMUstate state, size_t *size),   \
      (INNER, state, size))                                                          \
    X(SerializeFMUstate, (fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],     \
      size_t size), (INNER, state, bytes, size))                                     \
    X(DeSerializeFMUstate, (fmi2Component c, const fmi2Byte bytes[], size_t size,    \
      fmi2FMUstate *state), (INNER, bytes, size, state))                             \
    X(GetDirectionalDerivative, (fmi2Component c, const fmi2ValueReference unknown[],\
      size_t n, const fmi2ValueReference known[], size_t m, const fmi2Real seed[],   \
      fmi2Real value[]), (INNER, unknown, n, known, m, seed, value))                 \
    X(SetRealInputDerivatives, (fmi2Component c, const fmi2ValueReference vr[],      \
      size_t n, const fmi2Integer order[], const fmi2Real value[]),                  \
      (INNER, vr, n, order, value))                                                  \
    X(GetRealOutputDerivatives, (fmi2Component c, const fmi2ValueReference vr[],     \
      size_t n, const fmi2Integer order[], fmi2Real value[]),                        \
      (INNER, vr, n, order, value))                                                  \
    X(DoStep, (fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_return),      \
      (INNER, t, h, no_return))                                                      \
    X(CancelStep, (fmi2Component c), (INNER))                                        \
    X(GetStatus, (fmi2Component c, const fmi2StatusKind kind, fmi2Status *value),    \
      (INNER, kind, value))                                                          \
    X(GetRealStatus, (fmi2Component c, const fmi2StatusKind kind, fmi2Real *value),  \
      (INNER, kind, value))                                                          \
    X(GetIntegerStatus, (fmi2Component c, const fmi2StatusKind kind,                 \
      fmi2Integer *value), (INNER, kind, value))                                     \
    X(GetBooleanStatus, (fmi2Component c, const fmi2StatusKind kind,                 \
      fmi2Boolean *value), (INNER, kind, value))                                     \
    X(GetStringStatus, (fmi2Component c, const fmi2StatusKind kind,                  \
      fmi2String *value), (INNER, kind, value))

#define MEMBER(name, parameters, arguments) fmi2##name##TYPE *name;
typedef struct {
    void *library;
    fmi2Component inner;             /* pythonfmu's */
    fmi2CallbackFunctions callbacks; /* for pythonfmu, back to this library */
    fmi2CallbackLogger logger;       /* the importer's */
    fmi2ComponentEnvironment environment;
    int logging, refused;
    fmi2InstantiateTYPE *Instantiate;
    fmi2FreeInstanceTYPE *FreeInstance;
    FORWARDED(MEMBER)
} Gate;

#define FUNCTION(name, parameters, arguments)                                        \
    fmi2Status fmi2##name parameters {                                               \
        Gate *gate = c;                                                              \
        if (!gate)                                                                   \
            return fmi2Error;                                                        \
        gate->refused = 0;                                                           \
        fmi2Status status = gate->name arguments;                                    \
        return gate->refused && status < fmi2Error ? fmi2Error : status;             \
    }
FORWARDED(FUNCTION)

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
    return fmi2Version;
}

/* The importer's logger is a printf: a % in the text must be doubled. */
static void tell(const Gate *gate, const char *name, fmi2Status status,
                 const char *category, const char *text) {
    char *doubled = gate->logger ? malloc(2 * strlen(text) + 1) : NULL;
    if (!doubled)
        return;
    char *to = doubled;
    for (const char *from = text; *from; *to++ = *from++)
        if (*from == '%')
            *to++ = '%';
    *to = '\0';
    gate->logger(gate->environment, name, status, category, doubled);
    free(doubled);
}

/* What pythonfmu logs: plain text, whatever the callback's type says. */
static void hear(fmi2ComponentEnvironment environment, fmi2String name,
                 fmi2Status status, fmi2String category, fmi2String text, ...) {
    Gate *gate = environment;
    if (status == fmi2Error || status == fmi2Fatal)
        gate->refused = 1;
    if (gate->logging)
        tell(gate, name, status, category && *category ? category : "logStatusFatal",
             text ? text : "");
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n,
                               const fmi2String categories[]) {
    int errors = n == 0; /* the only messages there are */
    if (!c)
        return fmi2Error;
    for (size_t i = 0; i < n; i++)
        errors = errors || strcmp(categories[i], "logAll") == 0 ||
                 strcmp(categories[i], "logStatusError") == 0;
    ((Gate *)c)->logging = on && errors;
    return fmi2OK;
}

static void refuse(const Gate *gate, const char *name, const char *why,
                   const char *detail) {
    char text[1024];
    name = name ? name : "";
    snprintf(text, sizeof text, "%s is not instantiated: %s%s", name, why, detail);
    tell(gate, name, fmi2Error, "logStatusError", text);
}

void fmi2FreeInstance(fmi2Component c) {
    Gate *gate = c;
    if (!gate)
        return;
    if (gate->inner)
        gate->FreeInstance(gate->inner);
    if (gate->library)
        close_library(gate->library);
    free(gate);
}

#define LOOK_UP(name, parameters, arguments)                                         \
    gate->name = (fmi2##name##TYPE *)symbol(gate->library, "fmi2" #name);            \
    complete = complete && gate->name;

/* Loads pythonfmu's library; returns whether it has all functions. */
static int open_library(Gate *gate, char *problem, size_t size) {
    int complete = 1;
    gate->library = open_beside(problem, size);
    if (!gate->library)
        return 0;
    LOOK_UP(Instantiate, , )
    LOOK_UP(FreeInstance, , )
    FORWARDED(LOOK_UP)
    if (!complete)
        snprintf(problem, size, LIBRARY " lacks a function of FMI 2");
    return complete;
}

/* Why there can be no such instance, or NULL. */
static const char *objection(const char *name, fmi2Type kind, const char *token,
                             const char *resources) {
    if (!name || !*name)
        return "an instance needs a name; none was given";
    if (!token || strcmp(token, TOKEN) != 0)
        return "the token (guid) is not that of this binary; take it from the "
               "modelDescription.xml of the same FMU";
    if (kind != fmi2CoSimulation)
        return "a Python FMU has no model exchange; use co-simulation";
    if (!resources)
        return "fmuResourceLocation must be the file:/// URI of the unpacked "
               "resources folder";
#ifdef _WIN32
    for (const char *c = resources; *c; c++)
        if (*c & 0x80)
            return "on Windows pythonfmu reads ASCII paths only; unpack it elsewhere";
#endif
    if (strstr(resources, "%20"))
        return "pythonfmu takes %20 in the name of a folder for a space; unpack it "
               "elsewhere";
    if (!holds_slave(resources))
        return "there is no slavemodule.txt in the folder of fmuResourceLocation; it "
               "must be the URI of the unpacked resources folder";
    return NULL;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type kind, fmi2String token,
                              fmi2String location,
                              const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean logging) {
    char problem[512] = "";
    Gate *gate = calloc(1, sizeof *gate);
    if (!gate)
        return NULL;
    if (functions) {
        gate->logger = functions->logger;
        gate->environment = functions->componentEnvironment;
    }
    gate->callbacks = (fmi2CallbackFunctions){hear, calloc, free, NULL, gate};
    gate->logging = 1; /* until there is an instance */
    char *resources = plain_uri(location);
    const char *why = objection(name, kind, token, resources);
    if (!why && !open_library(gate, problem, sizeof problem))
        why = "pythonfmu's library cannot be loaded, which needs a host that runs "
              "Python (documentation/externalDependencies.txt): ";
    if (why)
        refuse(gate, name, why, problem);
    else
        gate->inner = gate->Instantiate(name, kind, token, resources,
                                        &gate->callbacks, visible, logging);
    gate->logging = logging;
    free(resources);
    if (gate->inner)
        return gate;
    fmi2FreeInstance(gate);
    return NULL;
}
