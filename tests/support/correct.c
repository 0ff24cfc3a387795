/* An FMU that does all that the standard lets it do, and bears nothing that it
   forbids: whoever goes on after an Error, or after the end it announced, meets
   abort().  KIND says what it is besides:

   0 a first-order lag y' = u - y, and arrays s = a u of the length n; an Error ends
     an instance, structural parameters are set in configuration mode only, b is
     Binary (FMI 3)
   1 ends the run by itself after 0.0203 s
   2 is unstable and overflows: y' = 3000 y
   3 is chaotic: Lorenz's equations, y the first of three
   4 wants a stop time
   5 never returns from a step, 6 waits for ever in one
   and two that are not so correct:
   7 counts its steps in y and loses one when a time is 1e-13 too small
   8 always steps by 0.001 s, whatever it is asked for

   Value references: 0 input u, 1 output y, 2 parameter a, 3 output s (FMI 3: arrays),
   4 structural parameter n, 5 parameter b (FMI 3); from 100 on MORE parameters that
   start at 0 (FMI 2).  config.h as for foreign.c. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define EXPORT __attribute__((visibility("default")))
#define LONGEST 8

enum { OK, WARNS, DISCARD, ERROR };
enum { INSTANTIATED = 1, CONFIGURING = 2, INITIALISING = 4, STEPPING = 8, ENDED = 16,
       OVER = 32, FAILED = 64 };

typedef void Logger(void);

typedef struct {
    int phase;
    double u, y, z[2], t;
    double a[LONGEST], more[MORE + 1];
    uint64_t n;
    unsigned char b[2];
    char name[80];
    Logger *logger;
    void *environment;
} Instance;

static int refuse(Instance *s, const char *why) {
#if FMI == 2
    if (s->logger)
        ((void (*)(void *, const char *, int, const char *, const char *, ...))
             s->logger)(s->environment, s->name, ERROR, "logStatusError", why);
#else
    if (s->logger)
        ((void (*)(void *, int, const char *, const char *))s->logger)(
            s->environment, ERROR, "logStatusError", why);
#endif
    s->phase = FAILED;
    return ERROR;
}

/* Whoever calls on after an Error or after the end gets what he deserves. */
static int may(Instance *s, int phases) {
    if (s->phase == FAILED || (s->phase == ENDED && !(phases & ENDED)))
        abort();
    return s->phase & phases;
}

static void start(Instance *s) {
    s->phase = INSTANTIATED;
    s->u = 1.0;
    s->y = KIND == 3 ? 1.0 : 0.5;
    s->z[0] = s->z[1] = 1.0;
    s->t = 0.0;
    s->n = 3;
    for (int i = 0; i < LONGEST; i++)
        s->a[i] = i + 1.0;
    memset(s->more, 0, sizeof s->more);
    s->b[0] = 0x0a;
    s->b[1] = 0x1b;
}

static Instance *create(const char *name, const char *token, Logger *logger,
                        void *environment) {
    Instance *s = calloc(1, sizeof *s);
    start(s);
    s->logger = logger;
    s->environment = environment;
    if (name)
        strncpy(s->name, name, sizeof s->name - 1);
    if (name && *name && token && !strcmp(token, "x"))
        return s;
    refuse(s, "no such name or token");
    free(s);
    return NULL;
}

static void lorenz(double h, double *x, double *y, double *z) {
    const int many = 20;
    for (int i = 0; i < many; i++) {
        double dx = 10 * (*y - *x), dy = *x * (28 - *z) - *y, dz = *x * *y - 8.0 / 3 * *z;
        *x += h / many * dx;
        *y += h / many * dy;
        *z += h / many * dz;
    }
}

