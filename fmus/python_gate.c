/* The face of a Python FMU; pythonfmu's library stands behind it.

   pythonfmu's own binary compares no token, takes an instance without a name, needs
   the importer's memory functions, and crashes where the host has no Python or the
   resource URI holds an escaped character outside ASCII.  It returns OK when the
   Python code refuses something without an exception (an exception is Fatal), hands
   messages to a printf as they are, and logs even if it must not.

   So importers load this library.  It looks at what fmi2Instantiate is given, loads
   pythonfmu's library from beside itself, once more for every instance, and hands
   all other calls on.  A call during which an error is logged returns Error.

   token.h is generated: TOKEN, the guid, and LIBRARY, the file behind. */
#define _GNU_SOURCE
#include "fmi2Functions.h"
#include "token.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

#define SCHEME "file://"
#ifdef _WIN32
#define ROOT sizeof SCHEME /* file:///C:/ */
#else
#define ROOT (sizeof SCHEME - 1)
#endif

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

static int hex(char digit) {
    static const char digits[] = "0123456789abcdef0123456789ABCDEF";
    const char *found = digit ? strchr(digits, digit) : NULL;
    return found ? (int)((found - digits) % 16) : -1;
}

/* The URI as pythonfmu reads it: file:///, nothing escaped.  Returns NULL for what is
   no file of this machine. */
static char *plain_uri(const char *uri) {
    if (!uri || strncmp(uri, "file:/", 6) != 0)
        return NULL;
    const char *from = uri + 5;
    if (strncmp(from, "//localhost/", 12) == 0)
        from += 11;
    else if (strncmp(from, "///", 3) == 0)
        from += 2;
    else if (from[1] == '/')
        return NULL;
    char *plain = malloc(strlen(from) + sizeof SCHEME), *to = plain;
    if (!plain)
        return NULL;
    to += sprintf(to, SCHEME);
    for (; *from; from++) {
        if (*from == '%' && hex(from[1]) >= 0 && hex(from[2]) >= 0) {
            *to++ = (char)(16 * hex(from[1]) + hex(from[2]));
            from += 2;
        } else {
            *to++ = *from;
        }
    }
    *to = '\0';
    return plain;
}

/* Whether the folder of a plain URI holds what pythonfmu reads first. */
static int holds_slave(const char *uri) {
    static const char file[] = "/slavemodule.txt";
    char *path = malloc(strlen(uri) + sizeof file);
    if (!path)
        return 0;
    sprintf(path, "%s%s", uri + ROOT, file);
    FILE *opened = fopen(path, "rb");
    free(path);
    if (opened)
        fclose(opened);
    return opened != NULL;
}

#ifdef _WIN32
static void *open_beside(char *problem, size_t size) {
    wchar_t path[32768];
    HMODULE self;
    DWORD how = GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS |
                GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT;
    if (GetModuleHandleExW(how, (LPCWSTR)(void *)open_beside, &self)) {
        DWORD length = GetModuleFileNameW(self, path, 32768);
        while (length && path[length - 1] != L'\\')
            length--;
        if (length + sizeof LIBRARY <= 32768) {
            for (size_t i = 0; i < sizeof LIBRARY; i++)
                path[length + i] = (wchar_t)LIBRARY[i];
            HMODULE library =
                LoadLibraryExW(path, NULL, LOAD_WITH_ALTERED_SEARCH_PATH);
            if (library)
                return library;
        }
    }
    snprintf(problem, size, "%s: Windows error %lu", LIBRARY, GetLastError());
    return NULL;
}

static void *symbol(void *library, const char *name) {
    return (void *)GetProcAddress(library, name);
}

static void close_library(void *library) {
    FreeLibrary(library);
}
#else
static void *open_beside(char *problem, size_t size) {
    Dl_info self;
    void *library = NULL;
    if (dladdr(LIBRARY, &self) && self.dli_fname) {
        const char *slash = strrchr(self.dli_fname, '/');
        size_t folder = slash ? (size_t)(slash - self.dli_fname) + 1 : 0;
        char *path = malloc(folder + sizeof LIBRARY);
        if (path) {
            memcpy(path, self.dli_fname, folder);
            memcpy(path + folder, LIBRARY, sizeof LIBRARY);
            library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
            free(path);
        }
    }
    const char *said = library ? NULL : dlerror();
    if (!library)
        snprintf(problem, size, "%s", said ? said : LIBRARY);
    return library;
}

static void *symbol(void *library, const char *name) {
    return dlsym(library, name);
}

static void close_library(void *library) {
    dlclose(library);
}
#endif

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
