/* An FMU with partial derivatives, and with a FAULT in them on demand.

   Inputs a and b (b_1, b_2), state x, in values 0 to 3; below them in values 4 to 7
   y = a b_1 + b_2^2 + x, z = (a^2, b_1 b_2), der(x) = -a x, which FMI 2 does not tell.
   config.h defines FMI, the functions that are absent, and FAULT: 0 none, 1 the
   adjoint is that of the transpose, 2 the directional derivatives remain those of
   the start, 3 they are of the wrong sign, 4 those of
   outputs in time are not a number, 5 they are twice as much; OUTPUTS: 0 a co-simulation shows
   inputs after the step only. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "config.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

enum { OK, ERROR = 3, KNOWNS = 4, UNKNOWNS = 4 };

typedef struct {
    double values[8];
    double start[KNOWNS], rates[UNKNOWNS];
    int exchange;
} Instance;

static void outputs(Instance *s) {
    double *v = s->values;
    v[4] = v[0] * v[1] + v[2] * v[2] + v[3];
    v[5] = v[0] * v[0];
    v[6] = v[1] * v[2];
    v[7] = -v[0] * v[3];
}

static double jacobian(const Instance *s, size_t unknown, size_t known) {
    const double *v = FAULT == 2 ? s->start : s->values;
    const double rows[UNKNOWNS][KNOWNS] = {
        {v[1], v[0], 2 * v[2], 1},
        {2 * v[0], 0, 0, 0},
        {0, v[2], v[1], 0},
        {-v[3], 0, 0, -v[0]},
    };
    return (FAULT == 3 ? -1 : 1) * rows[unknown][known];
}

static Instance *create(int exchange) {
    const double start[] = {1, 2, 3, 1};
    Instance *s = calloc(1, sizeof *s);
    memcpy(s->values, start, sizeof start);
    memcpy(s->start, start, sizeof start);
    s->exchange = exchange;
    outputs(s);
    return s;
}

static int advance(Instance *s, double h) {
    double before[UNKNOWNS];
    memcpy(before, s->values + KNOWNS, sizeof before);
    outputs(s);
    s->values[3] += h * s->values[7];
    outputs(s);
    for (int i = 0; i < UNKNOWNS; i++)
        s->rates[i] = (s->values[KNOWNS + i] - before[i]) / h * (FAULT == 5 ? 2 : 1);
    return OK;
}

/* b, z: two elements under one reference in FMI 3. */
#define SIZE(vr) (FMI == 3 && ((vr) == 1 || (vr) == 5) ? 2u : 1u)

static int get(Instance *s, const unsigned *vr, size_t n, double *to) {
    for (size_t i = 0; i < n; to += SIZE(vr[i]), i++)
        memcpy(to, s->values + vr[i], SIZE(vr[i]) * sizeof *to);
    return OK;
}

static int set(Instance *s, const unsigned *vr, size_t n, const double *from) {
    for (size_t i = 0; i < n; from += SIZE(vr[i]), i++)
        memcpy(s->values + vr[i], from, SIZE(vr[i]) * sizeof *from);
    if (OUTPUTS || s->exchange)
        outputs(s);
    return OK;
}

/* Multiply by the Jacobian matrix, or from the left if it is an adjoint. */
static int multiply(const Instance *s, const unsigned *unknowns, size_t n,
                    const unsigned *knowns, size_t m, const double *seed, double *to,
                    int adjoint) {
    double *row = to, *column = to;
    for (size_t i = 0, p = 0; i < n; i++)
        for (unsigned k = 0; k < SIZE(unknowns[i]); k++, p++)
            for (size_t j = 0, q = 0; j < m; j++)
                for (unsigned l = 0; l < SIZE(knowns[j]); l++, q++) {
                    size_t u = unknowns[i] + k - KNOWNS, v = knowns[j] + l;
                    double entry = adjoint && FAULT == 1 ? jacobian(s, v, u)
                                                         : jacobian(s, u, v);
                    double *target = adjoint ? column + q : row + p;
                    int first = adjoint ? p == 0 : q == 0;
                    *target = (first ? 0 : *target) + entry * seed[adjoint ? p : q];
                }
    return OK;
}