static int advance(Instance *s, double t, double h) {
    if (!may(s, STEPPING))
        return refuse(s, "a step now");
    if (!(h > 0) || fabs(t - s->t) > 1e-9)
        return refuse(s, "a step that does not go on");
    if (KIND == 1 && t + h > 0.0203) {
        s->phase = ENDED;
        return DISCARD;
    }
    if (KIND == 5)
        for (volatile int i = 0;; i++)
            ;
    if (KIND == 6)
        for (;;)
            pause();
    if (KIND == 2)
        s->y *= exp(3000 * h);
    else if (KIND == 3)
        lorenz(h, &s->y, s->z, s->z + 1);
    else if (KIND == 7)
        s->y += t + h > (s->y + 0.5) * 1e-3 * (1 - 1e-14) ? 1 : 0;
    else
        s->y = s->u + (s->y - s->u) * exp(KIND == 8 ? -1e-3 : -h);
    s->t = t + h;
    return OK;
}

EXPORT int EXIT(Instance *s) {
    if (!may(s, INITIALISING))
        return refuse(s, "no initialisation to leave");
    s->phase = STEPPING;
    return OK;
}

EXPORT int TERMINATE(Instance *s) {
    if (!may(s, STEPPING | ENDED))
        return refuse(s, "nothing to terminate");
    s->phase = OVER;
    return OK;
}

EXPORT void FREE(Instance *s) {
    free(s);
}

#if FMI == 2

typedef struct {
    Logger *logger;
    void *allocate, *free, *finished, *environment;
} Callbacks;

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid,
                             const char *resources, const Callbacks *callbacks,
                             int visible, int logging) {
    return create(name, guid, logging ? callbacks->logger : NULL,
                  callbacks->environment);
}

EXPORT int fmi2SetupExperiment(Instance *s, int tolerant, double tolerance,
                               double from, int stops, double stop) {
    if (!may(s, INSTANTIATED))
        return refuse(s, "an experiment now");
    if (KIND == 4 && !stops)
        return refuse(s, "a stop time is needed");
    s->t = from;
    return OK;
}

EXPORT int ENTER(Instance *s) {
    if (!may(s, INSTANTIATED))
        return refuse(s, "initialisation now");
    s->phase = INITIALISING;
    return OK;
}

EXPORT int fmi2Reset(Instance *s) {
    start(s);
    return OK;
}

static double *place(Instance *s, unsigned vr) {
    if (vr >= 100 && vr < 100 + MORE)
        return s->more + vr - 100;
    return vr == 0 ? &s->u : vr == 1 ? &s->y : vr == 2 ? s->a : NULL;
}

EXPORT int fmi2GetReal(Instance *s, const unsigned *vr, size_t n, double *v) {
    may(s, ~FAILED);
    for (size_t i = 0; i < n; i++)
        if (!place(s, vr[i]))
            return refuse(s, "no such variable");
        else
            v[i] = *place(s, vr[i]);
    return OK;
}

EXPORT int fmi2SetReal(Instance *s, const unsigned *vr, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++) {
        if (!may(s, INSTANTIATED | INITIALISING | (vr[i] == 0 ? STEPPING : 0)) ||
            vr[i] == 1 || !place(s, vr[i]) || !isfinite(v[i]))
            return refuse(s, "it cannot be set, or not to that");
        *place(s, vr[i]) = v[i];
    }
    return OK;
}

EXPORT int fmi2DoStep(Instance *s, double t, double h, int no_set) {
    return advance(s, t, h);
}

EXPORT int fmi2GetBooleanStatus(Instance *s, int kind, int *value) {
    *value = s->phase == ENDED;
    return kind == 3 ? OK : ERROR;
}

EXPORT int fmi2GetRealStatus(Instance *s, int kind, double *value) {
    *value = s->t;
    return kind == 2 ? OK : ERROR;
}

#define REFUSED(name)                                                              \
    EXPORT int name(Instance *s) {                                                 \
        may(s, ~FAILED);                                                           \
        return refuse(s, #name " is not supported");                               \
    }
REFUSED(fmi2SetRealInputDerivatives)
REFUSED(fmi2GetRealOutputDerivatives)
REFUSED(fmi2GetDirectionalDerivative)
REFUSED(fmi2GetFMUstate)

#else

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token,
                                         const char *resources, _Bool visible,
                                         _Bool logging, _Bool events, _Bool early,
                                         const unsigned *vr, size_t n,
                                         void *environment, Logger *logger,
                                         void *update) {
    return create(name, token, logging ? logger : NULL, environment);
}

