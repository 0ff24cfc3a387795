/* A co-simulation FMU, FMI 2.0 and 3.0 (config.h), that ends runs, loses what is set
   and talks.  Numbers by reference: 0 the time it reached, 1 and 2 parameters `how` and
   `at` of its end (s), 3 a parameter `k`, 4 k as it is, 5 an input.

   how: 1 asks to end after a whole step to `at`, 2 within a step, 3 returns early,
   4 discards and says how far it came, 5 discards and has terminated, 6 discards and
   says nothing.  LOSES: 1 in the set-up, 2 entering, 3 leaving initialisation k is 1
   again.  NEEDS_STOP: it refuses an experiment without one.  TALKS: messages a step. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK, DISCARD = 2, ERROR };
enum { T, HOW, AT, K, SEEN, U, COUNT };

typedef void Logger(void);

typedef struct {
    double v[COUNT], last;
    int terminated, logging;
    char name[40];
    Logger *logger;
    void *environment;
} Fmu;

static void say(Fmu *m) {
#if FMI == 2
    ((void (*)(void *, const char *, int, const char *, const char *, ...))m->logger)(
        m->environment, m->name, OK, "talk", "this is step %d of %s, which is fine", 1,
        m->name);
#else
    ((void (*)(void *, int, const char *, const char *))m->logger)(
        m->environment, OK, "talk", "this is a step, which is fine");
#endif
}

static Fmu *make(const char *name, Logger *logger, void *environment, int logging) {
    Fmu *m = calloc(1, sizeof *m);
    strncpy(m->name, name, sizeof m->name - 1);
    m->v[K] = m->v[AT] = 1;
    m->logger = logger;
    m->environment = environment;
    m->logging = logging;
    return m;
}

static int stage(Fmu *m, int number) {
    if (LOSES == number)
        m->v[K] = 1;
    return OK;
}

static int get(Fmu *m, const uint32_t *r, size_t n, double *v) {
    m->v[SEEN] = m->v[K];
    for (size_t i = 0; i < n; i++)
        v[i] = m->v[r[i]];
    return OK;
}

static int set(Fmu *m, const uint32_t *r, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++)
        m->v[r[i]] = v[i];
    return OK;
}

/* Sets where the step came to; returns how it ends, 0 if it does not. */
static int advance(Fmu *m, double t, double h) {
    double end = m->v[AT];
    int how = t + h > end - 1e-9 && m->v[HOW] ? (int)m->v[HOW] : 0;
    for (int i = 0; i < TALKS && m->logging; i++)
        say(m);
    if (how == 1 && t + h > end + 1e-9) /* past a whole step: it has said so */
        abort();
    m->last = m->v[T] = how > 1 ? end : t + h;
    m->terminated = how == 5;
    return how;
}

EXPORT int EXIT(Fmu *m) { return stage(m, 3); }
EXPORT int TERMINATE(Fmu *m) { return OK; }
EXPORT void FREE(Fmu *m) { free(m); }

#if FMI == 2

typedef struct {
    Logger *logger;
    void *allocate, *free, *finished, *environment;
} Callbacks;

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid,
                             const char *resources, const Callbacks *callbacks,
                             int visible, int logging) {
    return make(name, callbacks->logger, callbacks->environment, logging);
}
EXPORT int fmi2SetDebugLogging(Fmu *m, int on, size_t n, const char *const *names) {
    m->logging = on && !n;
    return OK;
}
EXPORT int fmi2SetupExperiment(Fmu *m, int tolerant, double tolerance, double start,
                               int stops, double stop) {
    if (NEEDS_STOP && !stops)
        return ERROR;
    return stage(m, 1);
}
EXPORT int ENTER(Fmu *m) { return stage(m, 2); }
EXPORT int fmi2GetReal(Fmu *m, const uint32_t *r, size_t n, double *v) {
    return get(m, r, n, v);
}
EXPORT int fmi2SetReal(Fmu *m, const uint32_t *r, size_t n, const double *v) {
    return set(m, r, n, v);
}
EXPORT int fmi2DoStep(Fmu *m, double t, double h, int no) {
    return advance(m, t, h) > 1 ? DISCARD : OK;
}
EXPORT int fmi2GetRealStatus(Fmu *m, int kind, double *value) {
    if (kind != 2 || m->v[HOW] == 6)
        return DISCARD;
    *value = m->last;
    return OK;
}
EXPORT int fmi2GetBooleanStatus(Fmu *m, int kind, int *value) {
    if (kind != 3)
        return DISCARD;
    *value = m->terminated;
    return OK;
}

#else

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token,
                                         const char *resources, _Bool visible,
                                         _Bool logging, _Bool events, _Bool early,
                                         const uint32_t *r, size_t n, void *environment,
                                         Logger *logger, void *update) {
    return make(name, logger, environment, logging);
}
EXPORT int fmi3SetDebugLogging(Fmu *m, _Bool on, size_t n, const char *const *names) {
    m->logging = on && !n;
    return OK;
}
EXPORT int ENTER(Fmu *m, _Bool tolerant, double tolerance, double start, _Bool stops,
                 double stop) {
    if (NEEDS_STOP && !stops)
        return ERROR;
    return stage(m, 2);
}
EXPORT int fmi3GetFloat64(Fmu *m, const uint32_t *r, size_t n, double *v, size_t k) {
    return get(m, r, n, v);
}
EXPORT int fmi3SetFloat64(Fmu *m, const uint32_t *r, size_t n, const double *v,
                          size_t k) {
    return set(m, r, n, v);
}
EXPORT int fmi3DoStep(Fmu *m, double t, double h, _Bool no, _Bool *event, _Bool *over,
                      _Bool *early, double *reached) {
    int how = advance(m, t, h);
    *event = 0;
    *over = how == 1 || how == 2 || how == 5;
    *early = how == 3;
    if (how != 6)
        *reached = m->last;
    return how > 3 ? DISCARD : OK;
}

#endif

ABSENT