static int rates(const Instance *s, const unsigned *vr, size_t n, double *to) {
    for (size_t i = 0; i < n; i++)
        to[i] = FAULT == 4 ? NAN : s->rates[vr[i] - KNOWNS];
    return OK;
}

EXPORT int ENTER(void *s) {
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

EXPORT void *fmi2Instantiate(void) {
    return create(0);
}

EXPORT int fmi2SetupExperiment(void) {
    return OK;
}

EXPORT int fmi2GetReal(void *s, const unsigned *vr, size_t n, double *v) {
    return get(s, vr, n, v);
}

EXPORT int fmi2SetReal(void *s, const unsigned *vr, size_t n, const double *v) {
    return set(s, vr, n, v);
}

EXPORT int fmi2DoStep(void *s, double t, double h, int no_set) {
    return advance(s, h);
}

EXPORT int fmi2GetDirectionalDerivative(void *s, const unsigned *u, size_t n,
                                        const unsigned *k, size_t m, const double *seed,
                                        double *to) {
    return multiply(s, u, n, k, m, seed, to, 0);
}

EXPORT int fmi2GetRealOutputDerivatives(void *s, const unsigned *vr, size_t n,
                                        const int *order, double *v) {
    return rates(s, vr, n, v);
}

#else

EXPORT int fmi3GetOutputDerivatives(void *s, const unsigned *vr, size_t n,
                                    const int *order, double *v, size_t m) {
    return rates(s, vr, n, v);
}

EXPORT void *fmi3InstantiateCoSimulation(void) {
    return create(0);
}

EXPORT void *fmi3InstantiateModelExchange(void) {
    return create(1);
}

EXPORT int fmi3GetFloat64(void *s, const unsigned *vr, size_t n, double *v, size_t m) {
    return get(s, vr, n, v);
}

EXPORT int fmi3SetFloat64(void *s, const unsigned *vr, size_t n, const double *v,
                          size_t m) {
    return set(s, vr, n, v);
}

EXPORT int fmi3DoStep(void *s, double t, double h, _Bool no_set, _Bool *event,
                      _Bool *ends, _Bool *early, double *reached) {
    *event = *ends = *early = 0;
    *reached = t + h;
    return advance(s, h);
}

EXPORT int fmi3GetDirectionalDerivative(void *s, const unsigned *u, size_t n,
                                        const unsigned *k, size_t m, const double *seed,
                                        size_t seeds, double *to, size_t size) {
    return multiply(s, u, n, k, m, seed, to, 0);
}

EXPORT int fmi3GetAdjointDerivative(void *s, const unsigned *u, size_t n,
                                    const unsigned *k, size_t m, const double *seed,
                                    size_t seeds, double *to, size_t size) {
    return multiply(s, u, n, k, m, seed, to, 1);
}

EXPORT int fmi3UpdateDiscreteStates(void *s, _Bool *again, _Bool *ends, _Bool *nominals,
                                    _Bool *states, _Bool *timed, double *next) {
    *again = *ends = *nominals = *states = *timed = 0;
    return OK;
}

EXPORT int fmi3EnterContinuousTimeMode(void *s) {
    return OK;
}

EXPORT int fmi3EnterEventMode(void *s) {
    return OK;
}

EXPORT int fmi3CompletedIntegratorStep(void *s, _Bool no_set, _Bool *event,
                                       _Bool *ends) {
    *event = *ends = 0;
    return OK;
}

EXPORT int fmi3SetTime(void *s, double t) {
    return OK;
}

EXPORT int fmi3GetNumberOfContinuousStates(void *s, size_t *n) {
    *n = 1;
    return OK;
}

EXPORT int fmi3GetContinuousStates(Instance *s, double *x, size_t n) {
    *x = s->values[3];
    return OK;
}

EXPORT int fmi3SetContinuousStates(Instance *s, const double *x, size_t n) {
    s->values[3] = *x;
    outputs(s);
    return OK;
}

EXPORT int fmi3GetContinuousStateDerivatives(Instance *s, double *x, size_t n) {
    *x = s->values[7];
    return OK;
}

#endif

ABSENT