EXPORT int ENTER(Instance *s, _Bool tolerant, double tolerance, double from,
                 _Bool stops, double stop) {
    if (!may(s, INSTANTIATED))
        return refuse(s, "initialisation now");
    if (KIND == 4 && !stops)
        return refuse(s, "a stop time is needed");
    s->t = from;
    s->phase = INITIALISING;
    return OK;
}

EXPORT int fmi3EnterConfigurationMode(Instance *s) {
    if (!may(s, INSTANTIATED))
        return refuse(s, "configuration now");
    s->phase = CONFIGURING;
    return OK;
}

EXPORT int fmi3ExitConfigurationMode(Instance *s) {
    if (!may(s, CONFIGURING))
        return refuse(s, "no configuration to leave");
    s->phase = INSTANTIATED;
    return OK;
}

EXPORT int fmi3Reset(Instance *s) {
    start(s);
    return OK;
}

EXPORT int fmi3GetFloat64(Instance *s, const unsigned *vr, size_t n, double *v,
                          size_t left) {
    may(s, ~FAILED);
    for (size_t i = 0; i < n; i++) {
        const size_t size = vr[i] < 2 ? 1 : s->n;
        if (vr[i] > 3 || size > left)
            return refuse(s, "no such variable, or another size");
        for (size_t k = 0; k < size; k++)
            *v++ = vr[i] == 0   ? s->u
                   : vr[i] == 1 ? s->y
                   : vr[i] == 2 ? s->a[k]
                                : s->a[k] * s->u;
        left -= size;
    }
    return left ? refuse(s, "more values than that") : OK;
}

EXPORT int fmi3SetFloat64(Instance *s, const unsigned *vr, size_t n, const double *v,
                          size_t left) {
    for (size_t i = 0; i < n; i++) {
        const size_t size = vr[i] < 2 ? 1 : s->n;
        if (!may(s, INSTANTIATED | INITIALISING | (vr[i] == 0 ? STEPPING : 0)) ||
            (vr[i] != 0 && vr[i] != 2) || size > left)
            return refuse(s, "it cannot be set now, or not so many values");
        for (size_t k = 0; k < size; k++, v++)
            if (!isfinite(*v))
                return refuse(s, "it cannot be set to that");
            else
                *(vr[i] == 0 ? &s->u : s->a + k) = *v;
        left -= size;
    }
    return left ? refuse(s, "more values than that") : OK;
}

EXPORT int fmi3GetUInt64(Instance *s, const unsigned *vr, size_t n, uint64_t *v,
                         size_t left) {
    may(s, ~FAILED);
    if (n != 1 || left != 1 || *vr != 4)
        return refuse(s, "no such variable");
    *v = s->n;
    return OK;
}

EXPORT int fmi3SetUInt64(Instance *s, const unsigned *vr, size_t n, const uint64_t *v,
                         size_t left) {
    if (!may(s, CONFIGURING) || n != 1 || left != 1 || *vr != 4 || !*v || *v > LONGEST)
        return refuse(s, "structural parameters are set in configuration mode");
    s->n = *v;
    return OK;
}

EXPORT int fmi3DoStep(Instance *s, double t, double h, _Bool no_set, _Bool *event,
                      _Bool *ends, _Bool *early, double *reached) {
    int status = advance(s, t, h);
    *event = *early = 0;
    *ends = status == DISCARD;
    *reached = s->t;
    return status == DISCARD ? OK : status;
}

#define REFUSED(name)                                                              \
    EXPORT int name(Instance *s) {                                                 \
        may(s, ~FAILED);                                                           \
        return refuse(s, #name " is not supported");                               \
    }
REFUSED(fmi3GetDirectionalDerivative)
REFUSED(fmi3GetAdjointDerivative)
REFUSED(fmi3GetOutputDerivatives)
REFUSED(fmi3GetFMUState)

#endif

ABSENT
