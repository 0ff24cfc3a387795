/* FMUs of others inside a composition: loaded from the resources beside this library,
   and called.  What is known of them stands in a table that the export writes.

   They are instantiated anew for every initialisation.  Callbacks are our own and say
   nothing.  On Linux their symbols come first for themselves (RTLD_DEEPBIND), so that
   the functions of the tool, or of this FMU, are not taken for theirs. */
#include "fmi2Functions.h"
#include "fmi3Functions.h"

#include <stdio.h>
#include <stdlib.h>

#ifdef _WIN32
/* of windows.h, whose names meet ours */
enum { FROM_ADDRESS = 4, UNCHANGED_COUNT = 2, ALTERED_SEARCH_PATH = 8, UTF8 = 65001 };
__declspec(dllimport) void *__stdcall LoadLibraryExW(const wchar_t *, void *, unsigned long);
__declspec(dllimport) void *__stdcall GetProcAddress(void *, const char *);
__declspec(dllimport) int __stdcall GetModuleHandleExW(unsigned long, const wchar_t *,
                                                       void **);
__declspec(dllimport) unsigned long __stdcall GetModuleFileNameW(void *, wchar_t *,
                                                                 unsigned long);
__declspec(dllimport) int __stdcall WideCharToMultiByte(unsigned, unsigned long,
                                                        const wchar_t *, int, char *, int,
                                                        const char *, int *);
__declspec(dllimport) int __stdcall MultiByteToWideChar(unsigned, unsigned long,
                                                        const char *, int, wchar_t *, int);
#else
#include <dlfcn.h>
#endif

enum { REAL, INTEGER, BOOLEAN, FLOAT64 }; /* types of variables */
enum { LONGEST_PATH = 4096 };

/* Numbers of one type: `n` references, `size` values, where the first stands. */
typedef struct {
    int type;
    size_t n, size;
    const uint32_t *references;
    size_t first;
} Group;

/* A value before initialisation; if it is not `given`, only where it was changed. */
typedef struct {
    int type, given;
    uint32_t reference;
    double start;
} Given;

typedef struct {
    const char *name, *folder, *identifier, *token;
    int major, part, index;
    const Group *inputs, *outputs;
    size_t n_inputs, n_outputs;
    const Given *values;
    size_t n_values;
} Foreign;

#if defined(_WIN32)
static const char *const place_of_binary[] = {"win64", "x86_64-windows", ".dll"};
#elif defined(__APPLE__) && defined(__aarch64__)
static const char *const place_of_binary[] = {"darwin64", "aarch64-darwin", ".dylib"};
#elif defined(__APPLE__)
static const char *const place_of_binary[] = {"darwin64", "x86_64-darwin", ".dylib"};
#elif defined(__aarch64__)
static const char *const place_of_binary[] = {"aarch64-linux", "aarch64-linux", ".so"};
#else
static const char *const place_of_binary[] = {"linux64", "x86_64-linux", ".so"};
#endif

/* One of them loaded. */
typedef struct {
    void *library, *instance;
} Loaded;

static int path_of_this(char *path, size_t size) {
#ifdef _WIN32
    wchar_t wide[LONGEST_PATH];
    void *here;
    if (!GetModuleHandleExW(FROM_ADDRESS | UNCHANGED_COUNT,
                            (const wchar_t *)(const void *)&path_of_this, &here) ||
        GetModuleFileNameW(here, wide, LONGEST_PATH) >= LONGEST_PATH ||
        !WideCharToMultiByte(UTF8, 0, wide, -1, path, (int)size, NULL, NULL))
        return 0;
    for (char *c = path; *c; c++)
        if (*c == '\\')
            *c = '/';
#else
    Dl_info found;
    if (!dladdr((const void *)&path_of_this, &found) || !found.dli_fname ||
        !realpath(found.dli_fname, path))
        return 0;
    (void)size;
#endif
    for (int up = 0; up < 3; up++) { /* binaries/<platform>/<library> */
        char *slash = strrchr(path, '/');
        if (!slash)
            return 0;
        *slash = '\0';
    }
    return 1;
}

static void *opened(const char *path) {
#ifdef _WIN32
    wchar_t wide[LONGEST_PATH];
    if (!MultiByteToWideChar(UTF8, 0, path, -1, wide, LONGEST_PATH))
        return NULL;
    for (wchar_t *c = wide; *c; c++)
        if (*c == L'/')
            *c = L'\\';
    return LoadLibraryExW(wide, NULL, ALTERED_SEARCH_PATH);
#else
#ifndef RTLD_DEEPBIND
#define RTLD_DEEPBIND 0
#endif
    return dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND);
