/* Model exchange, FMI 2.0 and 3.0 (config.h): s is the state x (x' = rate + decay x),
   the time or the input u, as `by` says 0, 1 or 2; z = sign (s - level) is its event
   indicator; `on` is z > 0, renewed in event mode only, `changed` when that was.  With
   `ends` the run is to end where it comes on. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))
#define ERROR 3

enum { X, DER_X, U, ON, CHANGED, CHANGES, RATE, DECAY, BY, SIGN, LEVEL, ENDS, COUNT };

typedef struct {
    double v[COUNT], time;
    int initial;
} Switch;

static void *make(void) {
    Switch *m = calloc(1, sizeof *m);
    m->v[SIGN] = m->v[RATE] = m->initial = 1;
    return m;
}

static double derivative(const Switch *m) {
    return m->v[RATE] + m->v[DECAY] * m->v[X];
}

static double indicator(const Switch *m) {
    double s = m->v[BY] == 0 ? m->v[X] : m->v[BY] == 1 ? m->time : m->v[U];
    return m->v[SIGN] * (s - m->v[LEVEL]);
}

/* Returns whether the run is to end. */
static int update(Switch *m) {
    double on = indicator(m) > 0;
    if (!m->initial && on != m->v[ON]) {
        m->v[CHANGED] = m->time;
        m->v[CHANGES] += 1;
    }
    m->v[ON] = on;
    m->initial = 0;
    return on && m->v[ENDS];
}

static int get(Switch *m, const uint32_t *r, size_t n, double *v) {
    m->v[DER_X] = derivative(m);
    for (size_t k = 0; k < n; k++)
        v[k] = m->v[r[k]];
    return 0;
}

static int set(Switch *m, const uint32_t *r, size_t n, const double *v) {
    for (size_t k = 0; k < n; k++)
        m->v[r[k]] = v[k];
    return 0;
}

EXPORT int ENTER(void *m) { return 0; }
EXPORT int EXIT(Switch *m) { return 0; }
EXPORT int TERMINATE(void *m) { return 0; }
EXPORT void FREE(void *m) { free(m); }

#if FMI == 2
#define NAMED(name) fmi2##name
typedef struct {
    int again, over, nominals, values, timed;
    double when;
} Event;
EXPORT void *fmi2Instantiate(void) { return make(); }
EXPORT int fmi2SetupExperiment(Switch *m) { return 0; }
EXPORT int fmi2GetReal(Switch *m, const uint32_t *r, size_t n, double *v) {
    return get(m, r, n, v);
}
EXPORT int fmi2SetReal(Switch *m, const uint32_t *r, size_t n, const double *v) {
    return set(m, r, n, v);
}
EXPORT int fmi2NewDiscreteStates(Switch *m, Event *event) {
    memset(event, 0, sizeof *event);
    event->over = update(m);
    return 0;
}
EXPORT int fmi2CompletedIntegratorStep(Switch *m, int no, int *event, int *over) {
    return *event = *over = 0;
}
EXPORT int fmi2GetDerivatives(Switch *m, double *dx, size_t n) {
    return dx[0] = derivative(m), 0;
}
#else
#define NAMED(name) fmi3##name
EXPORT void *fmi3InstantiateModelExchange(void) { return make(); }
EXPORT int fmi3GetFloat64(Switch *m, const uint32_t *r, size_t n, double *v, size_t k) {
    return get(m, r, n, v);
}
EXPORT int fmi3SetFloat64(Switch *m, const uint32_t *r, size_t n, const double *v,
                          size_t k) {
    return set(m, r, n, v);
}
EXPORT int fmi3UpdateDiscreteStates(Switch *m, _Bool *again, _Bool *over,
                                    _Bool *nominals, _Bool *values, _Bool *timed,
                                    double *when) {
    *again = *nominals = *values = *timed = 0;
    return *over = update(m), 0;
}
EXPORT int fmi3CompletedIntegratorStep(Switch *m, _Bool no, _Bool *event, _Bool *over) {
    return *event = *over = 0;
}
EXPORT int fmi3GetContinuousStateDerivatives(Switch *m, double *dx, size_t n) {
    return dx[0] = derivative(m), 0;
}
EXPORT int fmi3GetNumberOfContinuousStates(Switch *m, size_t *n) { return *n = 1, 0; }
EXPORT int fmi3GetNumberOfEventIndicators(Switch *m, size_t *n) { return *n = 1, 0; }
#endif

EXPORT int NAMED(EnterEventMode)(Switch *m) { return 0; }
EXPORT int NAMED(EnterContinuousTimeMode)(Switch *m) { return 0; }
EXPORT int NAMED(SetTime)(Switch *m, double t) { return m->time = t, 0; }
EXPORT int NAMED(SetContinuousStates)(Switch *m, const double *x, size_t n) {
    return m->v[X] = x[0], 0;
}
EXPORT int NAMED(GetContinuousStates)(Switch *m, double *x, size_t n) {
    return x[0] = m->v[X], 0;
}
EXPORT int NAMED(GetEventIndicators)(Switch *m, double *z, size_t n) {
    return z[0] = indicator(m), 0;
}
EXPORT int NAMED(GetNominalsOfContinuousStates)(Switch *m, double *x, size_t n) {
    return x[0] = 1, 0;
}

ABSENT
