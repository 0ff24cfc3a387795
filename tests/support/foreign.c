/* An FMU of every type that copies inputs to outputs, and fails on demand.

   Value references: input i, output 100 + i, for the types in the order of
   TYPES; 20 and 120 an array of two doubles; 130 and 131 the number of steps and
   the length of the last; parameters 50 how and 51 in which
   step it fails: 1 step, 2 get, 3 set, 4 output not a number, 5 wants to end,
   6 warns.  config.h defines FMI as 2 or 3, the
   number of TYPES, and the functions that are absent. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK, WARNS, DISCARD, ERROR };

typedef void Logger(void);

typedef struct {
    unsigned char values[200][16];
    char name[40];
    int step;
    Logger *logger;
    void *environment;
} Instance;

static double number(const Instance *s, unsigned vr) {
    double value;
    memcpy(&value, s->values[vr], sizeof value);
    return value;
}

static int fails(const Instance *s, int how) {
    return (int)number(s, 50) == how && s->step == (int)number(s, 51);
}

static void say(Instance *s, int status, const char *text) {
#if FMI == 2
    ((void (*)(void *, const char *, int, const char *, const char *, ...))s->logger)(
        s->environment, s->name, status, "speech", text);
#else
    ((void (*)(void *, int, const char *, const char *))s->logger)(
        s->environment, status, "speech", text);
#endif
}

/* Outputs begin at 0.1, signed integers at -1, others at the number of the type. */
static Instance *create(const char *name, Logger *logger, void *environment) {
    const double reals[] = {0.1, 0.2};
    const float single = 0.3f;
    Instance *s = calloc(1, sizeof *s);
    for (unsigned i = 1; i < TYPES; i++) {
        int is_signed = FMI == 2 ? i == 1 : i % 2 == 0;
        memset(s->values[100 + i], is_signed ? 0xFF : 0, 16);
        if (!is_signed)
            s->values[100 + i][0] = (unsigned char)i;
    }
    memset(s->values[99 + TYPES], 0, 16);
    s->values[99 + TYPES][0] = 1; /* true */
    memcpy(s->values[100], reals, sizeof *reals);
    memcpy(s->values[120], reals, sizeof reals);
    if (FMI == 3)
        memcpy(s->values[101], &single, sizeof single);
    strncpy(s->name, name, sizeof s->name - 1);
    s->logger = logger;
    s->environment = environment;
    return s;
}

static int advance(Instance *s, double h) {
    const double nan = NAN;
    double steps = ++s->step;
    memcpy(s->values[130], &steps, sizeof steps);
    memcpy(s->values[131], &h, sizeof h);
    memcpy(s->values[100], s->values[0], 30 * 16);
    if (fails(s, 4))
        memcpy(s->values[100], &nan, sizeof nan);
    if (fails(s, 6)) {
        say(s, WARNS, "it is warm");
        return WARNS;
    }
    if (fails(s, 1)) {
        say(s, ERROR, "it is stuck");
        return ERROR;
    }
    return OK;
}

#define SIZE(vr) ((vr) % 100 == 20 ? 2u : 1u)

static int get(Instance *s, const unsigned *vr, size_t n, void *to, size_t size) {
    if (fails(s, 2))
        return ERROR;
    for (size_t i = 0; i < n; i++) {
        memcpy(to, s->values[vr[i]], SIZE(vr[i]) * size);
        to = (char *)to + SIZE(vr[i]) * size;
    }
    return OK;
}

static int set(Instance *s, const unsigned *vr, size_t n, const void *from,
               size_t size) {
    if (fails(s, 3))
        return ERROR;
    for (size_t i = 0; i < n; i++) {
        memcpy(s->values[vr[i]], from, SIZE(vr[i]) * size);
        from = (const char *)from + SIZE(vr[i]) * size;
    }
    return OK;
}

EXPORT int ENTER(void) {
    return OK;
}

EXPORT int EXIT(void *s) {
    return OK;
}

EXPORT int TERMINATE(void *s) {
    return OK;
}

EXPORT void FREE(void *s) {
    free(s);
}

#if FMI == 2

#define ACCESS(Name, T)                                                          \
    EXPORT int fmi2Get##Name(void *s, const unsigned *vr, size_t n, T *v) {      \
        return get(s, vr, n, v, sizeof *v);                                      \
    }                                                                            \
    EXPORT int fmi2Set##Name(void *s, const unsigned *vr, size_t n, const T *v) { \
        return set(s, vr, n, v, sizeof *v);                                      \
    }
ACCESS(Real, double)
ACCESS(Integer, int)
ACCESS(Boolean, int)

typedef struct {
    Logger *logger;
    void *allocate, *free, *finished, *environment;
} Callbacks;

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid,
                             const char *resources, const Callbacks *callbacks,
                             int visible, int logging) {
    return create(name, callbacks->logger, callbacks->environment);
}

EXPORT int fmi2SetupExperiment(void *s, int tolerant, double tolerance, double start,
                               int stops, double stop) {
    return OK;
}

EXPORT int fmi2DoStep(void *s, double t, double h, int no_set) {
    int status = advance(s, h);
    return fails(s, 5) ? DISCARD : status;
}

#else

#define ACCESS(Name, T)                                                          \
    EXPORT int fmi3Get##Name(void *s, const unsigned *vr, size_t n, T *v,        \
                             size_t m) {                                         \
        return get(s, vr, n, v, sizeof *v);                                      \
    }                                                                            \
    EXPORT int fmi3Set##Name(void *s, const unsigned *vr, size_t n, const T *v,  \
                             size_t m) {                                         \
        return set(s, vr, n, v, sizeof *v);                                      \
    }
ACCESS(Float64, double)
ACCESS(Float32, float)
ACCESS(Int8, int8_t)
ACCESS(UInt8, uint8_t)
ACCESS(Int16, int16_t)
ACCESS(UInt16, uint16_t)
ACCESS(Int32, int32_t)
ACCESS(UInt32, uint32_t)
ACCESS(Int64, int64_t)
ACCESS(UInt64, uint64_t)
ACCESS(Boolean, _Bool)

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token,
                                         const char *resources, _Bool visible,
                                         _Bool logging, _Bool events, _Bool early,
                                         const unsigned *vr, size_t n, void *environment,
                                         Logger *logger, void *update) {
    return create(name, logger, environment);
}

EXPORT int fmi3DoStep(void *s, double t, double h, _Bool no_set, _Bool *event,
                      _Bool *ends, _Bool *early, double *reached) {
    int status = advance(s, h);
    *event = *early = 0;
    *ends = fails(s, 5);
    *reached = t + h;
    return status;
}

#endif

ABSENT