#endif
}

static void *function_of(const Loaded *l, const char *name) {
#ifdef _WIN32
    return GetProcAddress(l->library, name);
#else
    return dlsym(l->library, name);
#endif
}

#define CALL(l, name, type, ...)                                                       \
    (function_of(l, #name) ? ((type *)function_of(l, #name))((l)->instance, __VA_ARGS__) : 3)
#define CALL_ALONE(l, name, type)                                                      \
    (function_of(l, #name) ? ((type *)function_of(l, #name))((l)->instance) : 3)

static int fine(int status) {
    return status == 0 || status == 1; /* OK, Warning */
}

static void silent(void) {}

static void file_uri(const char *path, char *uri, size_t size) {
    const char *plain = "/-_.~:";
    size_t n = (size_t)snprintf(uri, size, path[0] == '/' ? "file://" : "file:///");
    for (; *path && n + 4 < size; path++) {
        int c = (unsigned char)*path;
        int kept = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                   (c >= 'A' && c <= 'Z') || strchr(plain, c);
        n += (size_t)snprintf(uri + n, size - n, kept ? "%c" : "%%%02X", c);
    }
}

static void foreign_free(Loaded *l, int major) {
    if (!l->instance)
        return;
    if (major == 2 && function_of(l, "fmi2FreeInstance"))
        ((fmi2FreeInstanceTYPE *)function_of(l, "fmi2FreeInstance"))(l->instance);
    else if (major == 3 && function_of(l, "fmi3FreeInstance"))
        ((fmi3FreeInstanceTYPE *)function_of(l, "fmi3FreeInstance"))(l->instance);
    l->instance = NULL;
}

static int instantiated(const Foreign *f, Loaded *l) {
    static const fmi2CallbackFunctions callbacks = {(fmi2CallbackLogger)silent, calloc,
                                                    free, NULL, NULL};
    char root[LONGEST_PATH + 8], path[2 * LONGEST_PATH], uri[4 * LONGEST_PATH];
    void *new;
    foreign_free(l, f->major);
    if (!path_of_this(root, sizeof root))
        return 0;
    if (!l->library) {
        snprintf(path, sizeof path, "%s/resources/%s/binaries/%s/%s%s", root, f->folder,
                 place_of_binary[f->major - 2], f->identifier, place_of_binary[2]);
        l->library = opened(path);
    }
    if (!l->library)
        return 0;
    snprintf(path, sizeof path, "%s/resources/%s/resources%s", root, f->folder,
             f->major == 2 ? "" : "/");
    file_uri(path, uri, sizeof uri);
    new = function_of(l, f->major == 2 ? "fmi2Instantiate" : "fmi3InstantiateCoSimulation");
    if (new && f->major == 2)
        l->instance = ((fmi2InstantiateTYPE *)new)(f->name, fmi2CoSimulation, f->token, uri,
                                                   &callbacks, 0, 0);
    else if (new)
        l->instance = ((fmi3InstantiateCoSimulationTYPE *)new)(
            f->name, f->token, path, 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    return l->instance != NULL;
}

/* Sets, or gets, the values of a group; integers and Booleans one by one. */
static int set_all(const Loaded *l, int type, const uint32_t *vr, size_t n, size_t size,
                   const double *values) {
    int status = 0;
    if (type == REAL)
        return fine(CALL(l, fmi2SetReal, fmi2SetRealTYPE, vr, n, values));
    if (type == FLOAT64)
        return fine(CALL(l, fmi3SetFloat64, fmi3SetFloat64TYPE, vr, n, values, size));
    for (size_t i = 0; i < n && fine(status); i++) {
        int whole = values[i] != 0;
        if (type == BOOLEAN && values[i] != 0 && values[i] != 1)
            return 0;
        if (type == INTEGER) {
            if (!(fabs(values[i]) < 0x1p31) || values[i] != floor(values[i]))
                return 0; /* no whole number, or too large a one */
            whole = (int)values[i];
        }
        status = type == INTEGER
                     ? CALL(l, fmi2SetInteger, fmi2SetIntegerTYPE, vr + i, 1, &whole)
                     : CALL(l, fmi2SetBoolean, fmi2SetBooleanTYPE, vr + i, 1, &whole);
    }
    return fine(status);
}

static int get_all(const Loaded *l, int type, const uint32_t *vr, size_t n, size_t size,
                   double *values) {
    int status = 0, whole = 0;
    if (type == REAL)
        return fine(CALL(l, fmi2GetReal, fmi2GetRealTYPE, vr, n, values));
    if (type == FLOAT64)
        return fine(CALL(l, fmi3GetFloat64, fmi3GetFloat64TYPE, vr, n, values, size));
    for (size_t i = 0; i < n && fine(status); i++) {
        status = type == INTEGER
                     ? CALL(l, fmi2GetInteger, fmi2GetIntegerTYPE, vr + i, 1, &whole)
                     : CALL(l, fmi2GetBoolean, fmi2GetBooleanTYPE, vr + i, 1, &whole);
        values[i] = type == INTEGER ? whole : whole != 0;
    }
    return fine(status);
}

/* What the loop calls; 0 if something is refused. */

static int foreign_write(Engine *e, const Foreign *f, int64_t k) {
    const Loaded *l = (Loaded *)e->kernel + f->index;
    for (const Group *g = f->inputs; g < f->inputs + f->n_inputs; g++)
        if (!set_all(l, g->type, g->references, g->n, g->size, e->vector + g->first))
            return stopped(e, NOT_FINITE_STEP, f->part, k);
    return 1;
}

/* One input that comes from outside. */
static inline int foreign_give(Engine *e, const Foreign *f, int64_t k, int type,
                               uint32_t reference, const double *value) {
    const Loaded *l = (Loaded *)e->kernel + f->index;
    return set_all(l, type, &reference, 1, 1, value) ||
           stopped(e, NOT_FINITE_STEP, f->part, k);
}

static int foreign_read(Engine *e, const Foreign *f, int64_t k) {
    const Loaded *l = (Loaded *)e->kernel + f->index;
    for (const Group *g = f->outputs; g < f->outputs + f->n_outputs; g++) {
        double *values = e->vector + g->first;
        if (!get_all(l, g->type, g->references, g->n, g->size, values) ||
            wrong(values, g->size) != 0)
            return stopped(e, NOT_FINITE_STEP, f->part, k);
    }
    return 1;
}

static int foreign_step(Engine *e, const Foreign *f, int64_t k, double t, double h) {
    const Loaded *l = (Loaded *)e->kernel + f->index;
    unsigned char flags[3] = {0}; /* event, ended, early: may be filled with anything */
    double reached = t + h;
    int never = !FOREIGN_STATES; /* whether a step is never taken back */
    int done = fine(f->major == 2
                        ? (int)CALL(l, fmi2DoStep, fmi2DoStepTYPE, t, h, never)
                        : (int)CALL(l, fmi3DoStep, fmi3DoStepTYPE, t, h, never,
                                    (_Bool *)flags, (_Bool *)(flags + 1),
                                    (_Bool *)(flags + 2), &reached));
    return (done && !flags[1] && !flags[2]) || stopped(e, NOT_FINITE_STEP, f->part, k);
}

/* Into initialisation, its inputs into the vector. */
static int foreign_enter(Engine *e, const Foreign *f) {
    Loaded *l = (Loaded *)e->kernel + f->index;
    const double *values = e->parts[f->part].values;
    int done = instantiated(f, l);
    if (done && f->major == 2)
        done = fine(CALL(l, fmi2SetupExperiment, fmi2SetupExperimentTYPE, fmi2False, 0.0, 0.0,
                         fmi2False, 0.0));
    for (size_t i = 0; done && i < f->n_values; i++) {
        const Given *v = f->values + i;
        if (v->given || values[i] != v->start)
            done = set_all(l, v->type, &v->reference, 1, 1, values + i);
    }
    if (done)
        done = fine(f->major == 2 ? (int)CALL_ALONE(l, fmi2EnterInitializationMode,
                                                    fmi2EnterInitializationModeTYPE)
                                  : (int)CALL(l, fmi3EnterInitializationMode,
                                              fmi3EnterInitializationModeTYPE, 0, 0.0, 0.0,
                                              0, 0.0));
    for (const Group *g = f->inputs; done && g < f->inputs + f->n_inputs; g++)
        done = get_all(l, g->type, g->references, g->n, g->size, e->vector + g->first);
    return done || stopped(e, NOT_FINITE_STEP, f->part, 0);
}

static int foreign_leave(Engine *e, const Foreign *f) {
    const Loaded *l = (Loaded *)e->kernel + f->index;
    int status;
    if (!foreign_write(e, f, 0))
        return 0;
    status = f->major == 2 ? (int)CALL_ALONE(l, fmi2ExitInitializationMode,
                                             fmi2ExitInitializationModeTYPE)
                           : (int)CALL_ALONE(l, fmi3ExitInitializationMode,
                                             fmi3ExitInitializationModeTYPE);
    return fine(status) || stopped(e, NOT_FINITE_STEP, f->part, 0);
}
