/* Model exchange, FMI 3.0: n states x with x_i' = i; at its time events k tick, k = 0,
   1, ..., count becomes k and held the input u. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#define EXPORT __attribute__((visibility("default")))
#define ERROR 3

enum { TIME, N, X, DER_X, TICK, U, COUNT, HELD, MOST = 50 };

typedef struct {
    uint64_t n;
    double x[MOST], v[HELD + 1];
    int k;
} Sampler;

EXPORT void *fmi3InstantiateModelExchange(void) {
    Sampler *m = calloc(1, sizeof *m);
    m->n = 2, m->v[TICK] = 1;
    return m;
}
EXPORT void FREE(Sampler *m) { free(m); }
EXPORT int ENTER(Sampler *m) { return 0; }
EXPORT int EXIT(Sampler *m) { return 0; }
EXPORT int TERMINATE(Sampler *m) { return 0; }
EXPORT int fmi3EnterConfigurationMode(Sampler *m) { return 0; }
EXPORT int fmi3ExitConfigurationMode(Sampler *m) { return 0; }
EXPORT int fmi3EnterEventMode(Sampler *m) { return 0; }
EXPORT int fmi3EnterContinuousTimeMode(Sampler *m) { return 0; }

EXPORT int fmi3GetFloat64(Sampler *m, const uint32_t *r, size_t n, double *v,
                          size_t count) {
    for (size_t k = 0; k < n; k++) {
        if (r[k] != X && r[k] != DER_X)
            *v++ = m->v[r[k]];
        else
            for (size_t i = 0; i < m->n; i++)
                *v++ = r[k] == X ? m->x[i] : (double)i + 1;
    }
    return 0;
}
EXPORT int fmi3SetFloat64(Sampler *m, const uint32_t *r, size_t n, const double *v,
                          size_t count) {
    for (size_t k = 0; k < n; k++)
        m->v[r[k]] = v[k];
    return 0;
}
EXPORT int fmi3SetUInt64(Sampler *m, const uint32_t *r, size_t n, const uint64_t *v,
                         size_t count) {
    return m->n = v[0], 0;
}
EXPORT int fmi3GetUInt64(Sampler *m, const uint32_t *r, size_t n, uint64_t *v,
                         size_t count) {
    return v[0] = m->n, 0;
}
EXPORT int fmi3SetTime(Sampler *m, double t) { return m->v[TIME] = t, 0; }

EXPORT int fmi3UpdateDiscreteStates(Sampler *m, _Bool *again, _Bool *over,
                                    _Bool *nominals, _Bool *values, _Bool *timed,
                                    double *when) {
    if (m->v[TIME] >= m->k * m->v[TICK]) {
        m->v[COUNT] = m->k++;
        m->v[HELD] = m->v[U];
    }
    *when = m->k * m->v[TICK];
    *again = *over = *nominals = *values = 0;
    return *timed = 1, 0;
}
EXPORT int fmi3CompletedIntegratorStep(Sampler *m, _Bool no, _Bool *event,
                                       _Bool *over) {
    return *event = *over = 0;
}

EXPORT int fmi3GetNumberOfContinuousStates(Sampler *m, size_t *n) {
    return *n = m->n, 0;
}
EXPORT int fmi3GetNumberOfEventIndicators(Sampler *m, size_t *n) { return *n = 0, 0; }
EXPORT int fmi3GetEventIndicators(Sampler *m, double *z, size_t n) { return 0; }
EXPORT int fmi3GetContinuousStates(Sampler *m, double *x, size_t n) {
    for (size_t i = 0; i < n; i++)
        x[i] = m->x[i];
    return 0;
}
EXPORT int fmi3SetContinuousStates(Sampler *m, const double *x, size_t n) {
    for (size_t i = 0; i < n; i++)
        m->x[i] = x[i];
    return 0;
}
EXPORT int fmi3GetContinuousStateDerivatives(Sampler *m, double *dx, size_t n) {
    for (size_t i = 0; i < n; i++)
        dx[i] = (double)i + 1;
    return 0;
}
EXPORT int fmi3GetNominalsOfContinuousStates(Sampler *m, double *x, size_t n) {
    for (size_t i = 0; i < n; i++)
        x[i] = 1;
    return 0;
}

ABSENT
